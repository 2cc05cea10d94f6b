"""t_s: how far the affordance constraints are from what was learned."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from sbam.constraints import ConstraintType
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Array, Smoothing, Term
from sbam.planning.keypoints.terms.rows import Rows, VectorRows


@dataclass(frozen=True)
class Similarity(Term):
    """t_s(theta) = sum over pairs of sqrt(s_ij) (paper, section III-D), one group per pair of one constraint type.

    Attributes:
        constraint: the type, which knows residual and derivative.
        pairs: (P,) names.
        first: (P,) index of the first region in the workspace.
        second: (P,) index of the second region, -1 for own-start pairs.
        origin: (P, 3) where the first region was at the start, agent frame, m; used for own-start pairs.
        shift: (P, 3) added to the vectors, agent frame, m; moves a support's reference point.
        target: (K, P, C) learned mean, in the channels' units.
        weight: (K, P, C) weight of each channel.
    """

    name: ClassVar[str] = "similarity"
    loss: ClassVar[Literal["norm", "square"]] = "norm"

    constraint: ConstraintType
    pairs: tuple[str, ...]
    first: NDArray[np.int_]
    second: NDArray[np.int_]
    origin: Array
    shift: Array
    target: Array
    weight: Array

    @cached_property
    def _incidence(self) -> Array:
        """(P, R) matrix that takes the first R region centres to vectors: 1 at the first region, -1 at the second."""
        incidence = np.zeros((len(self.pairs), 1 + max(self.first.max(), self.second.max())))
        pairs = np.arange(len(self.pairs))
        incidence[pairs, self.first] = 1.0
        moving = self.second >= 0
        incidence[pairs[moving], self.second[moving]] -= 1.0
        return incidence

    @cached_property
    def _constant(self) -> Array:
        """(P, 3) what does not move: the shift, and the start of own-start pairs, m."""
        return self.shift - np.where(self.second[:, None] >= 0, 0.0, self.origin)

    def vector(self, state: State) -> Array:
        """(K, P, 3) vectors first - second, agent frame, m."""
        incidence = self._incidence
        return incidence @ state.region_position[:, : incidence.shape[1]] + self._constant

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, P, m) residual of each pair."""
        return self.constraint.residual(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)

    def _slope(self, state: State, smoothing: Smoothing) -> Array:
        """(K, P, m, 3) derivative of the residual by the pair's vector."""
        return self.constraint.residual_jacobian(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)

    def _vector_jacobian(self, state: State) -> Array:
        """(K, P, 3, n) derivative of the vectors."""
        w, incidence = state.workspace, self._incidence
        carried = w.carried[w.carried < incidence.shape[1]]
        regions = state.moving_jacobian[:, : len(carried)]
        flat = incidence[:, carried] @ regions.reshape(*regions.shape[:2], -1)
        return flat.reshape(*flat.shape[:2], *regions.shape[2:])

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, P, m, n) by the chain rule through the pair's vector."""
        return self._slope(state, smoothing) @ self._vector_jacobian(state)

    def rows(self, state: State, smoothing: Smoothing, residual: Array, norm: Array | None) -> Rows:
        """The linearised residual; see `VectorRows`."""
        return VectorRows(residual, norm, self._slope(state, smoothing), self._vector_jacobian(state))

    def groups(self) -> tuple[str, ...]:
        """The pairs' names."""
        return self.pairs

    def at(self, keypoint: int, previous: State | None) -> Similarity:
        """The term at one keypoint."""
        k = slice(keypoint, keypoint + 1)
        return replace(self, target=self.target[k], weight=self.weight[k])
