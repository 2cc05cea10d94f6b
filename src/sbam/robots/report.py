"""What there is to say about the built-in robots, as plain numbers and words; keys: docs, "Reports"."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from sbam.robots.registry import ROBOTS, load_robot


def robot_summaries() -> list[dict[str, Any]]:
    """Name, description file, arms, joint names and limits of every built-in robot; None where there is no limit."""
    summaries = []
    for name, file in ROBOTS.items():
        robot = load_robot(name)
        summaries.append(
            {
                "name": name,
                "file": str(file),
                "arms": list(robot.arms),
                "joint_names": list(robot.joint_names),
                "lower": finite(robot.lower),
                "upper": finite(robot.upper),
                "velocity_limit": robot.velocity_limit.tolist(),
                "acceleration_limit": robot.acceleration_limit.tolist(),
            }
        )
    return summaries


def finite(values: Iterable[float]) -> list[float | None]:
    """Numbers for JSON, which knows no infinity: None instead."""
    return [float(value) if math.isfinite(value) else None for value in values]
