"""Requirements: what must hold exactly, posed as stiff quadratic terms.

A relative pose is scaled by a length and an angle far below any tolerance, so that the terms that are traded against
each other cannot move it visibly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.context import TermContext
from sbam.planning.keypoints.terms.rows import JointRows, Rows
from sbam.robots.rotation_error import left_jacobian_inverse, rotation_error

POSITION_SCALE = 2e-4  # m: a pull of 1 per 5 mm, the strongest learned one, moves the pose by less than 0.01 mm
ROTATION_SCALE = 2e-3  # rad


def _pose_residual(
    position: Float[np.ndarray, "*batch 3"],
    position_target: Float[np.ndarray, "*batch 3"],
    rotation: Float[np.ndarray, "*batch 3 3"],
    rotation_target: Float[np.ndarray, "*batch 3 3"],
) -> Float[np.ndarray, "*batch 6"]:
    translation = (position - position_target) / POSITION_SCALE
    return np.concatenate([translation, rotation_error(rotation, rotation_target) / ROTATION_SCALE], axis=-1)


@dataclass(frozen=True)
class Resting(Term):
    r"""A carried object stands still while it is not to be moved: before its lift and after it is put down.

    Not in the paper. With the pose :math:`(p, R)` of each object that rests, and the scales of position and rotation:

    .. math:: \tfrac12 \sum_o \left\lVert \tfrac{1}{s_p} (p_o - p_o^*) \right\rVert^2
        + \left\lVert \tfrac{1}{s_R} \log(R_o {R_o^*}^\top) \right\rVert^2

    Attributes:
        objects: roles of the carried objects, in the workspace's order.
        resting: where the requirement applies.
        position: origins where the objects rest, agent frame, m.
        rotation: their orientations, agent frame.
    """

    name: ClassVar[str] = "resting"
    is_requirement: ClassVar[bool] = True

    objects: tuple[str, ...]
    resting: Bool[np.ndarray, "keypoints objects"]
    position: Float[np.ndarray, "keypoints objects 3"]
    rotation: Float[np.ndarray, "keypoints objects 3 3"]

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints objects 6"]:
        """Scaled pose differences, zero where the object may move."""
        still = self.resting
        residual = np.zeros((*still.shape, 6))
        residual[still] = _pose_residual(
            state.object_position[still], self.position[still], state.object_rotation[still], self.rotation[still]
        )
        return residual

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints objects 6 joints"]:
        """See `Term`."""
        still = self.resting
        error = rotation_error(state.object_rotation[still], self.rotation[still])
        jacobian = self._jacobian(state)
        jacobian[still, 3:] = left_jacobian_inverse(error) @ jacobian[still, 3:]
        return jacobian

    def rows(
        self,
        state: State,
        smoothing: Smoothing,
        residual: Float[np.ndarray, "keypoints objects 6"],
        norm: Float[np.ndarray, "keypoints objects"] | None,
    ) -> Rows:
        """The linearised residual, with the rotations' errors v as if they were angular displacements.

        The true derivative has a factor J_l^-1: J_l^-T v = v leaves the gradient exact, and the matrix differs by
        terms of second order in v, which is tiny where this requirement is met.
        """
        jacobian = self._jacobian(state)
        return JointRows(residual, norm, jacobian.reshape(len(residual), -1, jacobian.shape[-1]), None)

    def _jacobian(self, state: State) -> Float[np.ndarray, "keypoints objects 6 joints"]:
        """Scaled linear and angular velocities of what rests, per joint velocity."""
        moving = state.object_jacobian
        jacobian = np.empty((*moving.shape[:2], 6, moving.shape[-1]))
        np.multiply(moving, (self.resting / POSITION_SCALE)[..., None, None], out=jacobian[..., :3, :])
        np.multiply(
            state.object_rotation_jacobian, (self.resting / ROTATION_SCALE)[..., None, None], out=jacobian[..., 3:, :]
        )
        return jacobian

    def groups(self) -> tuple[str, ...]:
        """The objects' roles."""
        return self.objects

    def at(self, keypoint: int, previous: State | None) -> Resting:
        """The term at one keypoint."""
        k = slice(keypoint, keypoint + 1)
        return replace(self, resting=self.resting[k], position=self.position[k], rotation=self.rotation[k])


