"""The posture a robot starts from and returns to."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import Robot
from sbam.robots.limits import planning_limits


def start_from(robot: Robot, joints: Mapping[str, float]) -> tuple[Robot, tuple[str, ...]]:
    """The robot with its home at the given posture; joints that are not named stay at the robot's own home.

    A posture outside the limits is projected into them, and that is said: a real robot often stands a hair outside.

    Args:
        robot: the robot.
        joints: joint name -> position, rad (m for prismatic joints).

    Returns:
        The robot, and a sentence for each joint that was projected.

    Raises:
        UnknownNameError: if a joint is not known.
        ConfigurationError: if a position is not finite.
    """
    home, notes = robot.home.copy(), []
    lower, upper = planning_limits(robot)
    for name, position in joints.items():
        if name not in robot.joint_names:
            raise UnknownNameError("joint", name, robot.joint_names, f"robot {robot.name!r}")
        if not math.isfinite(position):
            raise ConfigurationError(robot.name, f"start of joint {name!r} is {position}", "a finite number")
        column = robot.joint_names.index(name)
        home[column] = np.clip(position, lower[column], upper[column])
        if home[column] != position:
            notes.append(
                f"start of joint {name} moved from {position:.4f} to {home[column]:.4f}: its limits are "
                f"{robot.lower[column]:.4f} to {robot.upper[column]:.4f}"
            )
    return robot.with_home(home), tuple(notes)
