"""The natural posture against its definition by rotations, derivatives against differences, symmetry, scaling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError
from sbam.robots import NaturalDirections, load_robot
from sbam.robots.human_likeness import PERSON_ARM_LENGTH, natural_directions

STEP = 1e-6


@pytest.fixture(scope="module", params=["panda_dual", "torso_robot"])
def robot(request, torso_robot):
    T_world_agent = RigidTransform.from_components([1, 2, 0.9], Rotation.from_euler("z", 2.2))
    robot = torso_robot if request.param == "torso_robot" else load_robot(request.param)
    return robot.placed_for(T_world_agent)


def configurations(robot, count, seed=0):
    n = len(robot.home)
    return robot.clip(robot.home + np.random.default_rng(seed).normal(size=(count, n)) * 0.5)


def by_rotations(hand):
    """Definition: u = Rz(-eta) Rx(theta) (-e_z), f = Rz(-alpha) Rx(-beta) e_z."""
    t = 100 * np.asarray(hand)
    distance = np.linalg.norm(t)
    chi = np.degrees(np.arctan2(t[0], t[1]))
    psi = np.degrees(np.arctan2(t[2], np.hypot(t[0], t[1])))
    theta = -4.0 + 1.10 * distance + 0.90 * psi
    beta = 39.4 + 0.54 * distance - 1.06 * psi
    eta = 13.2 + 0.86 * chi + 0.11 * psi
    alpha = -10.0 + 1.08 * chi - 0.35 * psi
    upper = Rotation.from_euler("ZX", [-eta, theta], degrees=True).apply([0, 0, -1])
    fore = Rotation.from_euler("ZX", [-alpha, -beta], degrees=True).apply([0, 0, 1])
    return upper, fore


coordinate = st.floats(-0.6, 0.6)


@given(st.tuples(coordinate, st.floats(0.05, 0.6), coordinate))
def test_natural_directions_follow_their_definition(hand):
    direction, derivative = natural_directions(np.array([hand]))
    np.testing.assert_allclose(direction[0], by_rotations(hand), atol=1e-12)
    for axis in range(3):
        ends = [natural_directions(np.array([hand]) + sign * STEP * np.eye(3)[axis])[0][0] for sign in (-1, 1)]
        np.testing.assert_allclose(derivative[0, :, :, axis], (ends[1] - ends[0]) / (2 * STEP), atol=1e-5)


def test_posture_of_a_person_who_reaches_forward():
    """A hand 40 cm straight ahead and 20 cm below the shoulder: the elbow hangs below, the forearm points forward."""
    upper, fore = natural_directions(np.array([[0.0, 0.4, -0.2]]))[0][0]
    assert upper[2] < -0.8 and fore[1] > 0.8
    end = 0.30 * upper + 0.33 * fore
    assert np.linalg.norm(end - [0, 0.4, -0.2]) < 0.15


def test_hand_above_or_at_the_shoulder_is_finite():
    for hand in ([0, 0, 0.5], [0, 0, 0], [0, 0, -0.5]):
        direction, derivative = natural_directions(np.array([hand], dtype=float))
        assert np.isfinite(direction).all() and np.isfinite(derivative).all()


def test_value_is_the_equation_and_half_the_squared_residual(robot):
    mu = 0.7
    term = NaturalDirections(robot, forearm_weight=mu)
    kinematics = robot.kinematics(configurations(robot, 20), term.frames)
    turn = robot.T_world_agent.rotation.inv()
    expected = np.zeros(20)
    for side, arm in robot.arms.items():
        names = (arm.shoulder_frame, arm.elbow_frame, arm.wrist_frame, arm.tcp_frame)
        points = [kinematics.position[:, kinematics.frames.index(name)] for name in names]
        for b in range(20):
            shoulder, elbow, wrist, tcp = (turn.apply(point[b]) for point in points)
            mirror = np.array([-1, 1, 1]) if side == "left" else np.ones(3)
            upper, fore = by_rotations((tcp - shoulder) * mirror * PERSON_ARM_LENGTH / arm.length)
            upper_robot = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
            fore_robot = (wrist - elbow) / np.linalg.norm(wrist - elbow)
            expected[b] += 1 - upper_robot @ (upper * mirror) + mu * (1 - fore_robot @ (fore * mirror))
    np.testing.assert_allclose(term.value(kinematics), expected, atol=1e-12)


def test_derivatives(robot):
    term = NaturalDirections(robot, forearm_weight=0.5)
    q = configurations(robot, 10, seed=1)
    kinematics = robot.kinematics(q, ["robot_base", *term.frames])
    jacobian, gradient = term.jacobian(kinematics), term.gradient(kinematics)
    assert jacobian.shape == (10, 12, q.shape[1])
    for joint in range(q.shape[1]):
        back, ahead = (robot.kinematics(q + sign * STEP * np.eye(q.shape[1])[joint], term.frames) for sign in (-1, 1))
        slope = (term.residual(ahead) - term.residual(back)) / (2 * STEP)
        np.testing.assert_allclose(jacobian[:, :, joint], slope, atol=2e-6)
        slope = (term.value(ahead) - term.value(back)) / (2 * STEP)
        np.testing.assert_allclose(gradient[:, joint], slope, atol=2e-6)


def test_mirrored_posture_deviates_alike():
    """Panda: joints 1, 3, 5, 7 change sign under mirroring (joint 7 about its home of 45 degrees)."""
    robot = load_robot("panda_dual")
    term = NaturalDirections(robot)
    q = configurations(robot, 20, seed=2)
    q[:, 7:] = q[:, :7] * [-1, 1, -1, 1, -1, 1, -1]
    q[:, 13] += np.pi / 2
    deviation = term.deviation(robot.kinematics(q, term.frames))
    np.testing.assert_allclose(deviation[:, 0], deviation[:, 1], atol=1e-9)
    assert ((deviation >= 0) & (deviation <= 180)).all()


def test_deviation_agrees_with_the_value(robot):
    term = NaturalDirections(robot)
    kinematics = robot.kinematics(configurations(robot, 10), term.frames)
    cosines = np.cos(np.deg2rad(term.deviation(kinematics)))
    np.testing.assert_allclose((1 - cosines).sum(axis=(1, 2)), term.value(kinematics), atol=1e-12)


def test_coinciding_frames_are_refused(write_torso_robot):
    path = write_torso_robot({"elbow: left_fore": "elbow: left_upper"})
    with pytest.raises(FileFormatError, match=r"torso.yaml at \$.arms.left.elbow"):
        NaturalDirections(load_robot(path))
