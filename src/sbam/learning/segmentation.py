"""Piecewise-linear segmentation of a channel over time (paper, section III-B)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

_FIRST_SPLITS = 16
"""Split points that are tried at first, evenly spread..."""
_REFINEMENT = 6
"""...and by how much the spacing around the best shrinks each time, until it is one sample."""
_SAMPLES_PER_STRIDE = 4
"""Samples between two neighbouring split points that count for the area, at least."""


def segment(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    threshold: float,
    knots: Sequence[int] | Int[np.ndarray, " knots"] = (),
) -> Int[np.ndarray, " kept"]:
    """Samples that a polyline must keep: top-down by area, then one pass that drops or moves each split point.

    Args:
        time: s, strictly increasing.
        value: samples of one channel.
        threshold: largest area between the samples and one segment, unit of ``value`` times s.
        knots: samples that are kept in any case.

    Returns:
        Indices of the kept samples, increasing, with the first and the last.
    """
    fixed = {0, len(time) - 1, *(int(knot) for knot in knots)}
    borders = sorted(fixed)
    weight = _trapezoid_weights(time)
    kept = set(borders)
    open_segments = list(pairwise(borders))
    while open_segments:
        start, end = open_segments.pop()
        if end - start > 1 and _area(time, value, weight, start, end) > threshold:
            split = _best_split(time, value, weight, start, end)
            kept.add(split)
            open_segments += [(start, split), (split, end)]
    return np.array(_final_pass(time, value, weight, threshold, sorted(kept), fixed), dtype=np.int64)


def _final_pass(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
    threshold: float,
    points: list[int],
    fixed: set[int],
) -> list[int]:
    result = [points[0]]
    for point, after in pairwise(points[1:]):
        if point in fixed:
            result.append(point)
        elif _area(time, value, weight, result[-1], after) > threshold:
            result.append(_best_split(time, value, weight, result[-1], after))
    return [*result, points[-1]]


def _trapezoid_weights(time: Float[np.ndarray, " samples"]) -> Float[np.ndarray, " samples"]:
    """Weights with which samples add up to an area."""
    step = np.diff(time)
    weight = np.zeros_like(time)
    weight[:-1] += 0.5 * step
    weight[1:] += 0.5 * step
    return weight


def _area(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
    start: int,
    end: int,
) -> float:
    """Area between the samples and the chord from sample ``start`` to ``end``."""
    t, y = time[start : end + 1], value[start : end + 1]
    slope = (y[-1] - y[0]) / (t[-1] - t[0])
    return float(np.abs(y - y[0] - slope * (t - t[0])) @ weight[start : end + 1])


def _best_split(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
    start: int,
    end: int,
) -> int:
    """The sample between ``start`` and ``end`` with the least area to the two chords that meet there."""
    stride = -(-(end - start - 1) // _FIRST_SPLITS)
    splits = np.arange(start + 1 + (stride - 1) // 2, end, stride)
    while True:
        # While splits are far apart their areas need not be exact either.
        areas = _split_areas(time, value, weight, start, end, splits, -(-stride // _SAMPLES_PER_STRIDE))
        best = int(splits[areas.argmin()])
        if stride == 1:
            return best
        first, last = max(start + 1, best - stride + 1), min(end, best + stride)
        stride = -(-stride // _REFINEMENT)
        splits = np.arange(first, last, stride)


def _split_areas(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    weight: Float[np.ndarray, " samples"],
    start: int,
    end: int,
    splits: Int[np.ndarray, " splits"],
    step: int,
) -> Float[np.ndarray, " splits"]:
    """Area between every ``step``-th sample and the chords start - split - end for each split, up to a factor."""
    t, y = time[start : end + 1 : step], value[start : end + 1 : step]
    t_split, y_split = time[splits, None], value[splits, None]
    before = (y_split - value[start]) / (t_split - time[start])
    after = (value[end] - y_split) / (time[end] - t_split)
    deviation = np.where(t < t_split, before, after)
    deviation *= t - t_split
    deviation -= y
    deviation += y_split
    return np.abs(deviation, out=deviation) @ weight[start : end + 1 : step]
