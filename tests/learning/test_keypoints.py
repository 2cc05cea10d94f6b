import numpy as np

from sbam.constraints import RegionPair, RegionReference
from sbam.learning import GeneralizedChange, GeneralizedChannel, LearningSettings
from sbam.learning.keypoints import keypoint_histogram, keypoint_times

SETTINGS = LearningSettings.default()


def change(*times):
    channels = tuple(
        GeneralizedChannel("x", "m", np.array(t), np.zeros(len(t)), np.zeros(len(t)), np.ones(len(t), np.int64))
        for t in times
    )
    return GeneralizedChange(RegionPair(RegionReference("a", "b"), None), "cartesian", channels)


def test_crowds_are_found_and_start_and_end_belong():
    rng = np.random.default_rng(0)
    crowds = [np.sort(np.concatenate([[0], rng.normal([2.0, 5.0, 8.0], 0.03), [10]])) for _ in range(30)]
    times = keypoint_times(keypoint_histogram([change(*crowds)], 10.0, SETTINGS), np.array([0.0, 10.0]))
    assert times[0] == 0 and times[-1] == 10 and np.all(np.diff(times) > 0)
    for crowd in (2.0, 5.0, 8.0):
        assert np.abs(times - crowd).min() < 0.1


def test_anchors_are_keypoints_and_displace_peaks_beside_them():
    histogram = keypoint_histogram([change(*[[0, 3.02, 10.0]] * 10)], 10.0, SETTINGS)
    times = keypoint_times(histogram, np.array([0.0, 3.0, 4.0, 10.0]))
    assert {0.0, 3.0, 4.0, 10.0} <= set(times)
    assert np.sum(np.abs(times - 3.0) < 0.1) == 1


def test_no_more_peaks_than_wanted():
    rng = np.random.default_rng(1)
    scattered = [np.sort(np.concatenate([[0], rng.uniform(0, 10, 40), [10]])) for _ in range(9)]
    histogram = keypoint_histogram([change(*scattered)], 10.0, SETTINGS)
    assert 10 < len(histogram.peaks) <= 30
    assert histogram.counts.sum() == 9 * 42


def test_the_filter_has_zero_phase():
    histogram = keypoint_histogram([change(*[[0.0, 5.05, 10.0]] * 50)], 10.0, SETTINGS)
    middle = int(np.argmax(histogram.counts[5:-5])) + 5
    np.testing.assert_allclose(
        histogram.filtered[middle - 9 : middle], histogram.filtered[middle + 9 : middle : -1], atol=1e-3
    )
