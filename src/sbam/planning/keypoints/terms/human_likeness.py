"""t_h: postures that a person would take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Array, Smoothing, Term
from sbam.robots import HumanLikeness as Posture


@dataclass(frozen=True)
class HumanLikeness(Term):
    """t_h(theta) = lambda sum over arms of (1 - u . u*) + (1 - f . f*) (paper, section III-D, as reconstructed).

    With upper arm u and forearm f and their natural directions u*, f* for the hand's position, scaled by arm length.

    Attributes:
        weight: lambda_h.
        posture: the robot's reconstruction of SOA_q.
    """

    name: ClassVar[str] = "human-likeness"

    weight: float
    posture: Posture

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, 1, m) scaled differences of the directions."""
        return np.sqrt(self.weight) * self.posture.residual(state.kinematics)[:, None]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Array:
        """(K, 1, m, n)."""
        return np.sqrt(self.weight) * self.posture.jacobian(state.kinematics)[:, None]

    def groups(self) -> tuple[str, ...]:
        """One group."""
        return (self.name,)

    def at(self, keypoint: int, previous: State | None) -> HumanLikeness:
        """The same term: it knows no keypoint."""
        return self
