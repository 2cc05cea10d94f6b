"""Robot descriptions: what is accepted, and what the errors say."""

from pathlib import Path

import numpy as np
import pytest

from sbam.errors import FileFormatError, FileVersionError, UnknownNameError
from sbam.robots import ROBOTS, load_robot, read_description


@pytest.mark.parametrize("name", ROBOTS)
def test_built_in_robots_load(name):
    robot = load_robot(name)
    assert robot.name == name
    assert robot.description.note


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"format_version: 1": "format_version: 2"}, FileVersionError, "version 2 is later than 1"),
        ({"name: torso_robot": "nam: torso_robot"}, FileFormatError, r"torso.yaml"),
        ({"torso_joints": "torso_joint"}, FileFormatError, r"torso_joint.*torso_joints"),
        ({"velocity: 1.7": "velocity: fast"}, FileFormatError, r"\$.joints"),
        ({"velocity: 1.7": "velocity: -1"}, FileFormatError, r"\$.joints"),
        ({"velocity: 1.7": "velocity: .nan"}, FileFormatError, r"\$.joints.lift.velocity.*finite"),
        ({"approach: [0, 0, 1]": "approach: [0, 0, 2]"}, FileFormatError, r"\$.arms.left.hand.approach.*unit vector"),
        ({"[lift, yaw]": "[lift, jaw]"}, UnknownNameError, r"'jaw'.*torso_joints\[1\].*'yaw'"),
        ({"[lift, yaw]": "[lift]"}, FileFormatError, r"\$.joints.yaw.*no arm"),
        ({"[lift, yaw]": "[lift, yaw, left_wrist]"}, FileFormatError, r"left_wrist.*already used"),
        ({"lift: {": "left_finger: {", "[lift, yaw]": "[left_finger, yaw]"}, FileFormatError, "also a planned joint"),
        ({"tcp: left_tcp": "tcp: left_tip"}, UnknownNameError, r"'left_tip'.*\$.arms.left.tcp.*'left_tcp'"),
        ({"body: left_hand": "body: left_tcp"}, UnknownNameError, r"'left_tcp'.*\$.arms.left.hand.body.*'left_hand'"),
        ({"left_finger: 0.5": "left_thumb: 0.5"}, UnknownNameError, r"'left_thumb'.*locked_joints.*'left_finger'"),
        ({"model: torso.xml": "model: trunk.xml"}, FileFormatError, r"\$.parts\[0\].model.*trunk.xml"),
        ({"lift: {": "lift: {home: 0.5, "}, FileFormatError, r"\$.joints.lift.home.*0.2"),
        (
            {"wrist: left_hand": "ik_seeds: [[0, 0]]\n    wrist: left_hand"},
            FileFormatError,
            r"left.ik_seeds\[0\]: 2 values.*3",
        ),
        (
            {"wrist: left_hand": "ik_seeds: [[0, 0, 1], [0, 0, 2]]\n    wrist: left_hand"},
            FileFormatError,
            r"ik_seeds\[1\]\[2\]: is 2",
        ),
    ],
)
def test_errors_name_the_place(write_torso_robot, changes, error, message):
    with pytest.raises(error, match=message):
        load_robot(write_torso_robot(changes))


def test_one_arm_is_not_enough(write_torso_robot):
    path = write_torso_robot({"  right:": "  rechts:"})
    with pytest.raises(FileFormatError, match="arms"):
        load_robot(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"</mujoco>": ""}, "torso.xml.*MuJoCo cannot read"),
        ({'type="slide"': 'type="ball"'}, "'lift' is neither hinge nor slide"),
        ({"limited=": "limitless="}, "torso.xml"),
    ],
)
def test_broken_models(write_torso_robot, changes, message):
    with pytest.raises(FileFormatError, match=message):
        load_robot(write_torso_robot(changes, in_model=True))


@pytest.mark.parametrize("text", ["", "just text", "a: [1", "- 1\n- 2"])
def test_files_that_are_no_description(tmp_path, text):
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(FileFormatError, match=r"robot\.yaml"):
        read_description(path)


def test_missing_files_and_unknown_names(tmp_path):
    with pytest.raises(FileFormatError, match=r"none\.yaml"):
        load_robot(tmp_path / "none.yaml")
    with pytest.raises(UnknownNameError, match="panda_dual"):
        load_robot(tmp_path / "robot.txt")


def test_base_distance_needs_two_parts_and_a_length(write_torso_robot):
    with pytest.raises(FileFormatError, match="two parts"):
        load_robot(write_torso_robot({}), base_distance=0.5)
    for distance in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(FileFormatError, match="positive"):
            load_robot("panda_dual", base_distance=distance)


def test_description_survives_the_relative_path(write_torso_robot, monkeypatch):
    path = write_torso_robot({})
    monkeypatch.chdir(path.parent)
    assert load_robot(Path("torso.yaml")).name == "torso_robot"
