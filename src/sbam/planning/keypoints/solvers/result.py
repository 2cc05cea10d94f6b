"""What a solver returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.state import State


@dataclass(frozen=True)
class Solution:
    """Optimised configurations and how they were got.

    Attributes:
        configurations: rad or m, within the limits.
        objective: exact objective.
        terms: term -> group -> cost at each keypoint, summed where two terms have both names; requirements are
            the scaled residual's half square.
        active_limits: per keypoint the names of joints that rest on a limit.
        solver: name of the solver.
        starts: number of starts that were tried.
        iterations: linear solves or simplex steps in all.
        seconds: wall time.
    """

    configurations: Float[np.ndarray, "keypoints joints"]
    objective: float
    terms: dict[str, dict[str, Float[np.ndarray, " keypoints"]]]
    active_limits: tuple[tuple[str, ...], ...]
    solver: str
    starts: int
    iterations: int
    seconds: float


def describe(problem: Problem, state: State, solver: str, starts: int, iterations: int, seconds: float) -> Solution:
    """Assemble the solution of a problem from its final state."""
    q = state.configurations
    names = problem.workspace.robot.joint_names
    at_limit = (q <= problem.lower + 1e-6) | (q >= problem.upper - 1e-6)
    terms: dict[str, dict[str, Float[np.ndarray, " keypoints"]]] = {}
    objective = 0.0
    for term in problem.terms:
        cost = term.cost(state)
        objective += 0.0 if term.is_requirement else float(cost.sum())
        groups = terms.setdefault(term.name, {})
        for i, group in enumerate(term.groups()):
            groups[group] = groups[group] + cost[:, i] if group in groups else cost[:, i]
    return Solution(
        configurations=q,
        objective=objective,
        terms=terms,
        active_limits=tuple(
            tuple(name for name, held in zip(names, row, strict=True) if held) for row in at_limit.tolist()
        ),
        solver=solver,
        starts=starts,
        iterations=iterations,
        seconds=seconds,
    )
