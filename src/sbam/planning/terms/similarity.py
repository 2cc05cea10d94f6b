"""t_s: how far the affordance constraints are from what was learned."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from sbam.constraints import ConstraintType
from sbam.planning.state import State
from sbam.planning.terms.base import EXACT, Array, Smoothing, Term


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

    def vector(self, state: State) -> Array:
        """(K, P, 3) vectors first - second, agent frame, m."""
        positions = state.region_position
        return (
            positions[:, self.first]
            + self.shift
            - np.where(self.second[:, None] >= 0, positions[:, np.maximum(self.second, 0)], self.origin)
        )

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, P, m) residual of each pair."""
        return self.constraint.residual(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, P, m, n) by the chain rule through the pair's vector."""
        outer = self.constraint.residual_jacobian(self.vector(state), self.target, self.weight, delta_rho=smoothing.rho)
        inner = state.region_jacobian[:, self.first]
        moving = self.second >= 0
        inner = inner - np.where(moving[:, None, None], state.region_jacobian[:, np.maximum(self.second, 0)], 0.0)
        return outer @ inner

    def groups(self) -> tuple[str, ...]:
        """The pairs' names."""
        return self.pairs

    def at(self, keypoint: int, previous: State | None) -> Similarity:
        """The term at one keypoint."""
        k = slice(keypoint, keypoint + 1)
        return replace(self, target=self.target[k], weight=self.weight[k])