@dataclass(frozen=True)
class Closure(Term):
    r"""The second hand keeps its grasp of an object that the first hand carries: the loop is closed (section III-D).

    With the second hand's pose :math:`(p, R)` and the pose that its grasp asks of it, given the object's:

    .. math:: \tfrac12 \left\lVert \tfrac{1}{s_p} (p - p^*(\theta)) \right\rVert^2
        + \tfrac12 \left\lVert \tfrac{1}{s_R} \log(R\, R^*(\theta)^\top) \right\rVert^2

    Attributes:
        carrying: index of the carrying whose object is held by both hands.
        arm: index of the second arm in the workspace.
        position: the second TCP in the object's frame, m.
        rotation: its orientation in the object's frame.
    """

    name: ClassVar[str] = "closure"
    is_requirement: ClassVar[bool] = True

    carrying: int
    arm: int
    position: Float[np.ndarray, " 3"]
    rotation: Float[np.ndarray, "3 3"]

    def _wanted(self, state: State) -> tuple[Float[np.ndarray, "keypoints 3"], Float[np.ndarray, "keypoints 3 3"]]:
        rotation = state.object_rotation[:, self.carrying]
        return state.object_position[:, self.carrying] + rotation @ self.position, rotation @ self.rotation

    def residual(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 6"]:
        """Scaled difference of the second TCP from its grasp."""
        position, rotation = self._wanted(state)
        k = state.kinematics
        return _pose_residual(k.position[:, self.arm], position, k.rotation[:, self.arm], rotation)[:, None]

    def jacobian(self, state: State, smoothing: Smoothing = EXACT) -> Float[np.ndarray, "keypoints 1 6 joints"]:
        """See `Term`."""
        position, rotation = self._wanted(state)
        holder, arm = state.workspace.arm_of[[self.carrying]], np.array([self.arm])
        own = state.kinematics.position[:, [self.arm]]
        linear = state.point_jacobian(own, arm) - state.point_jacobian(position[:, None], holder)
        # error = log(R R*^T): an angular displacement of R acts from the left, one of R* through -R R*^T.
        difference = state.kinematics.rotation[:, self.arm] @ np.swapaxes(rotation, -1, -2)
        inverse = left_jacobian_inverse(rotation_error(state.kinematics.rotation[:, self.arm], rotation))[:, None]
        angular = state.angular_jacobian(arm) - difference[:, None] @ state.angular_jacobian(holder)
        return np.concatenate([linear / POSITION_SCALE, inverse @ angular / ROTATION_SCALE], axis=-2)

    def groups(self) -> tuple[str, ...]:
        """One group."""
        return (self.name,)

    def at(self, keypoint: int, previous: State | None) -> Closure:
        """The same term: it knows no keypoint."""
        return self


def resting_terms(context: TermContext) -> list[Resting]:
    """Objects stand still before their lift and after they are put down; not in mode ``paper``."""
    if context.task.model.mode != "default":
        return []
    moved, times, tolerance = context.task.moved, context.times, 1e-9
    before = np.array([times <= one.lift + tolerance for one in moved]).T
    after = np.array([times >= one.place - tolerance for one in moved]).T
    start_position = np.array([one.start.translation for one in moved])
    end_position = np.array([one.put_down.translation for one in moved])
    start_rotation = np.array([one.start.rotation.as_matrix() for one in moved])
    end_rotation = np.array([one.put_down.rotation.as_matrix() for one in moved])
    return [
        Resting(
            objects=context.roles,
            resting=before | after,
            position=np.where(before[..., None], start_position, end_position),
            rotation=np.where(before[..., None, None], start_rotation, end_rotation),
        )
    ]


def closure_terms(context: TermContext) -> list[Closure]:
    """One term per further hand of an object."""
    terms = []
    for index, moved in enumerate(context.task.moved):
        for hand in moved.hands[1:]:
            grasp = context.T_object_tcp[moved.role, hand]
            arm = context.arms.index(hand)
            terms.append(Closure(index, arm, grasp.translation, grasp.rotation.as_matrix()))
    return terms
