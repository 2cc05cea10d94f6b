"""Interpolation of rigid motions: positions linearly, rotations along the shortest great circle (slerp)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from sbam.demonstrations.demonstration import Demonstration
from sbam.errors import DemonstrationError

Array = NDArray[np.float64]

_SAME_TIME = 1e-9
"""Time stamps closer than this are the same, s."""


def interpolate_poses(time: Array, poses: RigidTransform, new_time: Array) -> RigidTransform:
    """Poses at other times; before the first and after the last they are held.

    Args:
        time: (T,) s, strictly increasing.
        poses: T poses.
        new_time: (N,) s.

    Returns:
        N poses; where the times are those given, the poses are unchanged.
    """
    if len(time) == len(new_time) and np.allclose(time, new_time, rtol=0.0, atol=_SAME_TIME):
        return poses
    if len(time) == 1:
        position, xyzw = poses.translation, poses.rotation.as_quat()
        rows = np.zeros(len(new_time), dtype=int)
        return RigidTransform.from_components(position[rows], Rotation.from_quat(xyzw[rows]))
    clipped = np.clip(new_time, time[0], time[-1])
    position = np.stack([np.interp(clipped, time, axis) for axis in poses.translation.T], axis=-1)
    rotation: Rotation = Slerp(time, poses.rotation)(clipped)
    return RigidTransform.from_components(position, rotation)


def resample(demonstration: Demonstration, rate_hz: float) -> Demonstration:
    """The demonstration on an even time axis.

    No low-pass filter is applied: to a much lower rate, smooth first.

    Args:
        demonstration: any.
        rate_hz: frames per second of the result; its last frame is the last multiple of 1/rate within the duration.

    Raises:
        DemonstrationError: if the rate is not positive, or so low that less than two frames would be left.
    """
    if not (np.isfinite(rate_hz) and rate_hz > 0):
        raise DemonstrationError(demonstration.name, f"cannot be resampled at {rate_hz} Hz", "give a positive rate")
    count = int(np.floor((demonstration.duration + _SAME_TIME) * rate_hz)) + 1
    if count < 2:
        raise DemonstrationError(
            demonstration.name, f"lasts {demonstration.duration:.3g} s, which is no two frames at {rate_hz:g} Hz"
        )
    time = np.arange(count) / rate_hz
    old = demonstration.time
    return replace(
        demonstration,
        time=time,
        T_world_object={n: interpolate_poses(old, T, time) for n, T in demonstration.T_world_object.items()},
        T_world_hand={h: interpolate_poses(old, T, time) for h, T in demonstration.T_world_hand.items()},
    )
