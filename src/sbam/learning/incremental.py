"""Incremental generalisation of one channel over demonstrations (paper, section III-C)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from sbam.constraints.base import wrap
from sbam.learning.generalization import GeneralizedChannel
from sbam.learning.keypoint_matching import align
from sbam.learning.settings import LearningSettings

_SAME_TIME = 1e-6
"""Keypoints closer than this part of the duration are one."""


def first_demonstration(
    name: str, unit: str, time: Float[np.ndarray, " keypoints"], value: Float[np.ndarray, " keypoints"]
) -> GeneralizedChannel:
    """The generalised channel after one demonstration: its own polyline, standard deviation 0.

    Args:
        name: name of the channel.
        unit: its unit.
        time: s, strictly increasing from 0.
        value: in ``unit``.
    """
    return GeneralizedChannel(name, unit, time.copy(), value.copy(), np.zeros(len(time)), np.ones(len(time), np.int64))


def add_candidates(
    channel: GeneralizedChannel,
    time: Float[np.ndarray, " candidates"],
    value: Float[np.ndarray, " candidates"],
    demonstrations: int,
    settings: LearningSettings,
    anchors: tuple[Int[np.ndarray, " anchors"], Int[np.ndarray, " anchors"]] | None = None,
) -> GeneralizedChannel:
    """Update a generalised channel with the keypoint candidates of one more demonstration.

    Matched keypoints are updated with the candidate; unmatched keypoints with the demonstration's interpolated value;
    unmatched candidates enter with the model's interpolated mean and standard deviation and are then updated alike.

    Args:
        channel: what was learned so far.
        time: s of the candidates, on the model's time axis (or, in ``seconds``, in their own time).
        value: their values; azimuths unwrapped.
        demonstrations: number of demonstrations, the new one included; 2 or more.
        settings: update rule, gap cost, amplitude floors.
        anchors: rows of ``channel`` and columns of the candidates that are the same events; None: the ends.

    Returns:
        The updated channel.
    """
    given = anchors or (np.array([0, len(channel.time) - 1]), np.array([0, len(time) - 1]))
    rows, columns = align(_match_cost(channel, time, value, settings), settings.gap_cost, given).T
    unmatched_row = np.ones(len(channel.time), dtype=bool)
    unmatched_row[rows] = False
    unmatched_column = np.ones(len(time), dtype=bool)
    unmatched_column[columns] = False

    # Values are compared at the same time. Times are averaged with the time between the matched neighbours, which
    # keeps keypoints in order.
    seen = np.interp(channel.time, time, value)
    seen[rows] = value[columns]
    own_time = np.interp(channel.time, channel.time[rows], time[columns])
    entry_time = np.interp(time, time[columns], channel.time[rows])
    apart = np.abs(entry_time[:, None] - channel.time).min(axis=1) > _SAME_TIME * channel.time[-1]
    enter = np.flatnonzero(unmatched_column & apart)
    order = np.argsort(np.concatenate([channel.time, entry_time[enter]]), kind="stable")

    def merged(
        of_model: Float[np.ndarray, " keypoints"], of_candidates: Float[np.ndarray, " entering"]
    ) -> Float[np.ndarray, " merged"]:
        return np.concatenate([of_model, of_candidates])[order]

    old_time = merged(channel.time, entry_time[enter])
    new_time = merged(own_time, time[enter])
    mean = merged(channel.mean, np.interp(time[enter], channel.time, channel.mean))
    std = merged(channel.std, np.interp(time[enter], channel.time, channel.std))
    new_value = merged(seen, value[enter])
    count = np.concatenate([channel.count + ~unmatched_row, np.ones(len(enter), np.int64)])[order]
    mean, std = update_moments(mean, std, new_value, demonstrations, settings.update_rule, channel.unit == "rad")
    new_time = (new_time + (demonstrations - 1) * old_time) / demonstrations
    return replace(channel, time=new_time, mean=mean, std=std, count=count)


def update_moments(
    mean: Float[np.ndarray, " keypoints"],
    std: Float[np.ndarray, " keypoints"],
    value: Float[np.ndarray, " keypoints"],
    demonstrations: int,
    rule: str,
    circular: bool,
) -> tuple[Float[np.ndarray, " keypoints"], Float[np.ndarray, " keypoints"]]:
    """Mean and standard deviation after one more value.

    ``paper``: ``std'^2 = ((v - mean)^2 + (n - 2) std^2) / (n - 1)``; ``welford``, which gives the exact sample
    standard deviation: ``std'^2 = ((v - mean)(v - mean') + (n - 2) std^2) / (n - 1)``.

    Args:
        mean: of n - 1 values.
        std: of n - 1 values.
        value: the n-th value.
        demonstrations: n, 2 or more.
        rule: ``paper`` or ``welford``.
        circular: whether the values are angles, so that differences wrap.
    """
    difference = wrap(value - mean) if circular else value - mean
    n = demonstrations
    factor = (n - 1) / n if rule == "welford" else 1.0
    variance = (factor * difference**2 + (n - 2) * std**2) / (n - 1)
    return mean + difference / n, np.sqrt(variance)


def _match_cost(
    channel: GeneralizedChannel,
    time: Float[np.ndarray, " candidates"],
    value: Float[np.ndarray, " candidates"],
    settings: LearningSettings,
) -> Float[np.ndarray, "keypoints candidates"]:
    """Cost: |dt| / duration + |dv| / amplitude."""
    difference = channel.mean[:, None] - value
    if channel.unit == "rad":
        difference = wrap(difference)
    amplitude = max(np.ptp(channel.mean), np.ptp(value), settings.amplitude_floor(channel.unit))
    duration = max(channel.time[-1], time[-1])
    return np.abs(channel.time[:, None] - time) / duration + np.abs(difference) / amplitude
