"""The ROS message holds what a joint trajectory controller accepts and gives the trajectory back."""

import json

import numpy as np
import pytest
from scipy.interpolate import BPoly

from sbam.export.ros import FILE, encode
from sbam.planning.plan import Plan


@pytest.fixture(scope="module")
def message(small_plan: Plan) -> dict:
    return json.loads(encode(small_plan)[FILE])


def test_the_rules_of_the_controller_hold(small_plan: Plan, message: dict) -> None:
    assert tuple(message["joint_names"]) == small_plan.trajectory.joint_names
    times = [point["time_from_start"] for point in message["points"]]
    assert all(isinstance(t["sec"], int) and 0 <= t["nanosec"] < 1_000_000_000 for t in times)
    nanoseconds = np.array([t["sec"] * 1_000_000_000 + t["nanosec"] for t in times])
    assert (np.diff(nanoseconds) > 0).all()
    assert nanoseconds[-1] == round(1e9 * small_plan.trajectory.duration)
    for point in message["points"]:
        assert {len(point[key]) for key in ("positions", "velocities", "accelerations")} == {14}
        assert point["effort"] == []
    assert not any(message["points"][-1]["velocities"])


def test_quintics_between_the_points_give_the_trajectory_back(small_plan: Plan, message: dict) -> None:
    points = message["points"]
    time = np.array([p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points])
    derivatives = np.stack([[p[key] for p in points] for key in ("positions", "velocities", "accelerations")], axis=1)
    quintic = BPoly.from_derivatives(time, derivatives)
    trajectory = small_plan.trajectory
    assert len(time) < len(trajectory.time) / 9
    assert np.abs(quintic(trajectory.time) - trajectory.position).max() < 1e-5
    assert np.abs(quintic(trajectory.time, 1) - trajectory.velocity).max() < 5e-3
