"""Arms and what they carry keep a distance from what they must not touch."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term

SCALE = 2e-3  # m: soft beside `Resting` and `Closure`, which it must not bend where a distance cannot be had


@dataclass(frozen=True)
class Clearance(Term):
    r"""Missing distances of pairs of shapes that were near at a linearisation point; not in the paper.

    .. math:: \tfrac12 \sum_i \left( \max(0, m - d_i) / s \right)^2

    with the margin :math:`m` and the scale :math:`s` of `SCALE`. A pair was near at a moment between the keypoints
    :math:`k - 1` and :math:`k`; moving these keypoints changes its distance by

    .. math:: \nabla d_i \cdot \left( (1 - \lambda)\, \Delta q_{k-1} + \lambda\, \Delta q_k \right)

    with the share :math:`\lambda` of the interval that has passed, as in sequential convex optimisation of trajectories
    (Schulman et al. 2014). Shorter lists are filled up with infinite distances.

    Attributes:
        configurations: the linearisation point.
        distance: of the pairs in the interval that ends at each keypoint, m; negative in penetration.
        fraction: share of the interval that has passed.
        gradient: of the distance with respect to the configuration at that moment, m/rad.
        margin: the distance wanted, m.
    """

    name: ClassVar[str] = "clearance"
    couples_neighbours: ClassVar[bool] = True
    is_requirement: ClassVar[bool] = True

    configurations: Float[np.ndarray, "keypoints joints"]
    distance: Float[np.ndarray, "keypoints groups"]
    fraction: Float[np.ndarray, "keypoints groups"]
    gradient: Float[np.ndarray, "keypoints groups joints"]
    margin: float

    def _missing(self, state: State) -> Float[np.ndarray, "keypoints groups"]:
        """What the linearised distances fall short of the margin, m; negative where they do not."""
        step = state.configurations - self.configurations
        before = np.concatenate([np.zeros_like(step[:1]), step[:-1]])
        change = (1.0 - self.fraction) * np.matvec(self.gradient, before)
        change += self.fraction * np.matvec(self.gradient, step)
        return self.margin - self.distance - change

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints groups 1"]:
        """Missing distances in scales."""
        return np.maximum(self._missing(state), 0.0)[..., None] / SCALE

    def _slope(
        self, state: State, share: Float[np.ndarray, "keypoints groups"]
    ) -> Float[np.ndarray, "keypoints groups 1 joints"]:
        active = self._missing(state) > 0.0
        return (-np.where(active, share, 0.0)[..., None] * self.gradient / SCALE)[..., None, :]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints groups 1 joints"]:
        """See `Term`."""
        return self._slope(state, self.fraction)

    def previous_jacobian(self, state: State) -> Float[np.ndarray, "keypoints groups 1 joints"]:
        """See `Term`."""
        return self._slope(state, 1.0 - self.fraction)

    def groups(self) -> tuple[str, ...]:
        """Numbers of the pairs within an interval."""
        return tuple(str(i) for i in range(self.distance.shape[1]))

    def at(self, keypoint: int, previous: State | None) -> Clearance:
        """The term at one keypoint, the previous configuration being a constant."""
        k = slice(keypoint, keypoint + 1)
        distance = self.distance[k]
        if previous is not None:
            moved = previous.configurations[-1] - self.configurations[keypoint - 1]
            distance = distance + (1.0 - self.fraction[k]) * (self.gradient[k] @ moved)
        return replace(
            self,
            configurations=self.configurations[k],
            distance=distance,
            fraction=self.fraction[k],
            gradient=self.gradient[k],
        )
