"""Each check worked out by hand on a trajectory of three samples, of which one joint moves."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.trajectory.limits import Check, check_receivers, failed
from sbam.planning.trajectory.trajectory import JointTrajectory

MOVING = 5
TIME = np.array([0.0, 0.1, 0.3])


def column(values) -> np.ndarray:
    array = np.zeros((3, 14))
    array[:, MOVING] = values
    return array


@pytest.fixture
def robot(panda):
    """Limits in round numbers; half of the speed leaves 0.4 rad/s, 1 rad/s^2 and 10 rad/s^3."""
    robot = copy.copy(panda)
    robot.lower, robot.upper = np.full(14, -1.0), np.full(14, 1.0)
    robot.velocity_limit, robot.acceleration_limit, robot.jerk_limit = (np.full(14, x) for x in (0.8, 4.0, 80.0))
    return robot


@pytest.fixture
def trajectory(robot) -> JointTrajectory:
    return JointTrajectory(
        robot.joint_names, TIME, column([0.0, 0.004, 0.020]), column([0.0, 0.08, 0.02]), column([0.5, 0.2, -0.8])
    )


def found(robot, trajectory, start=None) -> dict[str, Check]:
    checks = check_receivers(robot, trajectory, np.zeros(14) if start is None else start, 0.5)
    return {check.name: check for check in checks}


def test_what_is_found_of_three_samples(robot, trajectory):
    """Jerks -0.3 / 0.1 and -1 / 0.2. Velocities by differences 0.04, 0.08, stated on average 0.04, 0.05.

    Accelerations by differences 0.8, -0.3, stated on average 0.35, -0.3. The longest step is 0.2 s: velocities may be
    off by 0.001 + 10 0.2^2 / 12, accelerations by 10 0.2.
    """
    start = np.zeros(14)
    start[MOVING] = 0.0005
    joint = robot.joint_names[MOVING]
    expected = {
        "start at the current posture": (0.0005, 0.001, "rad", "0.000"),
        "position limits": (0.02 - 1.0, 1e-9, "rad outside", "0.300"),
        "velocity limits": (0.08 / 0.4, 1.0, "of the limit", "0.100"),
        "acceleration limits": (0.8, 1.0, "of the limit", "0.300"),
        "jerk limits": (0.5, 1.0, "of the limit", "0.100"),
        "velocity continuity": (0.03 / (0.001 + 0.4 / 12.0), 1.0, "of what rounding allows", "0.100"),
        "acceleration continuity": (0.45 / 2.0, 1.0, "of a jerk step", "0.000"),
        "end at rest": (0.02, 1e-9, "rad/s", "0.300"),
    }
    checks = found(robot, trajectory, start)
    for name, (worst, limit, unit, when) in expected.items():
        check = checks[name]
        assert (check.worst, check.limit) == (pytest.approx(worst, rel=1e-9), limit), name
        assert (check.unit, check.where) == (unit, f"{joint} at {when} s"), name
    assert [check.name for check in checks.values() if not check.ok] == ["end at rest"]
    assert (checks["start at rest"].worst, checks["start at rest"].limit) == (0.0, 1e-9)
    for name in ("points", "joint names", "array lengths", "finite values", "times strictly increasing"):
        assert (checks[name].ok, checks[name].worst, checks[name].limit) == (True, 0.0, 0.0)
    assert checks["points"].where == "3 points"


def test_a_limit_itself_may_be_reached(robot, trajectory):
    """0.08 rad/s of 0.08, 0.5 rad/s^2 of 0.5; a trifle more is too much."""
    robot.velocity_limit, robot.acceleration_limit = np.full(14, 0.16), np.full(14, 3.2)
    checks = found(robot, trajectory)
    assert (checks["velocity limits"].worst, checks["velocity limits"].ok) == (1.0, True)
    assert (checks["acceleration limits"].worst, checks["acceleration limits"].ok) == (1.0, True)
    faster = found(robot, replace(trajectory, velocity=1.001 * trajectory.velocity))
    assert not faster["velocity limits"].ok


def test_either_side_of_the_range_counts(robot, trajectory):
    for bound, sign in (("lower", -1.0), ("upper", 1.0)):
        position = trajectory.position.copy()
        position[1, 3] = sign * 1.25
        check = found(robot, replace(trajectory, position=position))["position limits"]
        assert (check.ok, check.worst) == (False, pytest.approx(0.25)), bound
        assert check.where == f"{robot.joint_names[3]} at 0.100 s"


def test_the_start_counts_on_either_side(robot, trajectory):
    for start in (-0.003, 0.003):
        check = found(robot, trajectory, np.full(14, start))["start at the current posture"]
        assert (check.ok, check.worst) == (False, pytest.approx(0.003))


def test_what_cannot_be_judged_is_said_in_words(robot, trajectory):
    single = replace(
        trajectory, **{name: getattr(trajectory, name)[:1] for name in ("time", "position", "velocity", "acceleration")}
    )
    (check,) = (check for check in check_receivers(robot, single, np.zeros(14)) if not check.ok)
    assert check == Check("points", False, 1.0, 0.0, "violations", "1 points")
    assert failed([check]) == ["points: 1 violations (limit 0), 1 points"]
    names = ("other", *robot.joint_names[1:])
    (check,) = (c for c in check_receivers(robot, replace(trajectory, joint_names=names), np.zeros(14)) if not c.ok)
    assert check.where == f"{names} instead of {robot.joint_names}"
    (check,) = (
        c
        for c in check_receivers(robot, replace(trajectory, velocity=trajectory.velocity[:, :9]), np.zeros(14))
        if not c.ok
    )
    assert failed([check]) == ["array lengths: 1 violations (limit 0)"]


def test_all_of_the_limits_are_granted_if_nothing_is_said(robot, trajectory):
    checks = {check.name: check for check in check_receivers(robot, trajectory, np.zeros(14))}
    assert checks["velocity limits"].worst == pytest.approx(0.1)
    assert checks["acceleration limits"].worst == pytest.approx(0.2)
    assert checks["jerk limits"].worst == pytest.approx(5.0 / 80.0)
