from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sbam.learning import LearningSettings
from sbam.learning.incremental import add_candidates, first_demonstration, update_moments

DEFAULT, PAPER = LearningSettings.default(), LearningSettings.paper()
modes = pytest.mark.parametrize("choices", [DEFAULT, PAPER], ids=["default", "paper"])


def generalised(polylines, choices=DEFAULT, unit="m"):
    channel = first_demonstration("x", unit, *polylines[0])
    for number, (time, value) in enumerate(polylines[1:], start=2):
        channel = add_candidates(channel, time, value, number, choices)
    return channel


@settings(max_examples=40, deadline=None)
@given(values=st.lists(st.floats(-2, 2), min_size=2, max_size=8), circular=st.booleans())
def test_welford_gives_the_exact_sample_moments(values, circular):
    mean, std = np.array(values[:1]), np.zeros(1)
    for number, value in enumerate(values[1:], start=2):
        value = np.array([value + (2 * np.pi * number if circular else 0)])
        if circular and np.ptp(values) >= np.pi:
            return
        mean, std = update_moments(mean, std, value, number, "welford", circular)
    assert mean[0] == pytest.approx(np.mean(values), abs=1e-9)
    assert std[0] == pytest.approx(np.std(values, ddof=1), abs=1e-6)


def test_the_papers_rule_by_hand():
    mean, std = update_moments(np.array([1.0]), np.array([0.0]), np.array([3.0]), 2, "paper", False)
    assert (mean[0], std[0]) == (2.0, 2.0)  # sqrt((3 - 1)^2 / 1); the exact one is sqrt(2)
    mean, std = update_moments(mean, std, np.array([5.0]), 3, "paper", False)
    assert mean[0] == pytest.approx(3.0)
    assert std[0] == pytest.approx(np.sqrt(((5 - 2) ** 2 + 4) / 2))


def test_azimuths_are_averaged_across_the_wrap():
    mean, std = update_moments(np.array([3.1]), np.array([0.0]), np.array([-3.1]), 2, "welford", True)
    assert np.cos(mean[0]) == pytest.approx(-1, abs=1e-6)
    assert std[0] == pytest.approx(np.std([3.1, 2 * np.pi - 3.1], ddof=1))


@modes
def test_the_same_demonstration_again_changes_nothing(choices):
    line = (np.array([0.0, 1.0, 2.5, 4.0]), np.array([0.0, 0.3, 0.3, -0.1]))
    channel = generalised([line] * 4, choices)
    np.testing.assert_allclose(channel.time, line[0])
    np.testing.assert_allclose(channel.mean, line[1])
    np.testing.assert_allclose(channel.std, 0, atol=1e-12)
    assert channel.count.tolist() == [4, 4, 4, 4]


@modes
def test_matched_keypoints_get_mean_times_and_values(choices):
    channel = generalised(
        [
            (np.array([0.0, 1.0, 4.0]), np.array([0.0, 0.30, 0.0])),
            (np.array([0.0, 1.2, 4.4]), np.array([0.0, 0.34, 0.02])),
        ],
        choices,
    )
    np.testing.assert_allclose(channel.time, [0, 1.1, 4.2])
    np.testing.assert_allclose(channel.mean, [0, 0.32, 0.01])
    assert channel.count.tolist() == [2, 2, 2]


@modes
def test_unmatched_keypoints_take_the_interpolated_value(choices):
    # The second demonstration has no corner at 1 s; there its line has the value 0.0.
    channel = generalised(
        [(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.3, 0.0])), (np.array([0.0, 2.0]), np.array([0.0, 0.0]))], choices
    )
    np.testing.assert_allclose(channel.mean, [0, 0.15, 0])
    assert channel.count.tolist() == [2, 1, 2]
    assert channel.std[1] == pytest.approx(0.3 if choices is PAPER else 0.3 / np.sqrt(2))


@modes
def test_unmatched_candidates_enter_with_the_models_mean_and_std(choices):
    flat = (np.array([0.0, 2.0]), np.array([0.0, 0.0]))
    wide = (np.array([0.0, 2.0]), np.array([0.02, 0.02]))
    corner = (np.array([0.0, 1.0, 2.0]), np.array([0.01, 0.31, 0.01]))
    channel = generalised([flat, wide, corner], choices)
    np.testing.assert_allclose(channel.time, [0, 1, 2])
    expected = update_moments(
        np.array([0.01]), generalised([flat, wide], choices).std[:1], np.array([0.31]), 3, choices.update_rule, False
    )
    assert channel.mean[1] == pytest.approx(expected[0][0])
    assert channel.std[1] == pytest.approx(expected[1][0])


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000), choices=st.sampled_from([DEFAULT, PAPER]), unit=st.sampled_from(["m", "rad", "log"])
)
def test_times_stay_in_order_and_everything_finite(seed, choices, unit):
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(5):
        duration, corners = rng.uniform(5, 10), rng.integers(1, 8)
        time = np.concatenate([[0], np.sort(rng.uniform(0.05, duration - 0.05, corners)), [duration]])
        lines.append((np.unique(time), rng.normal(size=len(np.unique(time)))))
    channel = generalised(lines, choices, unit)
    assert np.all(np.diff(channel.time) > 0)
    assert channel.time[0] == 0 and channel.time[-1] == pytest.approx(np.mean([line[0][-1] for line in lines]))
    assert np.all(np.isfinite(channel.mean)) and np.all(channel.std >= 0)
    assert channel.count.min() >= 1 and channel.count.max() <= 5


def test_moments_on_common_corners_agree_with_numpy():
    rng = np.random.default_rng(3)
    time = np.array([0.0, 1.0, 2.0, 4.0])
    values = np.array([0.0, 0.3, -0.2, 0.1]) + rng.normal(scale=0.01, size=(9, 4))
    channel = generalised([(time, value) for value in values])
    np.testing.assert_allclose(channel.mean, values.mean(axis=0))
    np.testing.assert_allclose(channel.std, values.std(axis=0, ddof=1))
    paper = generalised([(time, value) for value in values], replace(DEFAULT, update_rule="paper"))
    assert np.all(paper.std >= channel.std)
