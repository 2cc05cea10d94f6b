"""What the benchmarks share: times, memory, and the planning problem with its floor."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np

import sbam
from sbam.planning.bind import bind
from sbam.planning.keypoints.objective import build_problem
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.terms import Similarity
from sbam.planning.settings import PlanSettings
from sbam.planning.start import in_agent_frame
from sbam.tasks import random_pouring_scene

Mode = Literal["default", "paper"]


def least_seconds(task: Callable[[], object], repetitions: int = 3) -> float:
    """Least processor time of some repetitions; with one thread that is the time on a core of its own."""
    best = np.inf
    for _ in range(repetitions):
        start = time.process_time()
        task()
        best = min(best, time.process_time() - start)
    return best


def peak_megabytes(task: Callable[[], object]) -> float:
    """Most memory that a task holds at once, beside what was there before; it runs several times slower."""
    tracemalloc.start()
    try:
        task()
        return tracemalloc.get_traced_memory()[1] / 1e6
    finally:
        tracemalloc.stop()


@cache
def grasped(seed: int) -> sbam.Plan:
    """A plan of pouring on two Pandas, for its grasps and the posture that holds the objects at their start."""
    demonstrations = sbam.built_in_demonstrations("pouring", seed)
    return sbam.plan(sbam.learn(demonstrations), random_pouring_scene(seed), robot="panda_dual")


def problem_of(constraint: str, mode: Mode, seed: int, keypoints: int = 30) -> tuple[Problem, np.ndarray]:
    """The problem with the pairs of a learning mode, and the configuration that holds the objects at their start."""
    plan = grasped(seed)
    model = sbam.learn(sbam.built_in_demonstrations("pouring", seed), constraint=constraint, mode=mode)
    times = np.linspace(0.0, model.duration, keypoints)
    grasps = {key: grasp.T_object_tcp for key, grasp in plan.grasps.items()}
    task = bind(model, random_pouring_scene(seed))
    return build_problem(task, in_agent_frame(plan.robot), grasps, PlanSettings(), times), plan.solution.configurations[
        0
    ]


def with_pairs(problem: Problem, count: int) -> Problem:
    """The problem with so many pairs of each similarity term, the first ones again where it has fewer."""
    terms = []
    for term in problem.terms:
        if isinstance(term, Similarity):
            some = np.arange(count) % len(term.pairs)
            term = replace(
                term,
                pairs=tuple(f"{term.pairs[i]} {number}" for number, i in enumerate(some)),
                first=term.first[some],
                second=term.second[some],
                origin=term.origin[some],
                shift=term.shift[some],
                target=term.target[:, some],
                weight=term.weight[:, some],
            )
        terms.append(term)
    return replace(problem, terms=tuple(terms))


def floor_task(problem: Problem, start: np.ndarray) -> Callable[[], object]:
    """Kinematics of all keypoints and the Jacobians of the regions alone: no solver can do without them."""
    q = np.tile(start, (problem.count, 1))
    carried, arms = problem.workspace.carried, problem.workspace.region_arm

    def task() -> object:
        state = problem.state(q)
        return state.point_jacobian(state.region_position[:, carried], arms)

    return task


def floor(problem: Problem, start: np.ndarray, repetitions: int = 30) -> float:
    """Seconds of `floor_task`."""
    return least_seconds(floor_task(problem, start), repetitions)
