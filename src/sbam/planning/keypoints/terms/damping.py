"""t_d: objects should not move without reason."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float

from sbam.constraints import constraint_type
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.keypoints.terms.rows import Rows, VectorRows


@dataclass(frozen=True)
class Damping(Term):
    r"""t_d: steps of the carried objects' origins p from keypoint to keypoint (paper, section III-D).

    .. math:: t_d(\theta) = \sum_o w'_o \left\lVert p_o - p_o^{\text{previous}} \right\rVert

    Attributes:
        objects: roles of the carried objects, in the workspace's order.
        weight: 1/m.
        start: origins before the first keypoint, agent frame, m.
    """

    name: ClassVar[str] = "damping"
    loss: ClassVar[Literal["norm", "square"]] = "norm"
    couples_neighbours: ClassVar[bool] = True

    objects: tuple[str, ...]
    weight: Float[np.ndarray, "keypoints objects"]
    start: Float[np.ndarray, "objects 3"]

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints objects 3"]:
        """Weighted steps."""
        position = state.object_position
        previous = np.concatenate([self.start[None], position[:-1]])
        return self.weight[..., None] * (position - previous)

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints objects 3 joints"]:
        """See `Term`."""
        return self.weight[..., None, None] * state.object_jacobian

    def previous_jacobian(self, state: State) -> Float[np.ndarray, "keypoints objects 3 joints"]:
        """See `Term`."""
        jacobian = state.object_jacobian
        shifted = np.concatenate([np.zeros_like(jacobian[:1]), jacobian[:-1]])
        return -self.weight[..., None, None] * shifted

    def rows(
        self,
        state: State,
        smoothing: Smoothing,
        residual: Float[np.ndarray, "keypoints objects 3"],
        norm: Float[np.ndarray, "keypoints objects"] | None,
    ) -> Rows:
        """The linearised residual; see `VectorRows`."""
        slope = self.weight[..., None, None] * np.eye(3)
        return VectorRows(residual, norm, slope, state.object_jacobian, coupled=True)

    def groups(self) -> tuple[str, ...]:
        """The objects' roles."""
        return self.objects

    def at(self, keypoint: int, previous: State | None) -> Damping:
        """The term at one keypoint, the previous object positions being constants."""
        start = self.start if previous is None else previous.object_position[-1]
        return replace(self, weight=self.weight[keypoint : keypoint + 1], start=start)

    def epsilon(self, smoothing: Smoothing) -> float:
        """Damping has its own smoothing: its norm is exactly zero at many optima."""
        return smoothing.damping


def damping_terms(context: TermContext) -> list[Damping]:
    """Weight constant in mode ``default``; in mode ``paper`` w'_o = c dt std, with the mean standard deviation."""
    task, times = context.task, context.times
    roles = context.roles
    start = np.array([moved.start.translation for moved in task.moved]).reshape(-1, 3)
    if task.model.mode == "default":
        return [Damping(roles, np.full((len(times), len(roles)), context.settings.damping), start)]
    coefficient = constraint_type(task.model.constraint).paper_damping
    step = np.diff(times, prepend=times[0])
    weight = np.zeros((len(times), len(roles)))
    for i, role in enumerate(roles):
        stds = []
        for change in task.model.changes:
            if role in change.pair.roles:
                scale = np.array([1000.0 if channel.unit == "m" else 1.0 for channel in change.channels])
                stds.append((change.at(times)[1] * scale).mean(axis=1))
        weight[:, i] = 1000.0 * coefficient * step * np.mean(stds, axis=0)
    return [Damping(roles, weight, start)]
