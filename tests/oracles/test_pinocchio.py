"""Kinematics and Jacobians of the Panda agree with Pinocchio, which reads the arm's model file on its own."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.robots import ROBOTS, load_robot, point_jacobian, rotation_jacobian

pin = pytest.importorskip("pinocchio")
SAMPLES = 1000
FINGERS_OPEN = 0.04


@pytest.mark.parametrize("side", ["left", "right"])
def test_thousand_random_postures(side):
    robot = load_robot("panda_dual").placed(
        RigidTransform.from_components([0.3, -1.2, 0.9], Rotation.from_euler("xyz", [0.2, -0.3, 2.0]))
    )
    q = np.random.default_rng(2).uniform(robot.lower, robot.upper, (SAMPLES, len(robot.joint_names)))
    model = pin.buildModelFromMJCF(str(ROBOTS["panda_dual"].parent / "panda_arm.xml"))
    data = model.createData()
    assert list(model.names)[1:8] == [f"joint{i}" for i in range(1, 8)]
    arm = robot.arms[side].joint_indices
    T_base_arm = RigidTransform.from_translation([0, 0.4 if side == "left" else -0.4, 0])
    T_world_arm = robot.T_world_base * T_base_arm
    turn = T_world_arm.rotation.as_matrix()

    frames = ["tcp", "link4", "link6", "finger_a"]
    kinematics = robot.kinematics(q, [f"{side}_{frame}" for frame in frames])
    for index, frame in enumerate(frames):
        identity = model.getFrameId(frame)
        mask = robot.frame_joints(f"{side}_{frame}")
        translation = point_jacobian(kinematics, kinematics.position[:, index], mask)
        ours = np.concatenate([translation, rotation_jacobian(kinematics, mask)], axis=1)
        theirs = np.zeros_like(ours)
        position, rotation = np.empty((SAMPLES, 3)), np.empty((SAMPLES, 3, 3))
        for sample in range(SAMPLES):
            configuration = np.append(q[sample, arm], [FINGERS_OPEN, FINGERS_OPEN])
            jacobian = pin.computeFrameJacobian(model, data, configuration, identity, pin.LOCAL_WORLD_ALIGNED)[:, :7]
            theirs[sample, :3, arm] = (turn @ jacobian[:3]).T
            theirs[sample, 3:, arm] = (turn @ jacobian[3:]).T
            pose = pin.updateFramePlacement(model, data, identity)
            position[sample] = turn @ pose.translation + T_world_arm.translation
            rotation[sample] = turn @ pose.rotation
        np.testing.assert_allclose(kinematics.position[:, index], position, atol=1e-9)
        np.testing.assert_allclose(kinematics.rotation[:, index], rotation, atol=1e-9)
        np.testing.assert_allclose(ours, theirs, atol=1e-9)
