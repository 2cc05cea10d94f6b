"""t_h in joint space: the arms' joints that a person's posture would give."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.keypoints.terms.human_likeness import human_likeness_weight
from sbam.robots.natural_joints import NaturalJoints


@dataclass(frozen=True)
class JointHumanLikeness(Term):
    r"""t_h in joint space (paper, section III-D, as reconstructed).

    .. math:: t_h(\theta) = \lambda_h \sum_{\text{arms}} \mathrm{SOA}_q, \qquad
        \mathrm{SOA}_q = \left\lVert W (q^* - q) \right\rVert

    Attributes:
        weight: lambda_h.
        posture: the robot's reconstruction of SOA_q in joint space.
        arms: names of the arms.
    """

    name: ClassVar[str] = "human-likeness"
    loss: ClassVar[Literal["norm", "square"]] = "norm"
    about_posture: ClassVar[bool] = True

    weight: float
    posture: NaturalJoints
    arms: tuple[str, ...]

    @property
    def frames(self) -> tuple[str, ...]:
        """See `Term`."""
        return self.posture.frames

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints arms 5"]:
        """Weighted differences of the joints."""
        residual = self.posture.residual(state.kinematics, state.configurations)
        return self.weight * residual.reshape(len(residual), len(self.arms), -1)

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints arms 5 joints"]:
        """See `Term`."""
        jacobian = self.posture.jacobian(state.kinematics)
        return self.weight * jacobian.reshape(len(jacobian), len(self.arms), -1, np.shape(jacobian)[-1])

    def groups(self) -> tuple[str, ...]:
        """The arms."""
        return self.arms

    def at(self, keypoint: int, previous: State | None) -> JointHumanLikeness:
        """The same term: it knows no keypoint."""
        return self


def natural_joints_terms(context: TermContext) -> list[JointHumanLikeness]:
    """One term where ``posture`` asks for it and its weight is not 0."""
    weight = human_likeness_weight(context.robot, context.settings)
    if context.free_flight or not weight or context.settings.posture != "joints":
        return []
    return [JointHumanLikeness(weight, NaturalJoints(context.robot), context.arms)]
