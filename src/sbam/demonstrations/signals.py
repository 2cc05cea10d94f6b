"""Filtering of tracked positions and axes: one even grid, no tracker glitches, zero phase."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = 100.0
"""Rate of the even grid on which everything is detected, Hz."""
POSITION_CUTOFF = 5.0
"""Cut-off frequency for positions, Hz."""
AXIS_CUTOFF = 4.0
"""Cut-off frequency for unit axes, Hz."""
MAX_ACCELERATION = 10.0
"""What people give to objects, m/s^2; a single frame that would need more is a glitch of the tracker."""
MAX_ANGULAR_ACCELERATION = 50.0
"""The same for rotations, rad/s^2."""
POSITION_GLITCH = 0.010
"""A single frame is never a glitch below this deviation from its neighbours, m."""
AXIS_GLITCH = 0.17
"""The same for unit axes, rad."""
_PADDING = 0.5
"""Length of the mirrored padding at both ends of the filter, s."""


class Run(NamedTuple):
    """Samples ``start`` to ``stop`` (exclusive)."""

    start: int
    stop: int


def even_times(time: Array) -> Array:
    """An even grid of about `RATE` from the first to the last of ``time`` (T,) s."""
    count = max(2, round((time[-1] - time[0]) * RATE) + 1)
    return np.linspace(time[0], time[-1], count)


def without_glitches(values: Array, time: Array, floor: float, max_acceleration: float) -> Array:
    """Replace single frames that no hand can have made by the median of themselves and their neighbours.

    Args:
        values: (T, C) positions in m or unit vectors.
        time: (T,) s.
        floor: smallest deviation that counts, in the unit of ``values``.
        max_acceleration: largest plausible second derivative, per s^2.

    Returns:
        (T, C) a copy, changed only where a frame leaves the line through its neighbours implausibly far.
    """
    if len(time) < 3:
        return values
    before, after = np.diff(time)[:-1], np.diff(time)[1:]
    weight = (before / (before + after))[:, None]
    deviation = np.linalg.norm(values[1:-1] - values[:-2] * (1 - weight) - values[2:] * weight, axis=1)
    implausible = deviation > np.maximum(floor, 0.5 * max_acceleration * before * after)
    # The neighbours of a glitch deviate too, but the median leaves them as they are.
    result = values.copy()
    frames = np.flatnonzero(implausible) + 1
    result[frames] = np.median(np.stack([values[frames - 1], values[frames], values[frames + 1]]), axis=0)
    return result


def low_pass(values: Array, cutoff: float) -> Array:
    """Butterworth low-pass of order 2, forwards and backwards (zero phase), along the first axis.

    Args:
        values: (N, C) on the even grid.
        cutoff: Hz.
    """
    from scipy.signal import sosfiltfilt

    padding = min(round(_PADDING * RATE), len(values) - 1)
    return np.asarray(sosfiltfilt(_butterworth(cutoff), values, axis=0, padlen=padding))


@cache
def _butterworth(cutoff: float) -> Array:
    from scipy.signal import butter

    return np.asarray(butter(2, cutoff, fs=RATE, output="sos"))


def resample(values: Array, time: Array, grid: Array) -> Array:
    """Linear interpolation of ``values`` (T, C) at ``time`` (T,) s to ``grid`` (N,) s: (N, C)."""
    return np.stack([np.interp(grid, time, column) for column in values.T], axis=-1)


def smooth_positions(positions: Array, time: Array, grid: Array) -> Array:
    """Positions (T, 3) at ``time`` (T,) s without glitches and noise, on ``grid`` (N,) s: (N, 3) m."""
    clean = without_glitches(positions, time, POSITION_GLITCH, MAX_ACCELERATION)
    return low_pass(resample(clean, time, grid), POSITION_CUTOFF)


def smooth_axes(axes: Array, time: Array, grid: Array) -> Array:
    """Unit vectors (T, 3) at ``time`` (T,) s without glitches and noise, on ``grid`` (N,) s: (N, 3)."""
    clean = without_glitches(axes, time, AXIS_GLITCH, MAX_ANGULAR_ACCELERATION)
    smooth = low_pass(resample(clean, time, grid), AXIS_CUTOFF)
    length = np.linalg.norm(smooth, axis=1, keepdims=True)
    return smooth / np.maximum(length, np.finfo(float).tiny)


def speed(values: Array, grid: Array) -> Array:
    """Norm of the derivative of ``values`` (N, C) on the even ``grid`` (N,) s: (N,) per s."""
    return np.linalg.norm(np.gradient(values, grid, axis=0), axis=1)


def true_runs(mask: NDArray[np.bool_]) -> list[Run]:
    """Runs of True in ``mask`` (N,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [Run(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def bridge(runs: list[Run], gap: float) -> list[Run]:
    """Join runs that are at most ``gap`` s apart."""
    joined: list[Run] = []
    for run in runs:
        if joined and run.start - joined[-1].stop <= gap * RATE:
            joined[-1] = Run(joined[-1].start, run.stop)
        else:
            joined.append(run)
    return joined
