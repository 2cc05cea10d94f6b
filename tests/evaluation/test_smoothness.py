"""Smoothness: the minimum-jerk motion, whose dimensionless jerk is known in closed form."""

import numpy as np
import pytest

from sbam.evaluation.smoothness import joint_smoothness, path_smoothness
from sbam.planning.trajectory.trajectory import JointTrajectory

MINIMUM_JERK = np.log(720.0 / 1.875**2)  # Flash & Hogan 1985: integral of jerk^2 is 720 L^2 / D^5, peak 1.875 L / D


def minimum_jerk(time: np.ndarray, duration: float, amplitude: tuple[float, ...]) -> JointTrajectory:
    x = time / duration
    position = 10 * x**3 - 15 * x**4 + 6 * x**5
    velocity = (30 * x**2 - 60 * x**3 + 30 * x**4) / duration
    acceleration = (60 * x - 180 * x**2 + 120 * x**3) / duration**2
    names = tuple(f"joint{i}" for i in range(len(amplitude)))
    return JointTrajectory(names, time, *(np.outer(one, amplitude) for one in (position, velocity, acceleration)))


@pytest.mark.parametrize("duration", [2.0, 8.0])
@pytest.mark.parametrize("amplitude", [(1.0,), (0.6, -0.8, 0.0)])
def test_minimum_jerk_in_joint_space(duration, amplitude):
    time = np.linspace(0.0, duration, 4001)
    trajectory = minimum_jerk(time, duration, amplitude)
    values = joint_smoothness(trajectory, time)
    assert values["joints: travel [rad]"] == pytest.approx(np.linalg.norm(amplitude), rel=1e-6)
    largest = 1.875 * max(map(abs, amplitude)) / duration
    assert values["joints: largest speed at the demonstrations' pace [rad/s]"] == pytest.approx(largest, rel=1e-4)
    # Where the speed is below the threshold does not count to the duration.
    assert values["joints: log dimensionless jerk"] == pytest.approx(MINIMUM_JERK, abs=0.35)
    assert values["joints: log dimensionless jerk"] < MINIMUM_JERK

    slowed = joint_smoothness(trajectory, 2.0 * time)
    assert slowed["joints: largest speed at the demonstrations' pace [rad/s]"] == pytest.approx(largest / 2, rel=1e-4)


def test_minimum_jerk_of_an_object():
    time = np.linspace(0.0, 4.0, 401)
    path = minimum_jerk(time, 4.0, (0.3, 0.4, 0.0)).position
    values = path_smoothness("it: ", time, path)
    assert values["it: largest speed [mm/s]"] == pytest.approx(1e3 * 1.875 * 0.5 / 4.0, rel=0.01)
    assert values["it: log dimensionless jerk"] == pytest.approx(MINIMUM_JERK, abs=0.5)
    shaken = path + 0.005 * np.sin(20.0 * time)[:, None]
    assert path_smoothness("it: ", time, shaken)["it: log dimensionless jerk"] > MINIMUM_JERK + 1.0


def test_what_does_not_move_has_no_jerk():
    time = np.linspace(0.0, 1.0, 101)
    assert path_smoothness("it: ", time, np.zeros((101, 3))) == {"it: largest speed [mm/s]": 0.0}
    still = JointTrajectory(("joint",), time, *(np.zeros((101, 1)) for _ in range(3)))
    assert "joints: log dimensionless jerk" not in joint_smoothness(still, time)
