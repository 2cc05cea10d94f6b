"""The optimisation problem: a workspace, objective terms and joint limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.planning.state import State, Workspace, planning_limits
from sbam.planning.terms import EXACT, Smoothing, Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """Minimise the sum of the terms over K configurations within the joint limits (paper, equation 1).

    Attributes:
        workspace: robot, carried objects and regions.
        terms: objective terms and requirements.
        count: number K of keypoints.
    """

    workspace: Workspace
    terms: tuple[Term, ...]
    count: int

    @property
    def lower(self) -> Array:
        """(n,) lower joint limits to plan with, rad or m; -inf for continuous joints."""
        return planning_limits(self.workspace.robot)[0]

    @property
    def upper(self) -> Array:
        """(n,) upper joint limits to plan with, rad or m; inf for continuous joints."""
        return planning_limits(self.workspace.robot)[1]

    def project(self, configurations: Array) -> Array:
        """The nearest configurations within the joint limits."""
        return np.clip(configurations, self.lower, self.upper)

    def state(self, configurations: Array) -> State:
        """State of (K, n) configurations."""
        return self.workspace.state(configurations)

    def merit(self, state: State, smoothing: Smoothing = EXACT) -> float:
        """Objective plus requirements: what solvers decrease."""
        return float(sum(term.cost(state, smoothing).sum() for term in self.terms))

    def objective(self, state: State) -> float:
        """The exact objective: all terms without smoothing and without the requirements' penalties."""
        return float(sum(term.cost(state).sum() for term in self.terms if not term.is_requirement))

    def at(self, keypoint: int, previous: State | None) -> Problem:
        """The problem of one keypoint alone, the previous one being solved (the paper's sequential order)."""
        return Problem(self.workspace, tuple(term.at(keypoint, previous) for term in self.terms), 1)
