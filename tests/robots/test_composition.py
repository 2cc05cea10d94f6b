"""Composed models: locked joints, shared torso joints, names without prefix, URDF parts."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError
from sbam.robots import load_robot

FRAMES = ("left_finger", "right_finger", "left_tcp", "right_tcp", "torso")


def test_locked_joints_stand_where_mujoco_puts_them(torso_robot):
    """Against the user's model as it is, with the finger at its locked value (its joint's zero lies at 10 degrees)."""
    assert "left_finger" not in torso_robot.joint_names
    model = mujoco.MjModel.from_xml_path(str(Path(torso_robot.description.path).with_name("torso.xml")))
    data = mujoco.MjData(model)
    q = np.random.default_rng(0).uniform(-0.3, 0.2, (30, len(torso_robot.joint_names)))
    stood = torso_robot.placed(RigidTransform.identity())
    kinematics = stood.kinematics(q, FRAMES)
    for sample, configuration in enumerate(q):
        for name, value in zip(torso_robot.joint_names, configuration, strict=True):
            data.joint(name).qpos[:] = value
        data.joint("left_finger").qpos[:] = 0.5
        data.joint("right_finger").qpos[:] = 0.0
        mujoco.mj_kinematics(model, data)
        for index, frame in enumerate(FRAMES):
            view = data.site(frame) if frame.endswith("tcp") else data.body(frame)
            position, rotation = view.xpos, view.xmat.reshape(3, 3)
            np.testing.assert_allclose(kinematics.position[sample, index], position, atol=1e-12)
            np.testing.assert_allclose(kinematics.rotation[sample, index], rotation, atol=1e-12)


def test_torso_joints_move_both_arms(torso_robot):
    names = np.array(torso_robot.joint_names)
    np.testing.assert_array_equal(names[torso_robot.torso_indices], ["lift", "yaw"])
    for side in ("left", "right"):
        moving = names[torso_robot.frame_joints(f"{side}_tcp")]
        assert list(moving) == ["lift", "yaw", f"{side}_shoulder", f"{side}_elbow", f"{side}_wrist"]
    np.testing.assert_array_equal(names[torso_robot.is_prismatic], ["lift"])
    np.testing.assert_array_equal(names[torso_robot.is_continuous], ["yaw", "left_elbow", "right_elbow"])
    assert np.isinf(torso_robot.upper[torso_robot.is_continuous]).all()


def test_unlocked_spec_keeps_the_fingers():
    robot = load_robot("panda_dual")
    model = robot.spec(lock=False).compile()
    assert model.njnt == len(robot.joint_names) + 4
    assert {model.joint(i).name for i in range(model.njnt)} > set(robot.joint_names)


def test_what_is_free_moves_beside_the_planned_joints_and_nothing_else():
    robot = load_robot("armar6")
    model = robot.spec(free=["Neck_1_Yaw"]).compile()
    assert {model.joint(i).name for i in range(model.njnt)} == {*robot.joint_names, "Neck_1_Yaw"}


def test_locking_one_of_several_joints_of_a_body_is_refused(write_torso_robot):
    joints = '<joint name="left_finger" axis="1 0 0" pos="0.01 0 0" range="0 60" ref="10"/>'
    path = write_torso_robot({joints: joints + '<joint name="left_twist" axis="0 0 1" range="0 60"/>'}, in_model=True)
    with pytest.raises(FileFormatError, match=r"left_finger.*shares body"):
        load_robot(path)


URDF = """<robot name="arm">
<link name="basement"><visual><geometry><mesh filename="package://none/none.dae"/></geometry></visual></link>
<link name="lift"><collision><geometry><mesh filename="none.stl"/></geometry></collision></link>
<link name="upper"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.2"/></geometry></collision></link>
<link name="fore"/><link name="hand"/><link name="tool"/>
<joint name="lift" type="prismatic"><parent link="basement"/><child link="lift"/>
  <origin xyz="0 0 0.5" rpy="0.1 0.2 0.3"/>
  <axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="shoulder" type="continuous"><parent link="lift"/><child link="upper"/><origin xyz="0.1 0 0" rpy="1 0 0"/>
  <axis xyz="0 0.6 0.8"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0 0 0.3" rpy="0 -0.4 0"/>
  <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="wrist" type="fixed"><parent link="fore"/><child link="hand"/>
  <origin xyz="0 0.02 0.3" rpy="0 0 0.7"/></joint>
