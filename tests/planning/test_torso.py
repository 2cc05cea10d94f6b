"""A torso that is planned with the arms."""

from pathlib import Path

import numpy as np
import pytest

from sbam.demonstrations.scenes import starting_scene
from sbam.planning.plan import plan
from sbam.robots import ROBOTS, load_robot


@pytest.fixture(scope="module")
def lifting(tmp_path_factory) -> Path:
    """ARMAR-6 with its lift among the planned joints."""
    source = ROBOTS["armar6"]
    text = source.read_text()
    joint = "  TorsoJoint: {home: -0.05, velocity: 0.15, acceleration: 1, jerk: 50, torque: 2000}\n"
    for old, new in (
        ("  TorsoJoint: 0\n", ""),
        ("torso_joints: []", "torso_joints: [TorsoJoint]"),
        ("\njoints:\n", f"\njoints:\n{joint}"),
        ("model: armar6.xml", f"model: {source.with_name('armar6.xml')}"),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path_factory.mktemp("robot") / "lifting.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(("task", "scene"), [("pouring", "pouring_new_layout"), ("rolling", "rolling")])
def test_both_hands_keep_their_grasps_while_the_torso_moves(lifting, model_of, task, scene):
    found = plan(model_of(task), starting_scene(f"built-in:{scene}"), str(lifting))
    assert found.ok, found.problems
    column = found.trajectory.joint_names.index("TorsoJoint")
    torso = found.trajectory.position[:, column]
    assert np.ptp(torso) > 0.005
    assert torso[0] == pytest.approx(-0.05)
    assert torso[-1] == pytest.approx(-0.05, abs=1e-6)
    robot = load_robot(str(lifting))
    assert np.abs(found.trajectory.velocity[:, column]).max() <= 0.5 * robot.velocity_limit[column]
