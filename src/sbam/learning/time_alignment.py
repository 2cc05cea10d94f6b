"""Maps between a demonstration's own time and the model's time, linear between anchors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def warp(time: Array, own_anchor_times: Array, model_anchor_times: Array) -> Array:
    """Map times of a demonstration to the model's time axis (swap the anchors for the way back).

    Args:
        time: any shape, s; times before the first or after the last anchor are clamped to it.
        own_anchor_times: (A,) s, strictly increasing: when the anchors occur in the demonstration.
        model_anchor_times: (A,) s, strictly increasing: when they occur in the model.

    Returns:
        Times on the model's axis, same shape as ``time``, s; strictly monotone between the first and the last anchor.

    Raises:
        ValueError: if the anchors do not correspond or do not increase.
    """
    own, model = np.asarray(own_anchor_times, dtype=float), np.asarray(model_anchor_times, dtype=float)
    if own.ndim != 1 or own.shape != model.shape or len(own) < 2:
        raise ValueError(f"anchor times of shapes {own.shape} and {model.shape}; expected two or more, alike")
    if not (np.all(np.diff(own) > 0) and np.all(np.diff(model) > 0)):
        raise ValueError(f"anchor times must increase strictly: {own.tolist()}, {model.tolist()}")
    return np.interp(time, own, model)
