"""What is checked of an execution: names, units and limits; and the torques that gravity alone makes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.planning.start import in_agent_frame
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.planning.trajectory.verification import _check_torques, _stride


def test_units_and_limits_of_the_checks(small_plan):
    expected = {
        "keeps its place on": ("m", 1e-3),
        "keeps its angle on": ("rad", np.deg2rad(0.5)),
        "follows its path": ("m", 2e-3),
        "clearance": ("m", 0.0),
        "torque limits": ("of the limit", 1.0),
    }
    seen = set()
    for check in small_plan.checks:
        for part, (unit, limit) in expected.items():
            if part in check.name:
                seen.add(part)
                assert (check.unit, check.limit) == (unit, pytest.approx(limit)), check.name
                assert check.ok == (check.worst >= limit if part == "clearance" else check.worst <= limit)
                assert "None" not in check.where
    assert seen == set(expected)
    names = {check.name for check in small_plan.checks}
    for moved in small_plan.task.moved:
        assert f"{moved.name} follows its path" in names
        for hand in moved.hands:
            assert {f"{hand} hand keeps its {what} on {moved.name}" for what in ("place", "angle")} <= names


def test_where_the_worst_values_are(small_plan):
    """Times within the trajectory; the torque's joint is one of the robot's, the clearances' names are of a pair."""
    duration = small_plan.trajectory.duration
    for check in small_plan.checks:
        if " at " in check.where:
            what, _, time = check.where.rpartition(" at ")
            assert 0.0 <= float(time.removesuffix(" s")) <= duration
            if check.name == "torque limits":
                assert what in small_plan.robot.joint_names
            if check.name.startswith("clearance"):
                assert len(what.split(" and ")) == 2


def test_how_far_an_object_is_off_its_path(small_plan):
    """What is reported is the farthest over all samples: some, and far below the limit."""
    for check in small_plan.checks:
        if "follows its path" in check.name or "keeps its place" in check.name:
            assert 0.0 <= check.worst <= check.limit


@pytest.mark.parametrize(("rate", "stride"), [(10.0, 1), (50.0, 1), (200.0, 4), (333.0, 7), (1000.0, 20)])
def test_torques_are_looked_at_50_times_a_second(rate, stride):
    """Or at each sample, if there are fewer."""
    time, none = np.arange(5) / rate, np.zeros((5, 1))
    assert _stride(JointTrajectory(("joint",), time, none, none, none), 50.0) == stride


def test_only_what_is_lifted_weighs_on_the_arms(small_plan):
    """Standing still at home: 15 kg at their start add nothing, a centimetre above they do."""
    robot, task = in_agent_frame(small_plan.robot), small_plan.task
    zero = np.zeros((3, len(robot.joint_names)))
    still = JointTrajectory(robot.joint_names, np.array([0.0, 0.02, 0.04]), zero + robot.home, zero, zero)
    heavy = replace(task, moved=tuple(replace(m, model=replace(m.model, mass=15.0)) for m in task.moved))
    worst = {}
    for name, of, up in (("light", task, 0.0), ("heavy", heavy, 0.0), ("lifted", heavy, 0.01)):
        poses = {
            moved.name: RigidTransform.from_components(
                np.tile(moved.start.translation + np.array([0.0, 0.0, up]), (3, 1)), moved.start.rotation
            )
            for moved in of.moved
        }
        worst[name] = _check_torques(of, robot, poses, small_plan.grasps, still).worst
    assert worst["light"] == worst["heavy"] < 0.9 * worst["lifted"]
