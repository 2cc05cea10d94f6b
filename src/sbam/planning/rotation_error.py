"""Difference of two rotations as a vector, with its derivative."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def rotation_error(rotation: Array, target: Array) -> Array:
    """Rotation vector that turns ``target`` into ``rotation``.

    Args:
        rotation: (..., 3, 3) rotation matrices.
        target: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) log(R R*^T), in the frame R and R* map to, rad.
    """
    difference = rotation @ np.swapaxes(target, -1, -2)
    valid = difference.reshape(-1, 3, 3)
    return Rotation.from_matrix(valid, assume_valid=True).as_rotvec().reshape(*difference.shape[:-2], 3)


def left_jacobian_inverse(vector: Array) -> Array:
    """Derivative of a rotation vector with respect to an angular displacement applied from the left.

    Args:
        vector: (..., 3) rotation vector, rad, shorter than 2 pi.

    Returns:
        (..., 3, 3): J_l^-1 = I - [v]/2 + (1/t^2 - (1 + cos t)/(2 t sin t)) [v]^2, t = |v| (Sola et al. 2018, eq. 146).
    """
    angle = np.linalg.norm(vector, axis=-1)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    half = 0.5 * safe
    coefficient = np.where(small, 1.0 / 12.0, (1.0 - half / np.tan(half)) / safe**2)
    skew = np.zeros((*vector.shape[:-1], 3, 3))
    skew[..., 0, 1], skew[..., 0, 2] = -vector[..., 2], vector[..., 1]
    skew[..., 1, 0], skew[..., 1, 2] = vector[..., 2], -vector[..., 0]
    skew[..., 2, 0], skew[..., 2, 1] = -vector[..., 1], vector[..., 0]
    return np.eye(3) - 0.5 * skew + coefficient[..., None, None] * (skew @ skew)
