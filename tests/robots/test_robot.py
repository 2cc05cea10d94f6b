"""Kinematics of the built-in robots: check values, placement, masks, bad input."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import ConfigurationError, UnknownNameError
from sbam.robots import Robot, load_robot

FRAMES = ("left_tcp", "right_tcp", "left_link4", "right_finger_a")


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda_dual")


def random_configurations(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(robot.lower, robot.upper, (count, len(robot.joint_names)))


def test_published_home_pose(robot):
    """The manufacturer's ready posture puts the TCP 0.307 m ahead and 0.487 m above its base, pointing down."""
    stood = robot.placed(RigidTransform.identity())
    kinematics = stood.kinematics(robot.home[None], ["left_tcp", "right_tcp"])
    np.testing.assert_allclose(kinematics.position[0], [[0.307, 0.4, 0.487], [0.307, -0.4, 0.487]], atol=2e-4)
    np.testing.assert_allclose(kinematics.rotation[0, :, :, 2], [[0, 0, -1]] * 2, atol=1e-12)


def test_stands_facing_forward_in_the_agent_frame(robot):
    """Agent frame: x right, y forward; the left arm is at the left."""
    kinematics = robot.kinematics(robot.home[None], ["left_tcp", "right_tcp", "left_link0"])
    np.testing.assert_allclose(kinematics.position[0, :2], [[-0.4, 0.307, 0.487], [0.4, 0.307, 0.487]], atol=2e-4)
    np.testing.assert_allclose(kinematics.position[0, 2], [-0.4, 0, 0], atol=1e-12)
    np.testing.assert_allclose((robot.T_world_agent.as_matrix()), np.eye(4), atol=1e-12)


