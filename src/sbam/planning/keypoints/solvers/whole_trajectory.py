"""The default solver: all keypoints at once, by primal-dual Newton steps with graduated smoothing."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.banded import DampedSystem
from sbam.planning.keypoints.solvers.linearization import evaluate, linearize, updated_duals
from sbam.planning.keypoints.solvers.result import Solution, describe
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import Smoothing, Smoothness


@dataclass(frozen=True)
class Stage:
    """One stage of a descent.

    Attributes:
        smoothing: how the kinks are rounded.
        tolerance: the stage ends when an iteration lowers the merit by less than this share.
        curvature: how much of the norms' curvature the model has, 0 to 1 (`linearize`).
        stiffness: coefficient of a further smoothness term, 1/rad^2: it carries all keypoints along together.
    """

    smoothing: Smoothing
    tolerance: float
    curvature: float
    stiffness: float = 0.0


# Coarse to fine: the optimum sits on kinks of the sum of norms, which a fine smoothing alone does not find.
# The norms' curvature counts at last only: closed loops of two arms bend more than a step sees, and with it at once
# they may stop far from the optimum.
# From a motion that is nearly right:
WARM = (
    Stage(Smoothing(1e-2, 2e-3, 3e-6), 1e-3, 0.0),
    Stage(Smoothing(3e-4, 2e-4, 1e-9), 5e-5, 0.8),
)
# From a posture that is no motion yet: the keypoints first find their way together, as if joined by springs.
COLD = (
    Stage(Smoothing(6.0, 0.2, 3e-2), 0.09, 0.0, 6.0),
    Stage(Smoothing(0.2, 3e-3, 1e-2), 0.09, 0.0),
    Stage(Smoothing(2e-3, 3e-4, 1e-9), 1e-3, 0.8),
)
MAX_STEP = 0.5  # rad (or m) per iteration and joint
POOR = 0.5  # share of the promised gain below which a step is corrected for the residuals' curvature
LARGEST_DAMPING = 1e4  # a smaller step would change nothing


def descend(
    problem: Problem,
    start: Float[np.ndarray, "keypoints joints"],
    schedule: Sequence[Stage] = WARM,
    max_iterations: int = 40,
) -> tuple[State, int]:
    """Descend from one start.

    Args:
        problem: what to minimise.
        start: configurations; projected to the limits.
        schedule: stages, coarse to fine.
        max_iterations: most iterations in each stage.

    Returns:
        The final state and the number of linear solves.
    """
    state = problem.state(problem.project(start))
    solves, damping = 0, 1e-2
    duals: list[Float[np.ndarray, "keypoints _groups _rows"] | None] | None = None
    for stage in schedule:
        staged = problem
        if stage.stiffness > 0.0:
            staged = replace(problem, terms=(*problem.terms, Smoothness(stage.stiffness)))
        at = evaluate(staged, state, stage.smoothing)
        for _ in range(max_iterations):
            model = linearize(staged, at, stage.smoothing, duals, stage.curvature)
            q = at.state.configurations
            blocked = ((q <= problem.lower) & (model.gradient > 0)) | ((q >= problem.upper) & (model.gradient < 0))
            merit, growth = at.merit, 4.0
            while damping < LARGEST_DAMPING:
                solves += 1
                system = DampedSystem(model, damping, ~blocked)
                step = _capped(system.step(model.gradient), MAX_STEP)
                candidate = evaluate(staged, problem.state(problem.project(q + step)), stage.smoothing)
                step = candidate.state.configurations - q
                promised = max(model.predicted_gain(step), 1e-12)
                if not merit - candidate.merit > POOR * promised:
                    bent = _capped(system.step(model.bending(step, candidate)), np.abs(step).max(axis=1, keepdims=True))
                    onto = evaluate(staged, problem.state(problem.project(q + step + bent)), stage.smoothing)
                    candidate = onto if onto.merit < candidate.merit else candidate
                if candidate.merit < merit:
                    damping = _damping_after(damping, (merit - candidate.merit) / promised)
                    if stage.curvature > 0.0:
                        duals = updated_duals(model, candidate.state.configurations - q, duals)
                    at = candidate
                    break
                damping *= growth
                growth *= 1.5
            if merit - at.merit <= stage.tolerance * merit:
                break
        state = at.state
        damping = float(np.clip(damping, 1e-5, 1.0))
    return state, solves


def _capped(
    step: Float[np.ndarray, "keypoints joints"], largest: Float[np.ndarray, "keypoints 1"] | float
) -> Float[np.ndarray, "keypoints joints"]:
    """Steps, shortened so that no joint moves by more than ``largest``."""
    longest = np.abs(step).max(axis=1, keepdims=True)
    return step * np.minimum(1.0, largest / np.maximum(longest, 1e-12))


def _damping_after(damping: float, ratio: float) -> float:
    """Levenberg-Marquardt parameter after a step with a given ratio of actual to predicted gain."""
    if ratio > 0.7:
        return max(0.2 * damping, 1e-6)
    return damping if ratio > 0.25 else 2.0 * damping


def solve_whole_trajectory(problem: Problem, starts: Sequence[Float[np.ndarray, "... joints"]]) -> Solution:
    """Solve from several starts and keep the best by the exact merit.

    Args:
        problem: what to minimise.
        starts: each a motion that is nearly right, or one posture to begin with everywhere.

    Returns:
        The best solution.
    """
    begin = time.perf_counter()
    if not starts:
        raise ValueError("at least one start is needed")
    states, iterations = [], 0
    for start in starts:
        everywhere = np.tile(start, (problem.count, 1)) if start.ndim == 1 else start
        state, used = descend(problem, everywhere, COLD if start.ndim == 1 else WARM)
        states.append(state)
        iterations += used
    best = min(states, key=problem.merit) if len(states) > 1 else states[0]
    return describe(problem, best, "default", len(starts), iterations, time.perf_counter() - begin)
