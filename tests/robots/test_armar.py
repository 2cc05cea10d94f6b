"""ARMAR-6 and ARMAR-7: published check values, the published chains joint by joint, mirror rules, continuous joints."""

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.robots import Robot, load_robot
from sbam.robots.description import JointDescription

TORSOS = {"armar6": ("TorsoJoint",), "armar7": ("Ankle", "Knee", "Hip")}
WRISTS = {"armar6": ("Wri1", "Wri2"), "armar7": ("Wrist_Hemisphere_A", "Wrist_Hemisphere_B")}
MIRROR = {"armar6": [-1, -1, 1, -1, 1, -1, -1, 1], "armar7": [-1, -1, 1, -1, 1, -1, 1, 1]}
TCPS = ("left_tcp", "right_tcp")


@pytest.fixture(scope="module", params=TORSOS)
def robot(request) -> Robot:
    """With its torso free, standing at the origin in the frame of the published numbers: x right, y forward, z up."""
    description = load_robot(request.param).description
    torso = TORSOS[request.param]
    free = JointDescription(velocity=1, acceleration=1, jerk=1, torque=1)
    description = msgspec.structs.replace(
        description,
        joints={**dict.fromkeys(torso, free), **description.joints},
        locked_joints={name: at for name, at in description.locked_joints.items() if name not in torso},
        torso_joints=torso,
    )
    return Robot(description, RigidTransform.from_rotation(Rotation.from_euler("z", 90, degrees=True)))


def configuration(robot: Robot, left=(0.0,) * 8, right=(0.0,) * 8, torso=None) -> np.ndarray:
    q = np.zeros((1, len(robot.joint_names)))
    q[0, robot.arms["left"].joint_indices] = left
    q[0, robot.arms["right"].joint_indices] = right
    q[0, robot.torso_indices] = torso or [0.0] * len(robot.torso_indices)
    return q


CHECK_VALUES = {
    "armar6": [
        ({}, [[-0.3798, 0.0850, 0.3396], [0.3798, 0.0850, 0.3396]]),
        (
            {"left": [0, 0, 1.42, 0, 1.25, 0, 0, 0], "right": [0, 0, 1.42, 0, 1.25, 0, 0, 0]},
            [[-0.9505, 0.6566, 1.2859], [0.9505, 0.6566, 1.2859]],
        ),
        (
            {"left": [0, -0.3, 0.3, 0, 1.6, 0, 0, 0], "right": [0, 0.3, 0.3, 0, 1.6, 0, 0, 0], "torso": [-0.15]},
            [[-0.4304, 0.7541, 1.0870], [0.4304, 0.7541, 1.0870]],
        ),
        (
            {
                "left": [0.2, -0.4, 0.5, 0.3, 1.1, -0.6, 0.25, -0.5],
                "right": [0.1, 0.35, 0.8, -0.2, 1.4, 0.7, -0.3, 0.6],
                "torso": [-0.1],
            },
            [[-0.6896, 0.6765, 0.7597], [0.5598, 0.7622, 1.2377]],
        ),
    ],
    "armar7": [
        ({}, [[-0.2245, 0.0454, 0.6591], [0.2245, 0.0454, 0.6591]]),
        (
            {"left": [0, 0, 0.25, 0.5, 1, 1, 0, 0], "right": [0, 0, 0.25, -0.5, 1, -1, 0, 0]},
            [[-0.1587, 0.3116, 0.8655], [0.1587, 0.3116, 0.8655]],
        ),
        (
            {
                "left": [0.2, -0.4, 0.25, 0.5, 1, 1, 0.2, -0.3],
                "right": [0, 0.3, 0.25, -0.5, 1, -1, 0, 0.25],
                "torso": [-0.3785, 0.8727, 0.5454],
            },
            [[-0.2698, 0.4325, 0.9267], [0.1371, 0.4169, 0.9044]],
        ),
    ],
}


def test_published_check_values(robot):
    for posture, expected in CHECK_VALUES[robot.name]:
        kinematics = robot.kinematics(configuration(robot, **posture), TCPS)
        np.testing.assert_allclose(kinematics.position[0], expected, atol=1e-4)


