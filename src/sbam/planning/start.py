"""The robot as planning sees it: standing in the agent frame, in the posture that it starts from and returns to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import Robot, load_robot
from sbam.robots.limits import planning_limits
from sbam.scene import Scene

DEFAULT_ROBOT = "panda_dual"


def in_agent_frame(robot: Robot) -> Robot:
    """The robot as planning sees it: what it calls the world is the agent frame."""
    return robot.placed_for(RigidTransform.identity())


def standing_robot(robot: Robot | str | Path | None, scene: Scene) -> Robot:
    """The robot that is to act in a scene, standing in the agent frame (`in_agent_frame`).

    Args:
        robot: a robot, or the name or description file of one; None: the scene's, else the bimanual Panda.
        scene: the scene.

    Raises:
        UnknownNameError: if the robot is not known.
    """
    return in_agent_frame(robot if isinstance(robot, Robot) else load_robot(robot or scene.robot or DEFAULT_ROBOT))


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
