"""t_h: postures that a person would take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.settings import PlanSettings
from sbam.robots import NaturalDirections, Robot

DEFAULT_WEIGHT = 3.0  # lambda_h of robots whose arms are like a person's


def human_likeness_weight(robot: Robot, settings: PlanSettings) -> float:
    """lambda_h for a robot: as set, else the default for robots whose arms are like a person's and 0 for others."""
    if settings.human_likeness is not None:
        return settings.human_likeness
    return DEFAULT_WEIGHT if robot.description.human_likeness else 0.0


@dataclass(frozen=True)
class HumanLikeness(Term):
    r"""t_h: directions of upper arm u and forearm f (paper, section III-D, as reconstructed).

    .. math:: t_h(\theta) = \lambda_h \sum_{\text{arms}} (1 - u \cdot u^*) + (1 - f \cdot f^*)

    with their natural directions :math:`u^*, f^*` for the hand's position, scaled by arm length.

    Attributes:
        weight: lambda_h.
        posture: the robot's reconstruction of SOA_q.
    """

    name: ClassVar[str] = "human-likeness"
    about_posture: ClassVar[bool] = True

    weight: float
    posture: NaturalDirections

    @property
    def frames(self) -> tuple[str, ...]:
        """See `Term`."""
        return self.posture.frames

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 rows"]:
        """Scaled differences of the directions."""
        return np.sqrt(self.weight) * self.posture.residual(state.kinematics)[:, None]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 rows joints"]:
        """See `Term`."""
        return np.sqrt(self.weight) * self.posture.jacobian(state.kinematics)[:, None]

    def groups(self) -> tuple[str, ...]:
        """One group."""
        return (self.name,)

    def at(self, keypoint: int, previous: State | None) -> HumanLikeness:
        """The same term: it knows no keypoint."""
        return self


def human_likeness_terms(context: TermContext) -> list[HumanLikeness]:
    """One term, unless its weight is 0 or ``posture`` asks for `JointHumanLikeness` instead."""
    weight = human_likeness_weight(context.robot, context.settings)
    if context.free_flight or not weight or context.settings.posture != "directions":
        return []
    return [HumanLikeness(weight, NaturalDirections(context.robot))]
