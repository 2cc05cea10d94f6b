"""``trajectory_ros.json``: the fields of a ``trajectory_msgs/JointTrajectory`` message; needs no ROS.

A joint trajectory controller joins points that carry velocities and accelerations by quintics, so `RATE` points per
second give the 1 kHz trajectory back. rad, rad/s, rad/s^2 (m for prismatic joints).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from sbam.planning.plan import Plan

FILE = "trajectory_ros.json"
RATE = 100.0
"""Points per second."""

NANOSECONDS = 1_000_000_000


def joint_trajectory_message(plan: Plan, rate: float = RATE) -> dict[str, Any]:
    """The message as dictionaries and lists, with the names of the message's fields.

    Args:
        plan: the plan.
        rate: points per second; first and last sample are always among them.
    """
    trajectory = plan.trajectory
    sample_rate = (len(trajectory.time) - 1) / trajectory.duration
    stride = max(1, round(sample_rate / rate))
    rows = np.unique(np.append(np.arange(0, len(trajectory.time), stride), len(trajectory.time) - 1))
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(trajectory.joint_names),
        "points": [
            {
                "positions": trajectory.position[row].tolist(),
                "velocities": trajectory.velocity[row].tolist(),
                "accelerations": trajectory.acceleration[row].tolist(),
                "effort": [],
                "time_from_start": _duration(float(trajectory.time[row])),
            }
            for row in rows
        ],
    }


def encode(plan: Plan) -> Mapping[str, bytes]:
    """File name -> content."""
    return {FILE: msgspec.json.encode(joint_trajectory_message(plan))}


def _duration(seconds: float) -> dict[str, int]:
    whole, rest = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
    return {"sec": whole, "nanosec": rest}
