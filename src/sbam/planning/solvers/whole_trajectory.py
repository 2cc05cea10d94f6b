"""The default solver: all keypoints at once by re-weighted Gauss-Newton steps with graduated smoothing."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.planning.problem import Problem
from sbam.planning.solvers.linearization import linearize, solve_damped
from sbam.planning.solvers.result import Solution, describe
from sbam.planning.state import State
from sbam.planning.terms import EXACT, Smoothing

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stage:
    """One stage of a descent.

    Attributes:
        smoothing: how the kinks are rounded.
        tolerance: the stage ends when an iteration lowers the merit by less than this share.
    """

    smoothing: Smoothing
    tolerance: float


# Coarse to fine: the optimum sits on kinks of the sum of norms, which a fine smoothing alone does not find.
SCHEDULE = (
    Stage(Smoothing(0.3, 3e-2, 3e-3), 1e-3),
    Stage(Smoothing(0.03, 5e-3, 1e-3), 1e-3),
    Stage(Smoothing(1e-3, 1e-3, 1e-6), 1e-4),
)
POLISH = (Stage(Smoothing(1e-4, 1e-4, 1e-7), 1e-5),)  # for the best start alone: it leaves kinks that are none
MAX_STEP = 0.5  # rad (or m) per iteration and joint


def descend(
    problem: Problem,
    start: Array,
    schedule: Sequence[Stage] = SCHEDULE,
    max_iterations: int = 40,
) -> tuple[State, int]:
    """Descend from one start.

    Args:
        problem: what to minimise.
        start: (K, n) configurations; projected to the limits.
        schedule: stages, coarse to fine.
        max_iterations: most iterations in each stage.

    Returns:
        The final state and the number of linear solves.
    """
    state = problem.state(problem.project(start))
    iterations = 0
    for stage in schedule:
        smoothing = stage.smoothing
        damping = 1e-2
        merit = problem.merit(state, smoothing)
        for _ in range(max_iterations):
            model = linearize(problem, state, smoothing)
            q = state.configurations
            blocked = ((q <= problem.lower) & (model.gradient > 0)) | ((q >= problem.upper) & (model.gradient < 0))
            gain = 0.0
            while damping < 1e6:
                iterations += 1
                step = solve_damped(model, damping, ~blocked)
                longest = np.abs(step).max(axis=1, keepdims=True)
                step *= np.minimum(1.0, MAX_STEP / np.maximum(longest, MAX_STEP))
                candidate = problem.state(problem.project(q + step))
                candidate_merit = problem.merit(candidate, smoothing)
                if np.isfinite(candidate_merit) and candidate_merit < merit:
                    gain, state, merit = merit - candidate_merit, candidate, candidate_merit
                    damping = max(damping / 5.0, 1e-9)
                    break
                damping *= 6.0
            if gain <= stage.tolerance * abs(merit):
                break
    return state, iterations


def sequential(problem: Problem, start: Array, schedule: Sequence[Stage] = SCHEDULE[:1]) -> tuple[Array, int]:
    """Solve keypoint by keypoint, each from the previous solution: the paper's order, and a start for all at once.

    Args:
        problem: what to minimise.
        start: (n,) configuration to start the first keypoint from.
        schedule: stages for each keypoint.

    Returns:
        (K, n) configurations and the number of linear solves.
    """
    previous: State | None = None
    configurations, iterations = np.empty((problem.count, len(start))), 0
    for k in range(problem.count):
        state, used = descend(problem.at(k, previous), start[None], schedule, max_iterations=15)
        previous, start, iterations = state, state.configurations[0], iterations + used
        configurations[k] = start
    return configurations, iterations


def solve_whole_trajectory(problem: Problem, starts: Sequence[Array]) -> Solution:
    """Solve from several starts and keep the best by the exact merit.

    Args:
        problem: what to minimise.
        starts: each (K, n) for all keypoints, or (n,) to be extended by a sequential pass first.

    Returns:
        The best solution.
    """
    begin = time.perf_counter()
    best: State | None = None
    best_merit, iterations = np.inf, 0
    for start in starts:
        if start.ndim == 1:
            start, used = sequential(problem, start)
            iterations += used
        state, used = descend(problem, start)
        iterations += used
        merit = problem.merit(state, EXACT)
        if best is None or merit < best_merit:
            best, best_merit = state, merit
    if best is None:
        raise ValueError("at least one start is needed")
    polished, used = descend(problem, best.configurations, POLISH, max_iterations=25)
    if problem.merit(polished, EXACT) < best_merit:
        best = polished
    iterations += used
    return describe(problem, best, "default", len(starts), iterations, time.perf_counter() - begin)
