"""The joint form of human-likeness."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.errors import FileFormatError
from sbam.robots import NaturalDirections, load_robot
from sbam.robots.human_likeness import PERSON_ARM_LENGTH, natural_angles
from sbam.robots.natural_joints import NaturalJoints

ARMARS = ("armar6", "armar7")
MIRROR = np.array([-1, -1, 1, -1, 1])


def near_home(robot, count: int, seed: int = 0) -> np.ndarray:
    generator = np.random.default_rng(seed)
    return robot.clip(robot.home + generator.normal(0, 0.3, (count, len(robot.home))))


@pytest.mark.parametrize("name", ARMARS)
def test_gradient_by_differences(name):
    robot = load_robot(name)
    term = NaturalJoints(robot)
    q = near_home(robot, 5)
    jacobian = term.jacobian(robot.kinematics(q, term.frames))
    step = 1e-6
    for joint in range(q.shape[1]):
        moved = [q + sign * step * np.eye(q.shape[1])[joint] for sign in (1, -1)]
        ahead, back = (term.residual(robot.kinematics(one, term.frames), one) for one in moved)
        np.testing.assert_allclose(jacobian[..., joint], (ahead - back) / (2 * step), atol=1e-6)


@pytest.mark.parametrize("name", ARMARS)
def test_the_formula_as_it_is_written(name):
    """By rotation matrices, for the right arm."""
    robot = load_robot(name)
    term = NaturalJoints(robot)
    q = near_home(robot, 20, seed=1)
    kinematics = robot.kinematics(q, term.frames)
    arm = robot.arms["right"]
    ends = [kinematics.position[:, kinematics.frames.index(frame)] for frame in (arm.shoulder_frame, arm.tcp_frame)]
    hand = robot.T_world_agent.rotation.inv().apply(ends[1] - ends[0]) * PERSON_ARM_LENGTH / arm.length
    angles, _ = natural_angles(hand)
    for row in range(len(q)):
        theta, eta, beta = angles[row, 0, 0], angles[row, 0, 1], angles[row, 1, 0]
        u = Rotation.from_euler("x", -theta) * Rotation.from_euler("z", -eta) * Rotation.from_euler("x", theta)
        x, _, z = u.apply([0, 0, -1])
        natural = np.array([0, theta, max(-0.1, np.arctan2(x, -z)), -np.pi / 4, beta])
        off = q[row, arm.joint_indices[:5]] - natural
        off[[1, 3]] = (off[[1, 3]] + np.pi) % (2 * np.pi) - np.pi
        expected = np.linalg.norm(np.array([0.5, 1, 2, 0.5, 0.5]) * off)
        assert term.value(kinematics, q)[row, list(robot.arms).index("right")] == pytest.approx(expected)


@pytest.mark.parametrize("name", ARMARS)
def test_mirrored_postures_are_equally_natural(name):
    robot = load_robot(name)
    term = NaturalJoints(robot)
    left, right = robot.arms["left"].joint_indices, robot.arms["right"].joint_indices
    q = np.tile(robot.home, (8, 1))
    q[:, left[:5]] += np.random.default_rng(2).normal(0, 0.3, (8, 5))
    q[:, left[5:]] = q[:, right[5:]] = 0.0
    q[:, right[:5]] = MIRROR * q[:, left[:5]]
    value = term.value(robot.kinematics(q, term.frames), q)
    np.testing.assert_allclose(value[:, 0], value[:, 1], atol=1e-4)


@pytest.mark.parametrize("name", ARMARS)
def test_natural_joints_are_nearly_natural_directions(name):
    """Both forms mean the same posture; ARMAR-6's first shoulder axis is tilted by 15 degrees."""
    robot = load_robot(name)
    term, directions = NaturalJoints(robot), NaturalDirections(robot)
    q = np.tile(robot.home, (1, 1))
    for _ in range(200):  # the hand moves with the arm: the natural posture of a hand that it leads to
        kinematics = robot.kinematics(q, term.frames)
        for arm in robot.arms.values():
            natural = term._natural(kinematics, arm)[0]
            q[:, arm.joint_indices[:5]] += 0.1 * (natural - q[:, arm.joint_indices[:5]])
    assert term.value(robot.kinematics(q, term.frames), q).max() < 1e-3
    assert directions.deviation(robot.kinematics(q, directions.frames))[..., 0].max() < 25


def test_other_robots_have_no_such_joints():
    with pytest.raises(FileFormatError, match="natural_joints"):
        NaturalJoints(load_robot("panda_dual"))


@pytest.mark.parametrize(("side", "outwards"), [("left", 1), ("right", -1)])
def test_swivel(side, outwards):
    """Lifting the elbow sideways turns it outwards: positive on the left, negative on the right."""
    robot = load_robot("armar6")
    likeness = NaturalDirections(robot)
    arm = robot.arms[side]
    column = list(robot.arms).index(side)
    q = np.tile(robot.home, (2, 1))
    q[:, arm.joint_indices] = 0.0
    q[:, arm.joint_indices[4]] = 1.6
    q[:, arm.joint_indices[1]] = -0.3 if side == "left" else 0.3
    q[1, arm.joint_indices[2]] = 0.6  # the upper arm is spread
    narrow, wide = likeness.swivel(robot.kinematics(q, likeness.frames))[:, column]
    assert abs(narrow) < 20
    assert outwards * (wide - narrow) > 15
