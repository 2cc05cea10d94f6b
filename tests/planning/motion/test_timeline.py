"""Standstills in a motion that is being put together."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sbam.planning.motion.timeline import CREEP, EASE_TICKS, STEP, Phase, Timeline, lag

COUNT = 200


def wave(model_time: np.ndarray) -> np.ndarray:
    """(N, 2) something smooth."""
    return np.stack([np.sin(model_time), np.cos(0.7 * model_time)], axis=-1)


@pytest.fixture(scope="module")
def timeline() -> Timeline:
    """Two hands that meet at sample 100 of a smooth motion whose first tick is 50."""
    model_time = STEP * np.arange(50.0, 50.0 + COUNT, dtype=np.float64)
    middle = STEP * 150.0
    phases = (
        Phase("left", "grasp", middle, middle + 0.3, "cup"),
        Phase("right", "manipulate", STEP * 60.0, middle, "bottle"),
        Phase("right", "place", middle, middle + 1.0, "bottle"),
    )
    return Timeline(50, model_time, wave(model_time), phases)


def test_the_lag_is_the_integral_of_the_easing():
    ticks = np.linspace(-5.0, 3.0 * EASE_TICKS, 4001)
    rate = np.gradient(lag(ticks), ticks)
    assert np.all(np.diff(rate) > -1e-9)
    assert rate[0] == 0.0
    assert rate[-1] == pytest.approx(1.0)
    assert lag(np.array([float(EASE_TICKS)]))[0] == pytest.approx(EASE_TICKS / 2)


@given(st.integers(30, COUNT - 30), st.integers(0, 300), st.booleans())
def test_a_pause_changes_when_things_happen_not_what(timeline, index, ticks, arriving):
    paused = timeline.with_pause(index, ticks, arriving, "left")
    rate = np.diff(paused.model_time) / STEP
    assert rate.min() > 0.0
    assert rate.max() < 1.0 + 1e-3
    assert (rate < 2.0 * CREEP).sum() >= ticks - 1
    np.testing.assert_allclose(paused.configurations, wave(paused.model_time), atol=1e-4)
    np.testing.assert_allclose(paused.model_time[:10], timeline.model_time[:10], atol=1e-9)
    assert abs(len(paused.model_time) - (COUNT + ticks + EASE_TICKS)) <= 2
    for before, after in zip(timeline.phases, paused.phases, strict=True):
        for old, new in ((before.start, after.start), (before.end, after.end)):
            # The clock was the model's time before.
            assert np.interp(new, paused.clock, paused.model_time) == pytest.approx(old, abs=0.5 * STEP)


@pytest.mark.parametrize("arriving", [True, False])
def test_who_passes_and_who_waits(timeline, arriving):
    """Arriving, the hand grasps at the end of the standstill that others began; leaving, it is the other way round."""
    ticks = 100
    paused = timeline.with_pause(100, ticks, arriving, "left")
    passing = paused.phase("left", "cup", "grasp").start
    waiting = paused.phase("right", "bottle", "place").start
    assert waiting == paused.phase("right", "bottle", "manipulate").end
    assert passing - waiting == pytest.approx(STEP * ticks * (1 if arriving else -1))


def test_beyond_its_ends_nothing_moves_but_time_runs_on(timeline):
    wider = timeline.covering(-7, COUNT + 4)
    np.testing.assert_allclose(wider.clock, STEP * (43.0 + np.arange(COUNT + 12)))
    np.testing.assert_allclose(wider.model_time, wider.clock)
    np.testing.assert_array_equal(wider.configurations[:8], np.tile(timeline.configurations[0], (8, 1)))
    np.testing.assert_array_equal(wider.configurations[-6:], np.tile(timeline.configurations[-1], (6, 1)))
    assert wider.covering(0, 5) is wider


def test_a_way_is_written_where_it_begins(timeline):
    values = np.column_stack([np.linspace(5.0, 6.0, 20), np.zeros(20)])
    joints = np.array([0])
    came = timeline.with_way(30, joints, values, Phase("left", "approach", 1.6, 1.98, "cup"))
    np.testing.assert_array_equal(came.configurations[:30, 0], 5.0)
    np.testing.assert_array_equal(came.configurations[30:50, 0], values[:, 0])
    np.testing.assert_array_equal(came.configurations[50:], timeline.configurations[50:])
    np.testing.assert_array_equal(came.configurations[:, 1], timeline.configurations[:, 1])
    left = timeline.with_way(30, joints, values, Phase("left", "retreat", 1.6, 1.98, "cup"))
    np.testing.assert_array_equal(left.configurations[50:, 0], 6.0)
    assert left.phases[-1].name == "retreat"
