"""The optimisation problem: a workspace, objective terms and joint limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State, Workspace
from sbam.planning.keypoints.terms import EXACT, Smoothing, Term
from sbam.robots.limits import planning_limits


@dataclass(frozen=True)
class Problem:
    """Minimise the sum of the terms over all keypoints within the joint limits (paper, equation 1).

    Attributes:
        workspace: robot, carried objects and regions.
        terms: objective terms and requirements.
        count: number of keypoints.
        center: configurations to stay near, or None.
        radius: how far each joint may be from them, rad or m: the trust region of terms that are linearised there.
    """

    workspace: Workspace
    terms: tuple[Term, ...]
    count: int
    center: Float[np.ndarray, "keypoints joints"] | None = None
    radius: float = np.inf

    @cached_property
    def lower(self) -> Float[np.ndarray, "*keypoints joints"]:
        """Lower joint limits to plan with, of all keypoints or of each, rad or m; -inf for continuous joints."""
        limit = planning_limits(self.workspace.robot)[0]
        return limit if self.center is None else np.maximum(limit, self.center - self.radius)

    @cached_property
    def upper(self) -> Float[np.ndarray, "*keypoints joints"]:
        """Upper joint limits to plan with, of all keypoints or of each, rad or m; inf for continuous joints."""
        limit = planning_limits(self.workspace.robot)[1]
        return limit if self.center is None else np.minimum(limit, self.center + self.radius)

    def project(self, configurations: Float[np.ndarray, "*keypoints joints"]) -> Float[np.ndarray, "*keypoints joints"]:
        """The nearest configurations within the joint limits."""
        return np.clip(configurations, self.lower, self.upper)

    def state(self, configurations: Float[np.ndarray, "keypoints joints"]) -> State:
        """State of the configurations of all keypoints."""
        return self.workspace.state(configurations)

    def merit(self, state: State, smoothing: Smoothing = EXACT) -> float:
        """Objective plus requirements: what solvers decrease."""
        return float(sum(term.cost(state, smoothing).sum() for term in self.terms))

    def objective(self, state: State) -> float:
        """The exact objective: all terms without smoothing and without the requirements' penalties."""
        return float(sum(term.cost(state).sum() for term in self.terms if not term.is_requirement))

    def at(self, keypoint: int, previous: State | None) -> Problem:
        """The problem of one keypoint alone, the previous one being solved (the paper's sequential order)."""
        center = None if self.center is None else self.center[keypoint : keypoint + 1]
        terms = tuple(term.at(keypoint, previous) for term in self.terms)
        return replace(self, terms=terms, count=1, center=center)