def published_chain(name: str, side: str) -> list[tuple[str, tuple, tuple, tuple | None]]:
    """(joint, origin xyz, origin rpy, axis or None where it is fixed) from root to TCP, root x right and y forward."""
    half, quarter = np.pi / 2, np.pi / 4
    s, letter = (1.0, "L") if side == "left" else (-1.0, "R")
    hand_to_tcp = (-s * half, 0, -s * half)
    if name == "armar6":
        return [
            ("TorsoJoint", (0, 0, 1.195), (0, 0, 0), (0, 0, 1)),
            ("", (0, 0, 0.1), (0, 0, 0), None),
            (f"Arm{letter}1_Cla1", (-s * 0.09, 0, 0), (0, 0, s * half), (0, 0, 1)),
            (f"Arm{letter}2_Sho1", (0, 0.289778, 0.077646), (0, 0, 0), (0, 0.965926, 0.258819)),
            (f"Arm{letter}3_Sho2", (0, 0, 0), (-half, 0, 0), (1, 0, 0)),
            (f"Arm{letter}4_Sho3", (0, 0, 0), (0, s * half, s * half), (0, 0, 1)),
            (f"Arm{letter}5_Elb1", (0, -0.055, 0.409), (0, 0, 0), (1, 0, 0)),
            (f"Arm{letter}6_Elb2", (0, 0, 0), (0, 0, 0), (0, 0, 1)),
            (f"Arm{letter}7_Wri1", (0, 0, 0.364), (0, 0, 0), (0, -1, 0)),
            (f"Arm{letter}8_Wri2", (0, 0, 0), (0, 0, half), (0, -1, 0)),
            ("", (0, 0, 0.14), (0, -half, -half), None),
            ("", (0.12, -0.03, 0), hand_to_tcp, None),
        ]
    return [
        ("", (0, 0, 0.31), (0, -half, np.pi), None),
        ("", (0.05, 0, 0), (0, 0, 0.785398), None),
        ("Ankle", (0, 0, 0), (0, 0, -0.757037), (0, 0, 1)),
        ("Knee", (0.28, 0, 0), (0, 0, 0.227697), (0, 0, 1)),
        ("", (0, 0, 0), (0, 0, -0.15708), None),
        ("Hip", (0.2829, 0, 0), (0, 0, 0), (0, 0, -1)),
        ("", (0.51314, 0, 0), (0, -half, -np.pi), None),
        (f"Arm{letter}1_Cla1", (-s * 0.0585, 0, 0), (0, 0, -half), (0, 0, 1)),
        (f"Arm{letter}2_Sho1", (0, 0, 0), (s * half, 0, 0), (0, 0, 1)),
        (f"Arm{letter}3_Sho2", (0, 0, 0.156), (half, 0, -s * half), (0, 0, 1)),
        (f"Arm{letter}4_Sho3", (0, 0, 0), (half, 0, half), (0, 0, 1)),
        (f"Arm{letter}5_Elb1", (0, s * 0.025, 0.3516), (half, 0, -s * half), (0, 0, 1)),
        (
            f"Arm{letter}6_Elb2",
            (0, 0, -s * 0.01),
            (-half, 0, 0) if side == "left" else (0, -half, 3 * half),
            (0, 0, 1),
        ),
        ("", (0, 0, 0), (0, 0, -s * quarter), None),
        (f"Arm{letter}7_Wrist_Hemisphere_A", (0, 0, 0.295249), (0, 0, 0), (1, 0, 0)),
        (f"Arm{letter}8_Wrist_Hemisphere_B", (0, 0, 0), (0, 0, 0), (0, -1, 0)),
        ("", (0, 0, 0.0453392), (0, -half, 7 * quarter), None),
        ("", (0.09, -0.03, 0), hand_to_tcp, None),
    ]


@pytest.mark.parametrize("side", ["left", "right"])
def test_own_frames_make_the_published_chain(robot, side):
    """Position and orientation of the TCP; the published axes and angles are rounded to 1e-6."""
    low, high = np.maximum(robot.lower, -7.0), np.minimum(robot.upper, 7.0)
    q = np.random.default_rng(5).uniform(low, high, (200, len(robot.joint_names)))
    pose = RigidTransform.from_translation(np.zeros((len(q), 3)))
    for joint, xyz, rpy, axis in published_chain(robot.name, side):
        pose = pose * RigidTransform.from_components(xyz, Rotation.from_euler("xyz", rpy))
        if axis is None:
            continue
        value = q[:, robot.joint_names.index(joint), None]
        direction = np.array(axis) / np.linalg.norm(axis)
        if joint == "TorsoJoint":
            pose = pose * RigidTransform.from_translation(value * direction)
        else:
            pose = pose * RigidTransform.from_rotation(Rotation.from_rotvec(value * direction))
    kinematics = robot.kinematics(q, [f"{side}_tcp"])
    np.testing.assert_allclose(kinematics.position[:, 0], pose.translation, atol=2e-6)
    np.testing.assert_allclose(kinematics.rotation[:, 0], pose.rotation.as_matrix(), atol=1e-5)


