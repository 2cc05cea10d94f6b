"""Options behind a robot's name, such as ``panda_dual:base_distance=0.9,forward=0.1``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import msgspec

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots.description import RobotDescription

BASE = ("right", "forward", "up", "turn")
"""Moves of the base from its default place: m along the axes of the agent frame; degrees about its own vertical, to
the left."""

_OPTIONS = re.compile(r"^(?P<name>.+?):(?P<options>\w+=[^,=:/\\]+(,\w+=[^,=:/\\]+)*)$")


def split_options(text: str) -> tuple[str, dict[str, float]]:
    """A robot's name or file, and the options behind it.

    Raises:
        ConfigurationError: if an option's value is no finite number.
    """
    match = _OPTIONS.match(text)
    if match is None:
        return text, {}
    options = {}
    for part in match["options"].split(","):
        key, _, value = part.partition("=")
        try:
            options[key] = float(value)
        except ValueError:
            options[key] = math.nan
        if not math.isfinite(options[key]):
            raise ConfigurationError(match["name"], f"option {key} is {value!r}", "a finite number")
    return match["name"], options


def with_options(description: RobotDescription, options: Mapping[str, float]) -> RobotDescription:
    """The same robot, built or standing a little differently.

    Args:
        description: the robot.
        options: ``base_distance`` (m, robots of two parts), moves of the base as `BASE` names them, and positions of
            locked joints by their names, rad or m.

    Raises:
        UnknownNameError: for another option; lists those that there are.
        FileFormatError: if the base distance does not fit the robot.
    """
    known = ("base_distance", *BASE, *description.locked_joints)
    for name in options:
        if name not in known:
            raise UnknownNameError("robot option", name, known, f"robot {description.name!r}")
    if "base_distance" in options:
        description = description.with_base_distance(options["base_distance"])
    locked = {name: value for name, value in options.items() if name in description.locked_joints}
    pose, moves = description.base_in_agent, {name: options.get(name, 0.0) for name in BASE}
    x, y, z = pose.position
    roll, pitch, yaw = pose.rotation_rpy_deg
    base = msgspec.structs.replace(
        pose,
        position=(x + moves["right"], y + moves["forward"], z + moves["up"]),
        rotation_rpy_deg=(roll, pitch, yaw + moves["turn"]),
    )
    return msgspec.structs.replace(
        description,
        base_in_agent=base,
        locked_joints={**description.locked_joints, **locked},
        options={**description.options, **options},
    )


def options_text(options: Mapping[str, float]) -> str:
    """Options as they are written behind a robot's name, without the colon."""
    return ",".join(f"{name}={value:.6g}" for name, value in options.items())
