"""Kinematics and Jacobians of the built-in robots agree with Pinocchio, which reads the model files on its own."""

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


@pytest.mark.parametrize("name", ["armar6", "armar7"])
def test_thousand_random_postures_of_the_armars(name):
    """All joints but torso and neck move; continuous ones turn more than once."""
    robot = load_robot(name).placed(
        RigidTransform.from_components([0.3, -1.2, 0.1], Rotation.from_euler("xyz", [0.2, -0.3, 2.0]))
    )
    low, high = np.maximum(robot.lower, -8.0), np.minimum(robot.upper, 8.0)
    q = np.random.default_rng(3).uniform(low, high, (SAMPLES, len(robot.joint_names)))
    model = pin.buildModelFromMJCF(str(ROBOTS[name].with_suffix(".xml")))
    data = model.createData()
    free = dict.fromkeys(robot.joint_names, 0.0) | dict(robot.description.locked_joints)
    names = list(model.names)[1:]
    assert set(names) == set(free)
    columns = [model.joints[model.getJointId(name)].idx_v for name in robot.joint_names]
    turn, origin = robot.T_world_base.rotation.as_matrix(), robot.T_world_base.translation

    frames = ["left_tcp", "right_tcp", "left_forearm", "right_elbow", "head"]
    kinematics = robot.kinematics(q, frames)
    identities = [model.getFrameId(frame) for frame in frames]
    masks = [robot.frame_joints(frame) for frame in frames]
    ours = np.array(
        [
            np.concatenate(
                [point_jacobian(kinematics, kinematics.position[:, i], m), rotation_jacobian(kinematics, m)], 1
            )
            for i, m in enumerate(masks)
        ]
    )
    for sample in range(SAMPLES):
        values = free | dict(zip(robot.joint_names, q[sample], strict=True))
        configuration = np.array([values[name] for name in names])
        pin.computeJointJacobians(model, data, configuration)
        pin.updateFramePlacements(model, data)
        for index, identity in enumerate(identities):
            pose = data.oMf[identity]
            position, rotation = kinematics.position[sample, index], kinematics.rotation[sample, index]
            np.testing.assert_allclose(position, turn @ pose.translation + origin, atol=1e-9)
            np.testing.assert_allclose(rotation, turn @ pose.rotation, atol=1e-9)
            jacobian = pin.getFrameJacobian(model, data, identity, pin.LOCAL_WORLD_ALIGNED)[:, columns]
            theirs = np.concatenate([turn @ jacobian[:3], turn @ jacobian[3:]])
            np.testing.assert_allclose(ours[index, sample], theirs, atol=1e-9)
