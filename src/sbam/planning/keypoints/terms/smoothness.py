"""Small steps of the joints between keypoints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.keypoints.terms.rows import Rows, StepRows


@dataclass(frozen=True)
class Smoothness(Term):
    r"""Squared steps of the joints: settles redundancy and avoids branch switches; not in the paper.

    .. math:: c \sum_k \left\lVert q_k - q_{k-1} \right\rVert^2

    Attributes:
        coefficient: c, 1/rad^2 (or 1/m^2).
        start: configuration before the first keypoint, or None to leave the first one free.
    """

    name: ClassVar[str] = "smoothness"
    couples_neighbours: ClassVar[bool] = True

    coefficient: float
    start: Float[np.ndarray, " joints"] | None = None

    @property
    def _scale(self) -> float:
        return float(np.sqrt(2.0 * self.coefficient))

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 joints"]:
        """Scaled steps."""
        q = state.configurations
        first = q[:1] if self.start is None else self.start[None]
        return self._scale * (q - np.concatenate([first, q[:-1]]))[:, None, :]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 joints joints"]:
        """See `Term`."""
        count, joints = state.configurations.shape
        jacobian = np.zeros((count, 1, joints, joints))
        jacobian[0 if self.start is not None else 1 :] = self._scale * np.eye(joints)
        return jacobian

    def previous_jacobian(self, state: State) -> Float[np.ndarray, "keypoints 1 joints joints"]:
        """See `Term`."""
        count, joints = state.configurations.shape
        return np.broadcast_to(-self._scale * np.eye(joints), (count, 1, joints, joints))

    def rows(
        self,
        state: State,
        smoothing: Smoothing,
        residual: Float[np.ndarray, "keypoints 1 joints"],
        norm: Float[np.ndarray, "keypoints 1"] | None,
    ) -> Rows:
        """The linearised residual; see `StepRows`."""
        return StepRows(residual, norm, self._scale, self.start is not None)

    def groups(self) -> tuple[str, ...]:
        """One group."""
        return (self.name,)

    def at(self, keypoint: int, previous: State | None) -> Smoothness:
        """The term at one keypoint, the previous configuration being a constant."""
        return self if previous is None else replace(self, start=previous.configurations[-1])


def smoothness_terms(context: TermContext) -> list[Smoothness]:
    """One term in mode ``default``."""
    return [Smoothness(context.settings.smoothness)] if context.task.model.mode == "default" else []
