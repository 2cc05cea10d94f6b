"""Keypoints of the action: where the keypoint candidates of all constraints crowd (paper, section III-D)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from sbam.learning.generalization import GeneralizedChange
from sbam.learning.settings import LearningSettings


@dataclass(frozen=True)
class KeypointHistogram:
    """The histogram from which the keypoints are taken.

    Attributes:
        edges: borders of the bins, one more than these, s.
        counts: keypoint candidates per bin.
        filtered: after the low-pass filter.
        peaks: bins that are peaks, increasing.
    """

    edges: Float[np.ndarray, " edges"]
    counts: Float[np.ndarray, " bins"]
    filtered: Float[np.ndarray, " bins"]
    peaks: Int[np.ndarray, " peaks"]

    @property
    def centers(self) -> Float[np.ndarray, " bins"]:
        """Middles of the bins, s."""
        return 0.5 * (self.edges[:-1] + self.edges[1:])


def keypoint_histogram(
    changes: Iterable[GeneralizedChange], duration: float, settings: LearningSettings
) -> KeypointHistogram:
    """Histogram of all keypoints of all changes, low-pass filtered with zero phase, and its most prominent peaks."""
    from scipy.signal import butter, find_peaks, sosfiltfilt

    times = np.concatenate([channel.time for change in changes for channel in change.channels])
    counts, edges = np.histogram(times, settings.keypoint_bins, (0.0, duration))
    counts = counts.astype(np.float64)
    filtered = np.asarray(sosfiltfilt(butter(2, settings.keypoint_cutoff, output="sos"), counts))
    # Padded so that a crowd in the first or last bin is a peak as well.
    padded = np.concatenate([[0.0], filtered, [0.0]])
    prominence = settings.keypoint_prominence * max(float(filtered.max()), np.finfo(float).tiny)
    peaks, properties = find_peaks(padded, prominence=prominence)
    # The filter rings: a peak with no candidate in its bin or beside it is none.
    crowded = np.convolve(counts, np.ones(3), mode="same")[peaks - 1] > 0
    peaks, prominences = peaks[crowded] - 1, properties["prominences"][crowded]
    strongest = np.argsort(-prominences, kind="stable")[: settings.max_peaks]
    return KeypointHistogram(edges, counts, filtered, np.sort(peaks[strongest]))


def keypoint_times(
    histogram: KeypointHistogram, anchors: Float[np.ndarray, " anchors"]
) -> Float[np.ndarray, " keypoints"]:
    """Times of the action's keypoints: the anchors, and the peaks that are not at one.

    Args:
        histogram: see `keypoint_histogram`.
        anchors: s, increasing, with start and end.

    Returns:
        In s, strictly increasing, first and last as in ``anchors``.
    """
    width = histogram.edges[1] - histogram.edges[0]
    centers = histogram.centers[histogram.peaks]
    free = np.abs(centers[:, None] - anchors).min(axis=1, initial=np.inf) > width
    return np.unique(np.concatenate([anchors, centers[free]]))
