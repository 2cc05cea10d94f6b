import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sbam.demonstrations.signals import (
    POSITION_GLITCH,
    RATE,
    Run,
    bridge,
    even_times,
    low_pass,
    resample,
    smooth_axes,
    speed,
    true_runs,
    without_glitches,
)


@given(st.lists(st.booleans(), max_size=40))
def test_runs_are_the_true_samples(flags):
    mask = np.array(flags, dtype=bool)
    runs = true_runs(mask)
    assert [index for run in runs for index in range(*run)] == np.flatnonzero(mask).tolist()
    assert all(first.stop < second.start for first, second in itertools.pairwise(runs))


def test_gaps_are_bridged_up_to_their_length():
    runs = [Run(0, 10), Run(30, 40), Run(71, 80)]
    assert bridge(runs, 0.2) == [Run(0, 40), Run(71, 80)]
    assert bridge(runs, 0.31) == [Run(0, 80)]
    assert bridge([], 1.0) == []


@pytest.mark.parametrize("frequency", [0.5, 2.0, 5.0, 15.0])
def test_the_filter_is_a_zero_phase_butterworth(frequency):
    time = np.arange(0, 20, 1 / RATE)
    wave = np.sin(2 * np.pi * frequency * time)[:, None]
    middle = slice(500, -500)
    # The bilinear transform bends frequencies; forwards and backwards squares the gain.
    ratio = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * 5.0 / RATE)
    np.testing.assert_allclose(low_pass(wave, 5.0)[middle], wave[middle] / (1 + ratio**4), atol=2e-3)


def test_a_constant_speed_stays_as_it_is():
    time = np.sort(np.random.default_rng(0).uniform(0, 3, 200))
    grid = even_times(time)
    line = resample(time[:, None] * [0.1, 0.2, -0.2], time, grid)
    np.testing.assert_allclose(speed(low_pass(line, 5.0), grid), 0.3, atol=1e-4)


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_only_implausible_frames_are_replaced(rate):
    time = np.arange(0, 4, 1 / rate)
    stroke = 0.07 * np.sin(2 * np.pi * time)[:, None] * [1.0, 0.0, 0.0]
    np.testing.assert_array_equal(without_glitches(stroke, time, POSITION_GLITCH, 10.0), stroke)
    damaged = stroke.copy()
    damaged[len(time) // 2] += 0.4
    mended = without_glitches(damaged, time, POSITION_GLITCH, 10.0)
    np.testing.assert_allclose(mended, stroke, atol=0.05 if rate == 10.0 else 0.006)
    assert np.count_nonzero((mended != damaged).any(axis=1)) <= 3


def test_axes_stay_unit_vectors():
    time = np.arange(0, 3, 0.01)
    axes = np.stack([np.cos(time), np.sin(time), 0 * time], axis=1)
    np.testing.assert_allclose(np.linalg.norm(smooth_axes(axes, time, time), axis=1), 1)