def test_mirrored_postures_put_the_hands_at_mirrored_places(robot):
    """The rules that the joints' senses follow; ARMAR-7's crossed wrist joints only at wrist 0."""
    low, high = np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0)
    q = np.random.default_rng(6).uniform(low, high, (100, len(robot.joint_names)))
    left, right = (robot.arms[side].joint_indices for side in ("left", "right"))
    if robot.name == "armar7":
        q[:, left[6:]] = 0.0
    q[:, right] = q[:, left] * MIRROR[robot.name]
    kinematics = robot.kinematics(q, TCPS)
    across = np.diag([-1.0, 1.0, 1.0])  # x is right here
    np.testing.assert_allclose(kinematics.position[:, 1], kinematics.position[:, 0] @ across, atol=1e-9)
    # z (fingers) and y (palm normal) are mirrored, x is not: it points towards one thumb and away from the other
    mirrored = across @ kinematics.rotation[:, 0] @ np.diag([-1.0, 1.0, 1.0])
    np.testing.assert_allclose(kinematics.rotation[:, 1], mirrored, atol=1e-9)


def test_continuous_joints_turn_endlessly(robot):
    names = np.array(robot.joint_names)
    expected = {f"Arm{side}{joint}" for side in "LR" for joint in ("2_Sho1", "4_Sho3", "6_Elb2")}
    assert set(names[robot.is_continuous]) == expected
    assert np.isinf(robot.upper[robot.is_continuous]).all()
    turns = configuration(robot, [0.3] * 8, [0.3] * 8)
    further = turns + 4 * np.pi * robot.is_continuous
    np.testing.assert_allclose(
        robot.kinematics(further, TCPS).position, robot.kinematics(turns, TCPS).position, atol=1e-12
    )


def test_full_turns_are_taken_back_near_a_reference(robot):
    generator = np.random.default_rng(8)
    near = generator.uniform(-1, 1, (50, len(robot.joint_names)))
    reference = near + generator.uniform(-3, 3, near.shape)
    turns = 2 * np.pi * generator.integers(-3, 4, near.shape) * robot.is_continuous
    np.testing.assert_allclose(robot.turned_near(near + turns, reference), near, atol=1e-12)


def test_torso_moves_both_arms(robot):
    names = np.array(robot.joint_names)
    assert tuple(names[robot.torso_indices]) == TORSOS[robot.name]
    np.testing.assert_array_equal(names[robot.is_prismatic], ["TorsoJoint"] if robot.name == "armar6" else [])
    for side in ("left", "right"):
        assert robot.frame_joints(f"{side}_tcp")[robot.torso_indices].all()


@pytest.mark.parametrize(
    ("name", "from_shoulder", "from_clavicle"), [("armar6", 1.038, 1.337), ("armar7", 0.786, 0.941)]
)
def test_reach(name, from_shoulder, from_clavicle):
    robot = load_robot(name)
    assert robot.arms["left"].length == from_shoulder
    low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    q = np.random.default_rng(7).uniform(low, high, (20000, 16))
    tcp, shoulder, clavicle = robot.kinematics(q, ["left_tcp", "left_shoulder_2", "left_clavicle"]).position.swapaxes(
        0, 1
    )
    for origin, length in ((shoulder, from_shoulder), (clavicle, from_clavicle)):
        reach = np.linalg.norm(tcp - origin, axis=1).max()
        assert 0.97 * length < reach < length + 2e-3


@pytest.mark.parametrize("name", TORSOS)
def test_stands_before_the_table_with_its_hands_above_it(name):
    """Agent frame: x right, y forward, origin on the table top; its front edge is 0.22 m ahead."""
    robot = load_robot(name)
    kinematics = robot.kinematics(robot.home[None], [*TCPS, "platform"])
    left, right, platform = kinematics.position[0]
    assert left[0] < -0.1 and right[0] > 0.1
    assert 0.25 < left[1] < 0.6 and 0.1 < left[2] < 0.4
    np.testing.assert_allclose(right, left * [-1, 1, 1], atol=0.012)  # crossed wrist joints mirror nearly
    assert platform[1] < 0 and platform[2] < -0.9
    # palms face each other, fingers point ahead
    assert kinematics.rotation[0, 0, 0, 1] > 0.8 and kinematics.rotation[0, 1, 0, 1] < -0.8
    assert (kinematics.rotation[0, :2, 1, 2] > 0.5).all()


@pytest.mark.parametrize("name", TORSOS)
def test_says_that_it_is_unofficial(name):
    description = load_robot(name).description
    assert "unofficial" in description.note
    model = (description.path.removesuffix(".yaml")) + ".xml"
    with open(model) as file:
        head = file.read(200)
    assert "Unofficial" in head
