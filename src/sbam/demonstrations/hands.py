"""Hand poses from the markers on a person's hands.

The frame of a hand (both alike with the palms down and the fingers forward): x right, y from the wrist to the knuckles,
z out of the back of the hand; its origin lies midway between the two markers at the knuckles.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sbam.demonstrations.demonstration import Hand

Array = NDArray[np.float64]

WRIST_WEIGHT = 0.1
"""Weight of the wrist against 1 of each knuckle marker: it shows where the back of the hand points, but it also moves
when the hand bends sideways."""
MAX_RESIDUAL = 0.05
"""Frames with a point farther than this from its place are taken as not seen (mistaken markers), m; in KIT recordings
bending the wrist gives up to about 0.03."""


class HandMarkers(NamedTuple):
    """Names of the markers of one hand: knuckles and wrist, each on the side of the little finger and of the thumb."""

    little_knuckle: str
    thumb_knuckle: str
    little_wrist: str
    thumb_wrist: str


HAND_MARKERS: Mapping[Hand, HandMarkers] = {
    "left": HandMarkers("LHPS", "LHTS", "LWPS", "LWTS"),
    "right": HandMarkers("RHPS", "RHTS", "RWPS", "RWTS"),
}
"""The marker set of KIT (Winter/MMM reference model)."""


def fit_hand(markers: Mapping[str, Array], hand: Hand) -> tuple[Array, Array]:
    """Fit the pose of a hand to its markers, rigidly in the least-squares sense.

    Three points are fitted: both knuckle markers and, with less weight, the middle of the wrist, which lies near the
    joint and so stays with the palm when the wrist bends. The shape of the hand is its median over the recording, so
    that the frame is the same throughout.

    Args:
        markers: marker name -> (T, 3) position, world, m; NaN where it was not seen.
        hand: which hand; its `HAND_MARKERS` must be among the markers.

    Returns:
        Position (T, 3) m and rotation as xyzw quaternions (T, 4), world; NaN where a marker is missing or where the
        markers do not have the shape of the hand (residual above `MAX_RESIDUAL`).
    """
    names = HAND_MARKERS[hand]
    little, thumb = markers[names.little_knuckle], markers[names.thumb_knuckle]
    wrist = 0.5 * (markers[names.little_wrist] + markers[names.thumb_wrist])
    points = np.stack([little, thumb, wrist], axis=1)
    position = np.full((len(points), 3), np.nan)
    rotation_xyzw = np.full((len(points), 4), np.nan)
    seen = np.isfinite(points).all(axis=(1, 2))
    if not seen.any():
        return position, rotation_xyzw
    shape = _hand_shape(points[seen], hand)
    rotation, translation, residual = _fit_rigidly(shape, points[seen], np.array([1.0, 1.0, WRIST_WEIGHT]))
    fits = residual < MAX_RESIDUAL
    frames = np.flatnonzero(seen)[fits]
    position[frames] = translation[fits]
    rotation_xyzw[frames] = rotation.as_quat()[fits]
    return position, rotation_xyzw


def _hand_shape(points: Array, hand: Hand) -> Array:
    """Median shape of the points (T, 3, 3), in the frame of the hand: (3, 3) m."""
    little, thumb, wrist = points[:, 0], points[:, 1], points[:, 2]
    origin = 0.5 * (little + thumb)
    x = (thumb - little) if hand == "left" else (little - thumb)
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    y = origin - wrist
    y = y - np.sum(x * y, axis=1, keepdims=True) * x
    y = y / np.linalg.norm(y, axis=1, keepdims=True)
    R_hand_world = np.stack([x, y, np.cross(x, y)], axis=1)
    return np.median((points - origin[:, None]) @ R_hand_world.transpose(0, 2, 1), axis=0)


def _fit_rigidly(shape: Array, points: Array, weight: Array) -> tuple[Rotation, Array, Array]:
    """Weighted least-squares rigid fit of ``shape`` (M, 3) to ``points`` (T, M, 3) (Kabsch, all frames at once).

    Returns:
        Rotations (T), translations (T, 3) and the largest distance of a point from its place (T,), m.
    """
    weight = weight / weight.sum()
    shape_center, center = weight @ shape, np.einsum("m,tmi->ti", weight, points)
    covariance = np.einsum("m,tmi,mj->tij", weight, points - center[:, None], shape - shape_center)
    u, _, vt = np.linalg.svd(covariance)
    vt[:, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    matrix = u @ vt
    translation = center - matrix @ shape_center
    fitted = np.einsum("tij,mj->tmi", matrix, shape) + translation[:, None]
    return Rotation.from_matrix(matrix), translation, np.linalg.norm(points - fitted, axis=2).max(axis=1)
