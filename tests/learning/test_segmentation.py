import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sbam.learning.segmentation import segment


def area(time, value, kept):
    return np.trapezoid(np.abs(np.interp(time, time[kept], value[kept]) - value), time)


def test_a_constant_is_one_segment():
    assert segment(np.arange(50.0), np.full(50, 3.0), 0.1).tolist() == [0, 49]


def test_a_straight_line_is_one_segment():
    time = np.linspace(0, 2, 41)
    assert segment(time, 3 * time - 1, 1e-9).tolist() == [0, 40]


def test_a_trapezoid_is_split_at_its_corners():
    time = np.arange(0, 11.0)
    value = np.interp(time, [0, 3, 6, 10], [0, 3, 3, -1])
    assert segment(time, value, 1e-6).tolist() == [0, 3, 6, 10]


def test_a_hand_worked_split():
    time, value = np.array([0.0, 1, 2, 3, 4]), np.array([0.0, 0.1, 1, 0.1, 0])
    # One chord, constant 0: area 0.1 + 1 + 0.1.
    assert segment(time, value, 1.21).tolist() == [0, 4]
    # Two chords that meet at the tip are 0.5 at 1 s and at 3 s: area 0.4 each. No other split is better.
    assert segment(time, value, 0.41).tolist() == [0, 2, 4]
    assert segment(time, value, 0.39).tolist() == [0, 1, 2, 3, 4]


def test_the_final_pass_drops_a_point_that_is_not_needed():
    # A ramp between two plateaus: the first splits cannot all be at corners; only the corners are needed.
    time = np.linspace(0, 10, 101)
    value = np.clip(time - 4, 0, 2)
    assert segment(time, value, 1e-6).tolist() == [0, 40, 60, 100]


def test_fixed_knots_stay():
    time = np.linspace(0, 1, 21)
    assert segment(time, time, 1.0, knots=[7, 13]).tolist() == [0, 7, 13, 20]


def test_uneven_samples_count_by_time_and_not_by_number():
    time = np.concatenate([np.linspace(0, 0.1, 50), np.linspace(0.2, 5, 20)])
    value = np.interp(time, [0, 2.5, 5], [0, 1, 0])
    kept = segment(time, value, 0.02 * 5)
    assert len(kept) == 3
    assert time[kept[1]] == pytest.approx(2.5, abs=0.2)


corners = st.lists(st.integers(-5, 5), min_size=3, max_size=7)


@settings(max_examples=60, deadline=None)
@given(corners=corners)
def test_polylines_are_recovered(corners):
    knots = 12 * np.arange(len(corners))
    time = np.arange(knots[-1] + 1) / 10
    value = np.interp(time, time[knots], corners)
    kept = segment(time, value, 1e-9)
    np.testing.assert_allclose(np.interp(time, time[kept], value[kept]), value, atol=1e-6)
    assert set(kept) >= {int(k) for k, bend in zip(knots[1:-1], np.diff(corners, 2), strict=True) if bend}


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), scale=st.floats(0.01, 100), epsilon=st.sampled_from([0.003, 0.01, 0.05]))
def test_result_is_ordered_good_and_independent_of_scale(seed, scale, epsilon):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.01, 0.2, 120))
    value = np.cumsum(rng.normal(size=120))
    threshold = epsilon * np.ptp(value) * np.ptp(time)
    kept = segment(time, value, threshold)
    assert kept[0] == 0 and kept[-1] == 119 and np.all(np.diff(kept) > 0)
    assert area(time, value, kept) <= 2 * threshold * (len(kept) - 1)
    np.testing.assert_array_equal(kept, segment(time, 4 * value, 4 * threshold))
    assert len(segment(time, scale * value, 2 * scale * threshold)) <= len(kept)


def test_memory_grows_with_the_samples_and_not_with_their_square():
    time = np.linspace(0, 60, 6001)
    value = np.sin(time) + 0.1 * np.sin(7 * time)
    tracemalloc.start()
    segment(time, value, 0.006 * 2 * 60)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200 * time.nbytes  # a square matrix would take 6001 times
