"""Jacobians of points and rotations, for all configurations at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.robots.robot import Kinematics

Floats = NDArray[np.float64]


def point_jacobian(kinematics: Kinematics, points: Floats, mask: NDArray[np.bool_]) -> Floats:
    """Derivative of points that move with links, with respect to the joints.

    A turning joint moves a point by ``axis x (point - anchor)``, a sliding one by ``axis``.

    Args:
        kinematics: of B configurations.
        points: (B, ..., 3) positions in the world, m; any points fixed to the links.
        mask: (..., n) joints that move each link (`Robot.frame_joints`).

    Returns:
        (B, ..., 3, n) m/rad, or m/m for prismatic joints; zero for joints that do not move the link.
    """
    axis = _columns(kinematics.joint_axis, points.ndim - 2)
    lever = points[..., None] - _columns(kinematics.joint_position, points.ndim - 2)
    jacobian = np.empty_like(lever)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        jacobian[..., i, :] = axis[..., j, :] * lever[..., k, :] - axis[..., k, :] * lever[..., j, :]
    if kinematics.is_prismatic.any():
        sliding = kinematics.is_prismatic
        jacobian[..., sliding] = np.broadcast_to(axis, jacobian.shape)[..., sliding]
    jacobian *= mask[..., None, :]
    return jacobian


def rotation_jacobian(kinematics: Kinematics, mask: NDArray[np.bool_]) -> Floats:
    """Angular velocity of links in world axes, per unit of joint velocity.

    Args:
        kinematics: of B configurations.
        mask: (..., n) joints that move each link (`Robot.frame_joints`).

    Returns:
        (B, ..., 3, n) rad/rad; 0 for prismatic joints.
    """
    turning = mask & ~kinematics.is_prismatic
    return _columns(kinematics.joint_axis, mask.ndim - 1) * turning[..., None, :]


def _columns(vectors: Floats, more: int) -> Floats:
    """Vectors (B, n, 3) of the joints as columns (B, 1, ..., 3, n), with ``more`` axes for several points."""
    columns = vectors.swapaxes(1, 2)
    return columns.reshape(len(columns), *(1,) * more, *columns.shape[1:])
