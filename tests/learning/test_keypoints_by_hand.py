"""The histogram of keypoint candidates where the result is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from sbam.constraints import RegionPair, RegionReference
from sbam.learning import GeneralizedChange, GeneralizedChannel, LearningSettings
from sbam.learning.keypoints import KeypointHistogram, keypoint_histogram, keypoint_times

TEN = replace(LearningSettings.default(), keypoint_bins=10)


def change(*times) -> GeneralizedChange:
    channels = tuple(
        GeneralizedChannel("x", "m", np.array(t), np.zeros(len(t)), np.zeros(len(t)), np.ones(len(t), np.int64))
        for t in times
    )
    return GeneralizedChange(RegionPair(RegionReference("a", "b"), None), "cartesian", channels)


def test_candidates_of_all_channels_of_all_changes_are_counted():
    changes = [change([0.0, 1.5, 10.0], [0.0, 1.6, 10.0]), change([0.0, 7.2, 10.0])]
    histogram = keypoint_histogram(changes, 10.0, TEN)
    assert histogram.counts.tolist() == [3, 2, 0, 0, 0, 0, 0, 1, 0, 3]
    np.testing.assert_allclose(histogram.edges, np.arange(11.0))
    np.testing.assert_allclose(histogram.centers, np.arange(10) + 0.5)


def test_the_filter_is_butterworth_of_order_two_forwards_and_backwards():
    generator = np.random.default_rng(0)
    times = np.sort(generator.uniform(0.0, 10.0, 300))
    histogram = keypoint_histogram([change(times)], 10.0, LearningSettings.default())
    expected = sosfiltfilt(butter(2, 0.7, output="sos"), np.histogram(times, 100, (0.0, 10.0))[0].astype(float))
    np.testing.assert_allclose(histogram.filtered, expected)


def test_crowds_in_the_first_and_the_last_bin_are_peaks():
    histogram = keypoint_histogram([change([0.0, 10.0])] * 9, 10.0, LearningSettings.default())
    assert {0, 99} <= set(histogram.peaks.tolist())


def test_where_no_candidate_is_near_there_is_no_peak():
    """The filter's ringing beside a large crowd stays below."""
    histogram = keypoint_histogram([change([0.0, 5.05, 10.0])] * 50, 10.0, LearningSettings.default())
    near = np.convolve(histogram.counts, np.ones(3), mode="same")
    assert histogram.peaks.tolist() == [0, 50, 99]
    assert (near[histogram.peaks] > 0).all()


def test_the_most_prominent_peaks_stay():
    crowds = [[2.05] * 30, [4.05] * 10, [6.05] * 20, [8.05] * 5]
    times = np.sort(np.concatenate(crowds))
    settings = replace(LearningSettings.default(), max_peaks=2)
    assert keypoint_histogram([change(times)], 10.0, settings).peaks.tolist() == [20, 60]
    three = replace(settings, max_peaks=3)
    assert keypoint_histogram([change(times)], 10.0, three).peaks.tolist() == [20, 40, 60]
    # Those of less than half of the largest are no peaks then.
    strict = replace(settings, max_peaks=9, keypoint_prominence=0.5)
    assert keypoint_histogram([change(times)], 10.0, strict).peaks.tolist() == [20, 60]


@pytest.mark.parametrize(
    ("anchors", "expected"),
    [
        ([0.0, 10.0], [0.0, 2.5, 6.5, 10.0]),
        # 1.4 s is more than a bin from 2.5 s, 1.6 s is not; the last is beside 6.5 s on the other side.
        ([0.0, 1.4, 10.0], [0.0, 1.4, 2.5, 6.5, 10.0]),
        ([0.0, 1.6, 10.0], [0.0, 1.6, 6.5, 10.0]),
        ([0.0, 7.4, 10.0], [0.0, 2.5, 7.4, 10.0]),
    ],
)
def test_peaks_within_a_bin_of_an_anchor_give_way(anchors, expected):
    histogram = KeypointHistogram(np.arange(11.0), np.zeros(10), np.zeros(10), np.array([2, 6]))
    np.testing.assert_allclose(keypoint_times(histogram, np.array(anchors)), expected)
