"""Jacobians of points and rotations, for all configurations at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.robots.robot import Kinematics

Floats = NDArray[np.float64]


def point_jacobian(kinematics: Kinematics, points: Floats, mask: NDArray[np.bool_]) -> Floats:
    """Derivative of points that move with a link, with respect to the joints.

    A turning joint moves the point by ``axis x (point - anchor)``, a sliding one by ``axis``.

    Args:
        kinematics: of B configurations.
        points: (B, 3) positions in the world, m; any point fixed to the link.
        mask: (n,) joints that move the link (`Robot.frame_joints`).

    Returns:
        (B, 3, n) m/rad, or m/m for prismatic joints.
    """
    columns = np.flatnonzero(mask)
    axis = kinematics.joint_axis[:, columns]
    lever = points[:, None, :] - kinematics.joint_position[:, columns]
    block = np.empty((len(points), 3, len(columns)))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        block[:, i] = axis[..., j] * lever[..., k] - axis[..., k] * lever[..., j]
    sliding = kinematics.is_prismatic[columns]
    if sliding.any():
        block[:, :, sliding] = axis[:, sliding].swapaxes(1, 2)
    jacobian = np.zeros((len(points), 3, len(mask)))
    jacobian[:, :, columns] = block
    return jacobian


def rotation_jacobian(kinematics: Kinematics, mask: NDArray[np.bool_]) -> Floats:
    """Angular velocity of a link in world axes, per unit of joint velocity.

    Args:
        kinematics: of B configurations.
        mask: (n,) joints that move the link (`Robot.frame_joints`).

    Returns:
        (B, 3, n) rad/rad; 0 for prismatic joints.
    """
    moving = mask & ~kinematics.is_prismatic
    return np.where(moving, kinematics.joint_axis.swapaxes(1, 2), 0.0)
