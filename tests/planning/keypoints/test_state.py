"""What configurations do to regions and objects."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.keypoints.state import Carrying, RegionPoint, State, Workspace
from sbam.robots import ROBOTS

STEP = 1e-6


@pytest.fixture
def state(workspace, within_limits) -> State:
    return workspace.state(within_limits(workspace.robot, np.random.default_rng(9), 6))


def test_regions_follow_the_chain_of_transforms(state):
    """T_agent_tcp * T_tcp_object * point, by scipy."""
    w, k = state.workspace, state.kinematics
    for index, region in enumerate(w.regions):
        if region.carrying < 0:
            np.testing.assert_array_equal(state.region_position[:, index], np.tile(region.position, (6, 1)))
            continue
        carrying = w.carryings[region.carrying]
        arm = w.arms.index(carrying.arm)
        tcp = RigidTransform.from_components(k.position[:, arm], Rotation.from_matrix(k.rotation[:, arm]))
        expected = (tcp * carrying.T_tcp_object).apply(region.position)
        np.testing.assert_allclose(state.region_position[:, index], expected, atol=1e-12)
        np.testing.assert_allclose(
            state.region_position[:, index], state.object_poses()[carrying.role].apply(region.position), atol=1e-12
        )


def test_regions_of_the_panda_by_pinocchio(panda, within_limits):
    """Pinocchio reads the arm's file on its own; the left base stands 40 cm left, x forward is the agent's y."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromMJCF(str(ROBOTS["panda_dual"].parent / "panda_arm.xml"))
    data = model.createData()
    generator = np.random.default_rng(10)
    held = RigidTransform.from_components([0.02, -0.03, 0.05], Rotation.random(rng=generator))
    point = np.array([0.0, 0.245, 0.01])
    workspace = Workspace(panda, [Carrying("bottle", "left", held)], [RegionPoint(0, point)])
    q = within_limits(panda, generator, 20)
    state = workspace.state(q)
    T_agent_base = RigidTransform.from_components([-0.40, 0.0, 0.0], Rotation.from_euler("z", 90, degrees=True))
    for sample in range(20):
        pin.forwardKinematics(model, data, np.append(q[sample, panda.arms["left"].joint_indices], [0.04, 0.04]))
        pose = pin.updateFramePlacement(model, data, model.getFrameId("tcp"))
        tcp = T_agent_base * RigidTransform.from_components(pose.translation, Rotation.from_matrix(pose.rotation))
        np.testing.assert_allclose(state.region_position[sample, 0], (tcp * held).apply(point), atol=1e-9)


def test_a_flying_hand_by_hand(robot_named):
    """Hand at (1, 2, 3), turned by 90 degrees about z: the object's x points to y, its y to -x."""
    robot = robot_named("flying_hands")
    carrying = Carrying("cup", "right", RigidTransform.from_translation([0.0, 0.0, -0.5]))
    workspace = Workspace(robot, [carrying], [RegionPoint(0, np.array([0.1, 0.2, 0.3])), RegionPoint(-1, np.ones(3))])
    q = np.zeros((1, len(robot.joint_names)))
    q[0, robot.arms["right"].joint_indices[:4]] = 1.0, 2.0, 3.0, np.pi / 2
    state = workspace.state(q)
    np.testing.assert_allclose(state.region_position[0], [[0.8, 2.1, 2.8], [1.0, 1.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(state.object_position[0], [[1.0, 2.0, 2.5]], atol=1e-12)
    slides = robot.arms["right"].joint_indices[:3]
    np.testing.assert_allclose(state.region_jacobian[0, 0][:, slides], np.eye(3), atol=1e-12)
    # Turning about the hand's z: z x (point - hand) = z x (-0.2, 0.1, ...) = (-0.1, -0.2, 0).
    yaw = robot.arms["right"].joint_indices[3]
    np.testing.assert_allclose(state.region_jacobian[0, 0][:, yaw], [-0.1, -0.2, 0.0], atol=1e-12)
    assert not state.region_jacobian[0, 0][:, robot.arms["left"].joint_indices].any()
    assert not state.region_jacobian[0, 1].any()


def test_jacobians_are_those_of_differences(state):
    w, q = state.workspace, state.configurations
    for joint in range(q.shape[1]):
        step = STEP * np.eye(q.shape[1])[joint]
        ahead, behind = w.state(q + step), w.state(q - step)
        for name in ("region", "object"):
            slope = (getattr(ahead, f"{name}_position") - getattr(behind, f"{name}_position")) / (2 * STEP)
            np.testing.assert_allclose(getattr(state, f"{name}_jacobian")[..., joint], slope, atol=1e-8)
        turn = np.swapaxes(behind.object_rotation, -1, -2)
        angular = Rotation.from_matrix((ahead.object_rotation @ turn).reshape(-1, 3, 3)).as_rotvec() / (2 * STEP)
        np.testing.assert_allclose(
            state.object_rotation_jacobian[..., joint], angular.reshape(state.object_position.shape), atol=1e-8
        )


def test_nothing_needs_to_be_carried(panda):
    workspace = Workspace(panda, [], [RegionPoint(-1, np.array([1.0, 2.0, 3.0]))])
    state = workspace.state(np.tile(panda.home, (3, 1)))
    np.testing.assert_array_equal(state.region_position, np.broadcast_to([1.0, 2.0, 3.0], (3, 1, 3)))
    assert state.object_poses() == {}
    assert not state.region_jacobian.any()
