"""Options behind a robot's name."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import load_robot
from sbam.robots.options import options_text, split_options

NUMBERS = st.floats(-100, 100).map(lambda value: float(f"{value:.6g}"))


@given(st.dictionaries(st.sampled_from(["base_distance", "right", "turn", "Hip"]), NUMBERS, min_size=1))
def test_text_and_options_are_the_same(options):
    for name in ("panda_dual", "robots/own.yaml", r"C:\robots\own.yaml"):
        assert split_options(f"{name}:{options_text(options)}") == (name, options)


@pytest.mark.parametrize("text", ["panda_dual", "a/b.yaml", r"C:\x=1\own.yaml", "folder=1/own.yaml", ""])
def test_names_without_options(text):
    assert split_options(text) == (text, {})


def test_base_distance():
    apart = load_robot("panda_dual:base_distance=0.9")
    frames = ["left_link0", "right_link0"]
    left, right = apart.kinematics(apart.home[None], frames).position[0]
    assert np.linalg.norm(left - right) == pytest.approx(0.9)
    assert apart.description.options == {"base_distance": 0.9}


def test_moves_of_the_base():
    """Moved along the agent's axes and turned about its own vertical."""
    plain, moved = load_robot("armar6"), load_robot("armar6:right=0.1,forward=-0.2,up=0.05,turn=30")
    offset = np.add(plain.T_world_base.translation, [0.1, -0.2, 0.05])
    np.testing.assert_allclose(moved.T_world_base.translation, offset, atol=1e-12)
    turn = (moved.T_world_base.rotation * plain.T_world_base.rotation.inv()).as_rotvec(degrees=True)
    np.testing.assert_allclose(turn, [0, 0, 30], atol=1e-9)


def test_locked_joints():
    lowered = load_robot("armar6:TorsoJoint=-0.15")
    plain = load_robot("armar6")
    drop = [robot.kinematics(robot.home[None], ["left_tcp"]).position[0, 0] for robot in (plain, lowered)]
    np.testing.assert_allclose(drop[0] - drop[1], [0, 0, 0.15], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("armar6:torso=1", UnknownNameError, r"robot option 'torso'.*'base_distance', 'right'.*'TorsoJoint'"),
        ("armar6:turn=left", ConfigurationError, "option turn is 'left'"),
        ("armar6:turn=nan", ConfigurationError, "finite number"),
        ("armar9:turn=1", UnknownNameError, "robot 'armar9'"),
    ],
)
def test_bad_options(name, error, message):
    with pytest.raises(error, match=message):
        load_robot(name)