def test_placing_moves_every_output_rigidly(robot):
    T_world_agent = RigidTransform.from_components([0.2, -0.1, 0.88], Rotation.from_euler("xyz", [0.1, -0.2, 1.3]))
    placed = robot.placed_for(T_world_agent)
    q = random_configurations(robot, 20)
    here, there = robot.kinematics(q, FRAMES), placed.kinematics(q, FRAMES)
    turn = T_world_agent.rotation.as_matrix()
    expected = here.position @ turn.T + T_world_agent.translation
    np.testing.assert_allclose(there.position, expected, atol=1e-12)
    np.testing.assert_allclose(there.rotation, turn @ here.rotation, atol=1e-12)
    np.testing.assert_allclose(there.joint_axis, here.joint_axis @ turn.T, atol=1e-12)
    anchors = here.joint_position @ turn.T + T_world_agent.translation
    np.testing.assert_allclose(there.joint_position, anchors, atol=1e-12)
    np.testing.assert_allclose(placed.T_world_agent.as_matrix(), T_world_agent.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(robot.kinematics(q, FRAMES).position, here.position, atol=0)


def test_spec_compiles_to_the_same_place(robot):
    placed = robot.placed_for(RigidTransform.from_components([1, 2, 3], Rotation.from_rotvec([0, 0, 0.5])))
    fresh = placed.spec().compile()
    np.testing.assert_allclose(fresh.body_pos, placed.model.body_pos, atol=1e-12)
    np.testing.assert_allclose(fresh.body_quat, placed.model.body_quat, atol=1e-12)


def test_masks_are_the_joints_that_move_the_frame(robot):
    q = random_configurations(robot, 1)
    for frame in FRAMES:
        before = robot.kinematics(q, [frame])
        moved = []
        for joint in range(len(robot.joint_names)):
            other = q.copy()
            other[0, joint] += 0.1
            after = robot.kinematics(other, [frame])
            moved.append(not np.allclose(after.rotation, before.rotation, atol=1e-9))
        np.testing.assert_array_equal(robot.frame_joints(frame), moved)


def test_limits_and_arms(robot):
    assert robot.joint_names == tuple(f"{side}_joint{i}" for side in ("left", "right") for i in range(1, 8))
    assert (robot.lower < robot.home).all() and (robot.home < robot.upper).all()
    assert set(robot.arms) == {"left", "right"}
    np.testing.assert_array_equal(robot.arms["right"].joint_indices, np.arange(7, 14))
    np.testing.assert_allclose(robot.velocity_limit[:7], [2.175] * 4 + [2.61] * 3)
    np.testing.assert_allclose(robot.torque_limit[7:], [87] * 4 + [12] * 3)
    assert not robot.is_prismatic.any() and not robot.is_continuous.any()
    for arm in robot.arms.values():
        seeds = arm.ik_seeds
        assert (robot.lower[arm.joint_indices] <= seeds).all() and (seeds <= robot.upper[arm.joint_indices]).all()


def test_arm_length_is_the_largest_distance_of_tcp_and_shoulder(robot):
    kinematics = robot.kinematics(random_configurations(robot, 20000), ["left_tcp", "left_link2"])
    reach = np.linalg.norm(kinematics.position[:, 0] - kinematics.position[:, 1], axis=1).max()
    assert 0.97 * robot.arms["left"].length < reach < robot.arms["left"].length + 1e-3


def test_fingers_stand_open_at_the_widest_object(robot):
    kinematics = robot.kinematics(robot.home[None], ["left_finger_a", "left_finger_b", "left_tcp"])
    gap = kinematics.position[0, 0] - kinematics.position[0, 1]
    np.testing.assert_allclose(gap, 0.08 * kinematics.rotation[0, 2, :, 1], atol=1e-12)


def test_base_distance(robot):
    wide = load_robot("panda_dual", base_distance=1.0)
    kinematics = wide.kinematics(robot.home[None], ["left_link0", "right_link0"])
    np.testing.assert_allclose(kinematics.position[0], [[-0.5, 0, 0], [0.5, 0, 0]], atol=1e-12)


def test_threads_and_pickles_agree(robot):
    q = random_configurations(robot, 200)
    expected = robot.kinematics(q, FRAMES).position
    with ThreadPoolExecutor(4) as pool:
        for position in pool.map(lambda _: robot.kinematics(q, FRAMES).position, range(16)):
            np.testing.assert_array_equal(position, expected)
    twin = pickle.loads(pickle.dumps(robot))
    np.testing.assert_array_equal(twin.kinematics(q, FRAMES).position, expected)


@pytest.mark.parametrize("count", [1, 7, 8, 9, 30])
@pytest.mark.parametrize("name", ["panda_dual", "armar6"])
def test_many_configurations_are_as_mujoco_says_one_by_one(name, count):
    robot = load_robot(name).placed(RigidTransform.from_components([0.3, -0.2, 0.1], Rotation.from_rotvec([0, 0, 0.7])))
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (count, len(robot.joint_names)))
    bodies = [robot.model.body(i).name for i in range(1, robot.model.nbody)]
    kinematics = robot.kinematics(q, bodies)
    data = mujoco.MjData(robot.model)
    for i in range(count):
        data.qpos[:] = q[i]
        mujoco.mj_kinematics(robot.model, data)
        np.testing.assert_allclose(kinematics.position[i], data.xpos[1:], atol=1e-12)
        np.testing.assert_allclose(kinematics.rotation[i].reshape(-1, 9), data.xmat[1:], atol=1e-12)
        np.testing.assert_allclose(kinematics.joint_position[i], data.xanchor, atol=1e-12)
        np.testing.assert_allclose(kinematics.joint_axis[i], data.xaxis, atol=1e-12)


def test_no_configurations_and_no_frames(robot):
    assert robot.kinematics(np.empty((0, 14)), FRAMES).position.shape == (0, 4, 3)
    assert robot.kinematics(robot.home[None], []).rotation.shape == (1, 0, 3, 3)


def test_bad_input(robot):
    with pytest.raises(UnknownNameError, match=r"'left_hnd'.*'left_hand'"):
        robot.kinematics(robot.home[None], ["left_hnd"])
    with pytest.raises(UnknownNameError, match="left_tcp"):
        robot.frame_joints("nowhere")
    bad = np.tile(robot.home, (3, 1))
    bad[2, 4] = np.nan
    with pytest.raises(ConfigurationError, match=r"left_joint5.*sample 2"):
        robot.kinematics(bad, FRAMES)
    with pytest.raises(ConfigurationError, match="shape"):
        robot.kinematics(robot.home, FRAMES)
    with pytest.raises(UnknownNameError, match="panda_dual"):
        load_robot("pander")