<joint name="tool" type="fixed"><parent link="hand"/><child link="tool"/><origin xyz="0 0 0.1" rpy="0 1 0"/></joint>
</robot>"""
JOINT = "{velocity: 1, acceleration: 1, jerk: 1, torque: 1}"


@pytest.fixture
def urdf_robot(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    sides = "".join(
        f"""
  {s}: {{joints: [{s}_lift, {s}_shoulder, {s}_elbow], tcp: {s}_tool,
    shoulder: {s}_upper, elbow: {s}_fore, wrist: {s}_hand, length: 0.7, hand: {{
      body: {s}_hand, approach: [0, 0, 1], opening: [0, 1, 0], max_width: 0.1}}}}"""
        for s in ("left", "right")
    )
    joints = ", ".join(f"{s}_{j}: {JOINT}" for s in ("left", "right") for j in ("lift", "shoulder", "elbow"))
    (tmp_path / "robot.yaml").write_text(f"""format_version: 1
name: urdf_robot
parts:
  - {{model: arm.urdf, prefix: left_, position: [0, 0.3, 0]}}
  - {{model: arm.urdf, prefix: right_, position: [0, -0.3, 0], rotation_rpy_deg: [0, 0, 90]}}
base_in_agent: {{}}
joints: {{{joints}}}
arms:{sides}
""")
    return load_robot(tmp_path / "robot.yaml")


def test_urdf_against_a_chain_by_hand(urdf_robot):
    """Fixed links survive, meshes are not missed, prismatic and continuous joints count."""

    def pose(xyz, rpy):
        return RigidTransform.from_components(xyz, Rotation.from_euler("xyz", rpy))

    q = np.array([0.15, 2.5, -1.1])
    chain = (
        pose([0, -0.3, 0], [0, 0, np.pi / 2])
        * pose([0, 0, 0.5], [0.1, 0.2, 0.3])
        * RigidTransform.from_translation([0, 0, q[0]])
        * pose([0.1, 0, 0], [1, 0, 0])
        * RigidTransform.from_rotation(Rotation.from_rotvec(q[1] * np.array([0, 0.6, 0.8])))
        * pose([0, 0, 0.3], [0, -0.4, 0])
        * RigidTransform.from_rotation(Rotation.from_rotvec([q[2], 0, 0]))
        * pose([0, 0.02, 0.3], [0, 0, 0.7])
        * pose([0, 0, 0.1], [0, 1, 0])
    )
    configuration = np.zeros((1, 6))
    configuration[0, urdf_robot.arms["right"].joint_indices] = q
    kinematics = urdf_robot.kinematics(configuration, ["right_tool"])
    np.testing.assert_allclose(kinematics.position[0, 0], chain.translation, atol=1e-9)
    np.testing.assert_allclose(kinematics.rotation[0, 0], chain.rotation.as_matrix(), atol=1e-9)
    np.testing.assert_array_equal(urdf_robot.is_prismatic, [True, False, False] * 2)
    np.testing.assert_array_equal(urdf_robot.is_continuous, [False, True, False] * 2)


def test_solver_settings_of_a_model_are_dropped_in_silence(write_torso_robot):
    """Warnings are errors here."""
    option = '<option cone="elliptic" impratio="10" timestep="0.5"><flag gravity="disable"/></option><worldbody>'
    robot = load_robot(write_torso_robot({"<worldbody>": option}, in_model=True))
    assert (robot.model.opt.cone, robot.model.opt.impratio, robot.model.opt.disableflags) == (0, 1.0, 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (URDF.replace("</robot>", ""), "not XML"),
        ("<mujoco/>", "not <robot>"),
        ('<!DOCTYPE r [<!ENTITY e "x">]>' + URDF, "cannot be read"),
        (URDF.replace('<child link="tool"/>', '<child link="spoon"/>'), "arm.urdf.*MuJoCo cannot read"),
    ],
)
def test_broken_urdf(urdf_robot, text, message):
    path = Path(urdf_robot.description.path)
    path.with_name("arm.urdf").write_text(text)
    with pytest.raises(FileFormatError, match=message):
        load_robot(path)
