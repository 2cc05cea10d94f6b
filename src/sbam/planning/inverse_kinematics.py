"""Inverse kinematics of many configurations at once: bounded Gauss-Newton with Levenberg damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.planning.rotation_error import left_jacobian_inverse, rotation_error
from sbam.planning.state import Workspace, planning_limits
from sbam.robots import Robot

Array = NDArray[np.float64]

ROTATION_LENGTH = 0.25  # m: a radian of orientation error counts as much as this length
STALLED = 1e-3  # share of the cost below which a gain ends a stage


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
    workspace = Workspace(robot, (), ())
    columns = np.array([workspace.arms.index(arm) for arm in arms])
    joints = np.flatnonzero(workspace.arm_joints[columns].any(axis=0))
    batch = len(position)
    lowest, highest = planning_limits(robot)
    q = np.clip(np.broadcast_to(start, (batch, len(robot.joint_names))), lowest, highest).astype(float)
    q_reference = q.copy() if reference is None else np.broadcast_to(reference, q.shape)
    lower, upper = lowest[joints], highest[joints]
    for weight in pull:
        active = np.arange(batch)
        damping = np.full(batch, 1e-3)
        error, jacobian = _linearized(workspace, columns, joints, q, position, rotation)
        cost = _cost(error, q[:, joints], q_reference[:, joints], weight)
        for _ in range(iterations):
            current = q[active][:, joints]
            gradient = np.vecmat(error, jacobian) + weight**2 * (current - q_reference[active][:, joints])
            free = ~(((current <= lower) & (gradient > 0)) | ((current >= upper) & (gradient < 0)))
            reduced = jacobian * free[:, None, :]
            normal = np.swapaxes(reduced, 1, 2) @ reduced
            index = np.arange(len(joints))
            normal[:, index, index] += weight**2 + 0.1 * damping[active][:, None] + 1e-12
            step = -np.linalg.solve(normal, (gradient * free)[..., None])[..., 0]
            step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1, keepdims=True), 0.5))
            trial = q[active]
            trial[:, joints] = np.clip(current + step, lower, upper)
            trial_error, trial_jacobian = _linearized(
                workspace, columns, joints, trial, position[active], rotation[active]
            )
            trial_cost = _cost(trial_error, trial[:, joints], q_reference[active][:, joints], weight)
            gain = cost[active] - trial_cost
            better = gain > 0
            q[active[better]], cost[active[better]] = trial[better], trial_cost[better]
            error[better], jacobian[better] = trial_error[better], trial_jacobian[better]
            damping[active] = np.where(better, np.maximum(damping[active] * 0.1, 1e-12), damping[active] * 8.0)
            moving = (gain > STALLED * cost[active]) | (~better & (damping[active] < 1e2))
            moving &= (cost[active] > 1e-15) & (np.abs(step).max(axis=1) > 1e-7)
            active, error, jacobian = active[moving], error[moving], jacobian[moving]
            if len(active) == 0:
                break
    error, _ = _linearized(workspace, columns, joints, q, position, rotation)
    error = error.reshape(batch, len(arms), 6)
    return PoseSolution(
        configurations=q,
        position_error=np.linalg.norm(error[..., :3], axis=-1).max(axis=1),
        rotation_error=np.linalg.norm(error[..., 3:], axis=-1).max(axis=1) / ROTATION_LENGTH,
    )


def _linearized(
    workspace: Workspace,
    columns: NDArray[np.int_],
    joints: NDArray[np.int_],
    q: Array,
    position: Array,
    rotation: Array,
) -> tuple[Array, Array]:
    """Pose errors (B, 6 A) in m and their Jacobian (B, 6 A, joints)."""
    state = workspace.state(q)
    linear = state.kinematics.position[:, columns] - position
    angular = rotation_error(state.kinematics.rotation[:, columns], rotation)
    error = np.concatenate([linear, ROTATION_LENGTH * angular], axis=-1)
    jacobian = np.concatenate(
        [
            state.point_jacobian(state.kinematics.position[:, columns], columns)[..., joints],
            ROTATION_LENGTH * left_jacobian_inverse(angular) @ state.angular_jacobian(columns)[..., joints],
        ],
        axis=-2,
    )
    return error.reshape(len(q), -1), jacobian.reshape(len(q), -1, len(joints))


def _cost(error: Array, q: Array, reference: Array, weight: float) -> Array:
    return np.square(error).sum(axis=-1) + weight**2 * np.square(q - reference).sum(axis=-1)
