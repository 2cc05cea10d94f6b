"""Difference of two rotations as a vector, with its derivative."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TINY = 1e-12  # sine of an angle that equals its sine


def rotation_error(rotation: Array, target: Array) -> Array:
    """Rotation vector that turns ``target`` into ``rotation``.

    Args:
        rotation: (..., 3, 3) rotation matrices.
        target: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) log(R R*^T), in the frame R and R* map to, rad.
    """
    difference = rotation @ np.swapaxes(target, -1, -2)
    # sin(angle) axis; scipy's way over quaternions takes ten times as long, and is needed near half a turn only.
    vector = np.empty(difference.shape[:-1])
    vector[..., 0] = difference[..., 2, 1] - difference[..., 1, 2]
    vector[..., 1] = difference[..., 0, 2] - difference[..., 2, 0]
    vector[..., 2] = difference[..., 1, 0] - difference[..., 0, 1]
    vector *= 0.5
    sine = np.sqrt(np.vecdot(vector, vector))
    cosine = 0.5 * (difference[..., 0, 0] + difference[..., 1, 1] + difference[..., 2, 2] - 1.0)
    vector *= np.where(sine > TINY, np.arctan2(sine, cosine) / np.maximum(sine, TINY), 1.0)[..., None]
    behind = cosine < -0.9
    if behind.any():
        vector[behind] = Rotation.from_matrix(difference[behind], assume_valid=True).as_rotvec()
    return vector


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
