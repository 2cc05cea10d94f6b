"""The timing is no slower than one of the limits asks for, and ends where the clock does."""

import copy

import numpy as np
import pytest

from sbam.planning.trajectory.timing import time_path

CLOCK = 0.02 * np.arange(301)
PATH = np.repeat(0.6 * np.sin(np.pi * np.clip((CLOCK - 1.0) / 4.0, 0.0, 1.0))[:, None] ** 4, 14, axis=1)


def limited(robot, velocity=1e3, acceleration=1e3, jerk=1e6):
    other = copy.copy(robot)
    other.velocity_limit, other.acceleration_limit = np.full(14, velocity), np.full(14, acceleration)
    other.jerk_limit = np.full(14, jerk)
    return other


@pytest.mark.parametrize(
    ("limits", "speed"),
    [
        ({"velocity": 0.2}, 1.0),
        ({"velocity": 0.4}, 0.5),
        ({"acceleration": 0.15}, 1.0),
        ({"acceleration": 0.6}, 0.5),
        ({"jerk": 0.5}, 1.0),
        ({"jerk": 4.0}, 0.5),
    ],
)
def test_the_limit_that_binds_is_used(panda, limits, speed):
    """Between 85 % and all of it, where velocities count once, accelerations twice and jerks three times."""
    trajectory, _ = time_path(limited(panda, **limits), CLOCK, PATH, speed, 1000.0)
    used = {
        "velocity": np.abs(trajectory.velocity).max() / speed,
        "acceleration": np.abs(trajectory.acceleration).max() / speed**2,
        "jerk": np.abs(np.diff(trajectory.acceleration, axis=0) * 1000.0).max() / speed**3,
    }
    ((name, limit),) = limits.items()
    assert 0.85 * limit < used[name] <= limit
    assert trajectory.duration > 1.2 * CLOCK[-1]


def test_only_the_part_that_is_too_fast_is_slowed_down(panda):
    """The rest before and after the bump takes as long as it did."""
    trajectory, at = time_path(limited(panda, velocity=0.3), CLOCK, PATH, 1.0, 1000.0)
    assert at[trajectory.time <= 0.5] == pytest.approx(trajectory.time[trajectory.time <= 0.5], abs=1e-6)
    rest = trajectory.duration - trajectory.time
    assert CLOCK[-1] - at[rest <= 0.5] == pytest.approx(rest[rest <= 0.5], abs=1.5e-3)


@pytest.mark.parametrize("rate", [50.0, 333.0, 1000.0])
def test_the_last_sample_alone_is_at_the_end(panda, rate):
    """Of a path that takes no whole number of samples."""
    clock = CLOCK * (6.0007 / CLOCK[-1])
    trajectory, at = time_path(limited(panda), clock, PATH, 1.0, rate)
    assert len(trajectory.time) == int(np.ceil(6.0007 * rate)) + 1
    assert at[-2] < clock[-1] - 1e-9
    assert at[-1] == clock[-1]
