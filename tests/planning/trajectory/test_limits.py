"""What real receivers reject is found: a planted violation of each kind, and nothing in a good trajectory."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.trajectory.limits import check_receivers, failed
from sbam.planning.trajectory.timing import time_path
from sbam.planning.trajectory.trajectory import JointTrajectory

SPEED = 0.5


@pytest.fixture(scope="module")
def good(panda) -> JointTrajectory:
    """From home to 0.6 rad aside and back."""
    clock = 0.02 * np.arange(301)
    bump = np.sin(np.pi * np.clip((clock - 1.0) / 4.0, 0.0, 1.0)) ** 4
    trajectory, _ = time_path(panda, clock, panda.home + 0.6 * bump[:, None], SPEED, 1000.0)
    return trajectory


def failing(robot, trajectory: JointTrajectory, start=None) -> set[str]:
    checks = check_receivers(robot, trajectory, robot.home if start is None else start, SPEED)
    names = {check.name for check in checks if not check.ok}
    assert len(failed(checks)) == len(names)
    return names


def changed(trajectory: JointTrajectory, field: str, where, value) -> JointTrajectory:
    array = getattr(trajectory, field).copy()
    array[where] = value
    return replace(trajectory, **{field: array})


def test_a_good_trajectory_passes(panda, good):
    checks = check_receivers(panda, good, panda.home, SPEED)
    assert failed(checks) == []
    assert all(check.ok for check in checks)
    assert len({check.name for check in checks}) == len(checks) == 14


def test_fewer_than_two_points(panda, good):
    for count in (0, 1):
        fields = {name: getattr(good, name)[:count] for name in ("time", "position", "velocity", "acceleration")}
        assert failing(panda, replace(good, **fields)) == {"points"}


@pytest.mark.parametrize("change", [lambda n: n[::-1], lambda n: n[:-1], lambda n: (*n[:-1], "another")])
def test_wrong_joint_names(panda, good, change):
    names = change(good.joint_names)
    found = failing(panda, replace(good, joint_names=tuple(names)))
    assert "joint names" in found
    assert ("array lengths" in found) == (len(names) != len(good.joint_names))


@pytest.mark.parametrize("field", ["time", "position", "velocity", "acceleration"])
def test_arrays_of_another_length(panda, good, field):
    assert failing(panda, replace(good, **{field: getattr(good, field)[:-1]})) == {"array lengths"}


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("field", ["time", "position", "velocity", "acceleration"])
def test_values_that_are_not_finite(panda, good, field, value):
    where = 100 if field == "time" else (100, 3)
    found = failing(panda, changed(good, field, where, value))
    assert found - {"times strictly increasing"} == {"finite values"}
    assert ("times strictly increasing" in found) == (field == "time")


@pytest.mark.parametrize("earlier", [0.0, 1e-4])
def test_times_that_do_not_increase(panda, good, earlier):
    assert failing(panda, changed(good, "time", 100, good.time[99] - earlier)) == {"times strictly increasing"}


def test_start_elsewhere(panda, good):
    start = panda.home.copy()
    start[4] += 0.002
    assert failing(panda, good, start) == {"start at the current posture"}
    start[4] -= 0.0015
    assert failing(panda, good, start) == set()


def test_position_beyond_a_limit(panda, good):
    """The whole trajectory shifted so far that joint 4 comes nearer to 0 than its limit."""
    shift = panda.upper[3] - good.position[:, 3].max() + 1e-4
    column = good.position.copy()
    column[:, 3] += shift
    shifted = replace(good, position=column)
    checks = check_receivers(panda, shifted, column[0], SPEED)
    (found,) = [check for check in checks if not check.ok]
    assert (found.name, found.worst) == ("position limits", pytest.approx(1e-4))
    assert panda.joint_names[3] in found.where


@pytest.mark.parametrize(("factor", "name"), [(1.4, "acceleration limits"), (2.5, "velocity limits")])
def test_too_fast(panda, good, factor, name):
    """The same motion in less time; everything still fits together."""
    faster = JointTrajectory(
        good.joint_names,
        good.time / factor,
        good.position,
        good.velocity * factor,
        good.acceleration * factor**2,
    )
    ratio = np.abs(faster.velocity / (SPEED * panda.velocity_limit)).max()
    ratio_acceleration = np.abs(faster.acceleration / (SPEED**2 * panda.acceleration_limit)).max()
    found = failing(panda, faster)
    assert ("velocity limits" in found) == (ratio > 1.0)
    assert ("acceleration limits" in found) == (ratio_acceleration > 1.0)
    assert name in found
    assert "velocity continuity" not in found


def test_a_jump_in_acceleration_is_a_jerk(panda, good):
    assert "jerk limits" in failing(panda, changed(good, "acceleration", (slice(2000, None), 5), 2.0))


def test_a_jump_in_position(panda, good):
    """Half a millirad from one sample to the next: within the limits, but not what the velocities say."""
    position = good.position.copy()
    position[2500:, 2] += 5e-4
    assert failing(panda, replace(good, position=position)) == {"velocity continuity"}


def test_a_jump_in_velocity(panda, good):
    velocity = good.velocity.copy()
    velocity[2500:, 2] += 0.05
    assert {"velocity continuity", "acceleration continuity"} <= failing(panda, replace(good, velocity=velocity))


def test_velocity_zero_throughout_is_no_velocity(panda, good):
    still = replace(good, velocity=np.zeros_like(good.velocity), acceleration=np.zeros_like(good.acceleration))
    assert "velocity continuity" in failing(panda, still)


def test_ends_in_motion(panda, good):
    middle = len(good.time) // 3
    cut = {name: getattr(good, name)[:middle] for name in ("time", "position", "velocity", "acceleration")}
    assert failing(panda, replace(good, **cut)) == {"end at rest"}
    rest = {name: getattr(good, name)[middle:] for name in ("position", "velocity", "acceleration")}
    tail = replace(good, time=good.time[: len(good.time) - middle], **rest)
    assert failing(panda, tail, tail.position[0]) == {"start at rest"}


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_coarse_sampling_of_a_good_trajectory_passes(panda, within_limits, rate, speed):
    """What finite differences cannot see between samples is allowed for, also where the jerk is near its limit."""
    from scipy.ndimage import gaussian_filter1d

    generator = np.random.default_rng(10)
    clock = 0.02 * np.arange(301)
    corners = np.sort(generator.uniform(0.5, 5.5, 8))
    path = np.stack([np.interp(clock, corners, c) for c in within_limits(panda, generator, 8).T], axis=-1)
    path = gaussian_filter1d(path, 0.5, axis=0, mode="nearest")
    trajectory, _ = time_path(panda, clock, path, speed, rate)
    assert failed(check_receivers(panda, trajectory, path[0], speed)) == []


def test_sentences_say_what_where_and_how_much(panda, good):
    (sentence,) = failed(check_receivers(panda, changed(good, "velocity", (-1, 1), 0.25), panda.home, SPEED)[-1:])
    assert sentence == f"end at rest: 0.25 rad/s (limit 1e-09), left_joint2 at {good.time[-1]:.3f} s"
