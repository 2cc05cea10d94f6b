"""Properties of the timing: limits hold at every sample, the path stays the same, nothing is faster than its clock."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline
from scipy.ndimage import gaussian_filter1d

from sbam.planning.trajectory.limits import check_receivers, failed
from sbam.planning.trajectory.timing import time_path

STEP = 0.02
RATE = 1000.0


def random_path(robot, within_limits, seed: int, seconds: float, corners: int, roundness: float):
    """Postures at random times, linear between them, rounded; at rest for a while at both ends."""
    generator = np.random.default_rng(seed)
    clock = STEP * np.arange(round(seconds / STEP) + 1) - 1.0
    times = np.sort(generator.uniform(clock[0] + 0.2, clock[-1] - 0.2, corners))
    postures = within_limits(robot, generator, corners)
    path = np.stack([np.interp(clock, times, column) for column in postures.T], axis=-1)
    return clock, gaussian_filter1d(path, roundness / STEP, axis=0, mode="nearest")


paths = {
    "seed": st.integers(0, 10_000),
    "seconds": st.sampled_from([1.5, 4.0, 9.0]),
    "corners": st.integers(1, 8),
    "roundness": st.sampled_from([0.01, 0.03, 0.1, 0.3]),
}


@settings(max_examples=15, deadline=None, derandomize=True)
@given(**paths, speed=st.sampled_from([0.25, 0.5, 1.0]))
def test_limits_hold_at_every_sample(panda, within_limits, seed, seconds, corners, roundness, speed):
    """By differentiating the emitted positions, not by what the trajectory says of itself."""
    clock, path = random_path(panda, within_limits, seed, seconds, corners, roundness)
    trajectory, at = time_path(panda, clock, path, speed, RATE)
    assert trajectory.joint_names == panda.joint_names
    velocity = np.diff(trajectory.position, axis=0) * RATE
    acceleration = np.diff(velocity, axis=0) * RATE
    jerk = np.diff(trajectory.acceleration, axis=0) * RATE
    assert (np.abs(velocity) <= speed * panda.velocity_limit).all()
    assert (np.abs(acceleration) <= speed**2 * panda.acceleration_limit).all()
    assert (np.abs(jerk) <= speed**3 * panda.jerk_limit).all()
    # What is stated is what the positions do.
    middle = 0.5 * (trajectory.velocity[1:] + trajectory.velocity[:-1])
    np.testing.assert_allclose(velocity, middle, atol=2e-4)
    np.testing.assert_allclose(acceleration, trajectory.acceleration[1:-1], atol=0.02 * panda.acceleration_limit.max())
    assert failed(check_receivers(panda, trajectory, path[0], speed)) == []
    assert len(at) == len(trajectory.time)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(**paths)
def test_the_path_is_passed_in_order_and_never_faster_than_its_clock(
    panda, within_limits, seed, seconds, corners, roundness
):
    clock, path = random_path(panda, within_limits, seed, seconds, corners, roundness)
    trajectory, at = time_path(panda, clock, path, 0.5, RATE)
    steps = np.diff(at)
    assert (steps >= 0.0).all()
    assert (steps <= (1.0 + 1e-5) / RATE).all()  # between ticks the rate's spline overshoots by some millionths
    assert trajectory.duration >= clock[-1] - clock[0] - 1e-9
    assert (at[0], at[-1]) == pytest.approx((clock[0], clock[-1]), abs=1e-9)
    # Geometry: every sample lies on the quintic spline, which passes through every posture of the path.
    rest = [(order, np.zeros(path.shape[1])) for order in (1, 2)]
    spline = make_interp_spline(clock, path, k=5, bc_type=(rest, rest))
    np.testing.assert_allclose(trajectory.position, spline(at), atol=1e-9)
    passed = np.stack([np.interp(clock, at, column) for column in trajectory.position.T], axis=-1)
    np.testing.assert_allclose(passed, path, atol=1e-5)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000), rate=st.sampled_from([50.0, 333.0, 1000.0]))
def test_start_and_end_are_at_rest(panda, within_limits, seed, rate):
    clock, path = random_path(panda, within_limits, seed, 4.0, 4, 0.1)
    trajectory, _ = time_path(panda, clock, path, 0.5, rate)
    for end in (0, -1):
        assert not trajectory.velocity[end].any()
        assert not trajectory.acceleration[end].any()
        np.testing.assert_allclose(trajectory.position[end], path[end], atol=1e-12)
    assert trajectory.time[0] == 0.0
    np.testing.assert_allclose(np.diff(trajectory.time), 1.0 / rate, rtol=1e-9)


def test_jerk_limits_hold_where_they_are_what_binds(panda, within_limits):
    """On a robot that may jerk a thousand times less."""
    gentle = copy.copy(panda)
    gentle.jerk_limit = panda.jerk_limit / 1000.0
    clock, path = random_path(panda, within_limits, 2, 4.0, 5, 0.03)
    trajectory, _ = time_path(gentle, clock, path, 0.5, RATE)
    usual, _ = time_path(panda, clock, path, 0.5, RATE)
    assert failed(check_receivers(gentle, trajectory, path[0], 0.5)) == []
    assert "jerk limits" in " ".join(failed(check_receivers(gentle, usual, path[0], 0.5)))
    assert trajectory.duration > usual.duration


def test_a_slow_path_keeps_its_timing(panda):
    """0.2 rad in 4 s ask for nothing: the clock runs at rate 1."""
    clock = STEP * np.arange(301)
    share = np.clip((clock - 1.0) / 4.0, 0.0, 1.0)
    path = panda.home + 0.2 * (share**3 * (10.0 - 15.0 * share + 6.0 * share**2))[:, None]
    trajectory, at = time_path(panda, clock, path, 0.5, RATE)
    assert trajectory.duration == pytest.approx(6.0, abs=2e-3)
    np.testing.assert_allclose(at, np.minimum(trajectory.time, 6.0), atol=1e-6)


def test_slower_when_less_is_granted(panda, within_limits):
    clock, path = random_path(panda, within_limits, 3, 4.0, 5, 0.1)
    durations = [time_path(panda, clock, path, speed, 200.0)[0].duration for speed in (1.0, 0.5, 0.2)]
    assert durations[0] < durations[1] < durations[2]


def test_standing_still_takes_as_long_as_the_clock(panda):
    clock = STEP * np.arange(51)
    trajectory, _ = time_path(panda, clock, np.tile(panda.home, (51, 1)), 0.5, RATE)
    assert trajectory.duration == pytest.approx(1.0, abs=2e-3)
    np.testing.assert_allclose(trajectory.velocity, 0.0, atol=1e-9)
