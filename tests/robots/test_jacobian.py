"""Jacobians against finite differences, on the built-in robots and on one with a torso and a lift."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.robots import load_robot, point_jacobian, rotation_jacobian

STEP = 1e-6


@pytest.fixture(scope="module", params=["panda_dual", "torso_robot"])
def robot(request, torso_robot):
    return torso_robot if request.param == "torso_robot" else load_robot(request.param)


def test_against_central_differences(robot):
    n = len(robot.joint_names)
    q = np.random.default_rng(1).uniform(np.maximum(robot.lower, -3), np.minimum(robot.upper, 3), (50, n))
    local = np.array([0.03, -0.05, 0.2])
    for arm in robot.arms.values():
        frame = arm.tcp_frame

        def point(kinematics):
            return kinematics.position[:, 0] + kinematics.rotation[:, 0] @ local

        kinematics = robot.kinematics(q, [frame])
        mask = robot.frame_joints(frame)
        translation = point_jacobian(kinematics, point(kinematics), mask)
        rotation = rotation_jacobian(kinematics, mask)
        assert translation.shape == rotation.shape == (50, 3, n)
        for joint in range(n):
            ends = [robot.kinematics(q + sign * STEP * np.eye(n)[joint], [frame]) for sign in (-1, 1)]
            for back, ahead in pairwise(ends):
                np.testing.assert_allclose(
                    translation[:, :, joint], (point(ahead) - point(back)) / (2 * STEP), atol=1e-8
                )
                turn = Rotation.from_matrix(ahead.rotation[:, 0] @ back.rotation[:, 0].swapaxes(1, 2))
                np.testing.assert_allclose(rotation[:, :, joint], turn.as_rotvec() / (2 * STEP), atol=1e-8)


def test_other_arm_does_not_move_the_point(robot):
    kinematics = robot.kinematics(robot.home[None], ["left_tcp"])
    jacobian = point_jacobian(kinematics, kinematics.position[:, 0], robot.frame_joints("left_tcp"))
    assert not jacobian[:, :, robot.arms["right"].joint_indices].any()
