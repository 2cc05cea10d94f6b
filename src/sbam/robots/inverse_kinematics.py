"""Inverse kinematics of many configurations at once: bounded Gauss-Newton with Levenberg damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from sbam.robots.description import ArmName
from sbam.robots.jacobian import point_jacobian, rotation_jacobian
from sbam.robots.limits import planning_limits
from sbam.robots.robot import Robot
from sbam.robots.rotation_error import rotation_error

Array = NDArray[np.float64]

ROTATION_LENGTH = 0.25  # m: a radian of orientation error counts as much as this length
STALLED = 1e-3  # share of the cost below which a gain ends a stage
CONVERGED = 1e-5  # share of the cost below which a promised gain is not worth its evaluation


@dataclass(frozen=True)
class PoseSolution:
    """Configurations that bring the tool centre points (TCPs) to their targets.

    Attributes:
        configurations: (B, n) rad or m, within the limits.
        position_error: (B,) largest distance of an arm's TCP from its target, m.
        rotation_error: (B,) largest angle of an arm's TCP to its target, rad.
    """

    configurations: Array
    position_error: Array
    rotation_error: Array

    def reached(
        self, position_tolerance: float = 1e-3, rotation_tolerance: float = np.deg2rad(0.5)
    ) -> NDArray[np.bool_]:
        """(B,) which targets are reached, with the tolerances in m and rad."""
        return (self.position_error < position_tolerance) & (self.rotation_error < rotation_tolerance)


def solve_poses(
    robot: Robot,
    arms: Sequence[str],
    position: Array,
    rotation: Array,
    start: Array,
    reference: Array | None = None,
    pull: Sequence[float] = (3e-2, 1e-4),
    iterations: int = 30,
) -> PoseSolution:
    """Bring arms to poses, as near as possible to reference configurations where the arms are redundant.

    Minimises |p - p*|^2 + (0.25 m angle)^2 + (pull m)^2 |q - q_ref|^2 within the joint limits. The last pull is so weak
    that it only settles the redundancy: it moves the TCP by a few micrometres at most.

    Args:
        robot: the robot, in the frame of the targets.
        arms: A names of arms.
        position: (B, A, 3) target positions of their TCPs, m.
        rotation: (B, A, 3, 3) target orientations.
        start: (B, n) or (n,) configurations to start from.
        reference: (B, n) or (n,) configurations to stay near, default the start.
        pull: weights of the reference, one stage each, m.
        iterations: most steps in each stage.

    Returns:
        The nearest configurations found and how near they come.
    """
    targets = _Targets(robot, arms, position, rotation)
    joints = targets.joints
    lowest, highest = planning_limits(robot)
    q = np.clip(np.broadcast_to(start, (len(position), len(robot.joint_names))), lowest, highest).astype(float)
    q_reference = q[:, joints] if reference is None else np.broadcast_to(reference, q.shape)[:, joints]
    lower, upper = lowest[joints], highest[joints]
    errors, jacobians = targets.linearized(q, np.arange(len(q)))
    for weight in pull:
        # A damping far below the pull changes nothing, but takes many rejected steps to grow again.
        least = 0.1 * weight**2
        active = np.arange(len(q))
        damping = np.full(len(q), 1e-3)
        cost = _cost(errors, q[:, joints] - q_reference, weight)
        for _ in range(iterations):
            error, jacobian = errors[active], jacobians[active]
            current = q[active[:, None], joints]
            gradient = np.vecmat(error, jacobian) + weight**2 * (current - q_reference[active])
            free = ~(((current <= lower) & (gradient > 0)) | ((current >= upper) & (gradient < 0)))
            reduced = jacobian * free[:, None, :]
            normal = np.swapaxes(reduced, 1, 2) @ reduced
            index = np.arange(len(joints))
            normal[:, index, index] += weight**2 + 0.1 * damping[active][:, None] + 1e-12
            gradient *= free
            step = -np.linalg.solve(normal, gradient[..., None])[..., 0]
            promising = -np.vecdot(gradient, step) > CONVERGED * cost[active]
            if not promising.all():
                active, current, step = active[promising], current[promising], step[promising]
                if len(active) == 0:
                    break
            step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 0.5))
            trial = q[active]
            trial[:, joints] = np.clip(current + step, lower, upper)
            trial_error, trial_jacobian = targets.linearized(trial, active)
            trial_cost = _cost(trial_error, trial[:, joints] - q_reference[active], weight)
            gain = cost[active] - trial_cost
            better = gain > 0
            improved = active[better]
            q[improved], cost[improved] = trial[better], trial_cost[better]
            errors[improved], jacobians[improved] = trial_error[better], trial_jacobian[better]
            damping[active] = np.where(better, np.maximum(damping[active] * 0.1, least), damping[active] * 8.0)
            moving = (gain > STALLED * cost[active]) | (~better & (damping[active] < 1e2))
            moving &= (cost[active] > 1e-15) & (np.abs(step).max(axis=1) > 1e-7)
            active = active[moving]
            if len(active) == 0:
                break
    by_arm = errors.reshape(len(q), len(arms), 6)
    return PoseSolution(
        configurations=q,
        position_error=np.linalg.norm(by_arm[..., :3], axis=-1).max(axis=1),
        rotation_error=np.linalg.norm(by_arm[..., 3:], axis=-1).max(axis=1) / ROTATION_LENGTH,
    )


class _Targets:
    """Wanted poses of some arms' tool centre points, and how configurations miss them."""

    def __init__(self, robot: Robot, arms: Sequence[str], position: Array, rotation: Array) -> None:
        self._robot = robot
        self._frames = [robot.arms[cast(ArmName, arm)].tcp_frame for arm in arms]
        masks = np.array([robot.frame_joints(frame) for frame in self._frames])
        shared = np.isin(np.arange(masks.shape[1]), robot.torso_indices)  # they stay where the start has them
        self.joints = np.flatnonzero(masks.any(axis=0) & ~shared)
        self._mask = masks[:, self.joints]
        self._position, self._rotation = position, rotation

    def linearized(self, q: Array, of: NDArray[np.int_]) -> tuple[Array, Array]:
        """Pose errors (B, 6 A) in m of configurations (B, n), and the errors' derivatives (B, 6 A, joints).

        The rotation vector's own derivative is left out: it leaves the gradient of its square as it is.
        """
        kinematics = self._robot.kinematics(q, self._frames)
        kinematics = replace(
            kinematics,
            joint_position=kinematics.joint_position[:, self.joints],
            joint_axis=kinematics.joint_axis[:, self.joints],
            is_prismatic=kinematics.is_prismatic[self.joints],
        )
        linear = kinematics.position - self._position[of]
        angular = rotation_error(kinematics.rotation, self._rotation[of])
        error = np.concatenate([linear, ROTATION_LENGTH * angular], axis=-1)
        jacobian = np.concatenate(
            [
                point_jacobian(kinematics, kinematics.position, self._mask),
                ROTATION_LENGTH * rotation_jacobian(kinematics, self._mask),
            ],
            axis=-2,
        )
        return error.reshape(len(q), -1), jacobian.reshape(len(q), -1, len(self.joints))


def _cost(error: Array, distance: Array, weight: float) -> Array:
    return np.square(error).sum(axis=-1) + weight**2 * np.square(distance).sum(axis=-1)
