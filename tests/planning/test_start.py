"""Starting from where the robot stands."""

import numpy as np
import pytest

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.planning.start import start_from


def test_named_joints_move_and_the_others_stay(panda):
    robot, notes = start_from(panda, {"left_joint1": 0.3})
    assert notes == ()
    changed = np.flatnonzero(robot.home != panda.home)
    assert [robot.joint_names[i] for i in changed] == ["left_joint1"]
    assert robot.home[changed] == 0.3
    assert panda.home[changed] == 0.0


def test_outside_the_limits_is_projected_and_said(panda):
    robot, notes = start_from(panda, {"right_joint4": -3.5})
    column = panda.joint_names.index("right_joint4")
    assert panda.lower[column] < robot.home[column] < panda.lower[column] + 0.01
    assert len(notes) == 1
    assert "right_joint4" in notes[0]
    assert "-3.5" in notes[0]


def test_unknown_joint_lists_the_known_ones(panda):
    with pytest.raises(UnknownNameError, match=r"'elbow'.*'left_joint1'"):
        start_from(panda, {"elbow": 0.0})


@pytest.mark.parametrize("position", [np.nan, np.inf])
def test_not_finite_is_refused(panda, position):
    with pytest.raises(ConfigurationError, match="left_joint2"):
        start_from(panda, {"left_joint2": position})
