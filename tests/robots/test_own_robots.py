"""A user's own robot from a bare model file: reading, guessing, checking, and what bad files are told."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from sbam.errors import FileFormatError, UnknownNameError
from sbam.robots import load_robot
from sbam.robots.check import check_robot
from sbam.robots.guess import guess_arms
from sbam.robots.model_files import find_model, read_model
from sbam.robots.new_description import new_description

INERTIA = '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
LENGTHS = (0.0, 0.05, 0.3, 0.0, 0.28, 0.0)
AXES = ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0")


def arm_links(s: str, parent: str, xyz: str, shapes: str) -> str:
    """Six joints up from a parent, a hand with two fingers and a tool frame."""
    text, last = "", parent
    for i, (length, axis) in enumerate(zip(LENGTHS, AXES, strict=True), 1):
        origin = xyz if i == 1 else f"0 0 {length}"
        text += f"""<link name="{s}arm_link{i}">{INERTIA}{shapes}</link>
<joint name="{s}arm_joint{i}" type="revolute"><parent link="{last}"/><child link="{s}arm_link{i}"/>
  <origin xyz="{origin}"/><axis xyz="{axis}"/>
  <limit lower="-2.5" upper="2.6" velocity="{1 + i / 10}" effort="{10 * i}"/></joint>
"""
        last = f"{s}arm_link{i}"
    text += f"""<link name="{s}palm">{INERTIA}</link><link name="{s}tool"/>
<joint name="{s}flange" type="fixed"><parent link="{last}"/><child link="{s}palm"/><origin xyz="0 0 0.08"/></joint>
<joint name="{s}tip" type="fixed"><parent link="{s}palm"/><child link="{s}tool"/><origin xyz="0 0 0.1"/></joint>
"""
    for finger, side, mimic in (("a", 1, ""), ("b", -1, f'<mimic joint="{s}finger_a" multiplier="1"/>')):
        text += f"""<link name="{s}finger_link_{finger}">{INERTIA}
  <collision><origin xyz="0 {side * 0.01} 0.03"/><geometry><box size="0.02 0.02 0.06"/></geometry></collision></link>
<joint name="{s}finger_{finger}" type="prismatic"><parent link="{s}palm"/><child link="{s}finger_link_{finger}"/>
  <origin xyz="0 0 0.06"/><axis xyz="0 {side} 0"/>{mimic}
  <limit lower="0" upper="0.045" velocity="1" effort="1"/></joint>
"""
    return text


MESH = '<collision><geometry><mesh filename="package://none/link.stl"/></geometry></collision>'
SINGLE = f'<robot name="one"><link name="base"/>{arm_links("", "base", "0 0 0.3", MESH)}</robot>'
DOUBLE = f"""<robot name="two"><link name="base"/>
<link name="torso">{INERTIA}<collision><geometry><box size="0.2 0.1 0.4"/></geometry></collision></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="torso"/><origin xyz="0 0 0.9"/>
  <axis xyz="0 0 1"/><limit lower="0" upper="0.3" velocity="0.1" effort="500"/></joint>
{arm_links("left_", "torso", "0 0.25 0.3", MESH)}{arm_links("right_", "torso", "0 -0.25 0.3", MESH)}
</robot>"""


@pytest.fixture
def urdf(tmp_path):
    def write(text: str, name: str = "robot.urdf") -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def described(urdf: Path) -> Path:
    new_description(str(urdf), urdf.with_suffix(".yaml"))
    return urdf.with_suffix(".yaml")


def test_two_arms_are_found_by_name(urdf):
    guess = guess_arms(urdf(DOUBLE))
    assert not guess.is_single and guess.above == ("lift",)
    for side, arm in guess.arms.items():
        assert arm.joints == tuple(f"{side}_arm_joint{i}" for i in range(1, 7))
        assert (arm.tcp, arm.hand) == (f"{side}_tool", f"{side}_palm")
        assert (arm.shoulder, arm.elbow) == (f"{side}_arm_link2", f"{side}_arm_link3")
        assert arm.approach == (0, 0, 1) and arm.opening == (0, 1, 0)
        assert arm.max_width == pytest.approx(0.09)
        assert arm.fingers == {f"{side}_finger_a": 0.045, f"{side}_finger_b": 0.045}


def test_description_of_two_arms_loads_and_is_sound(urdf):
    path = described(urdf(DOUBLE))
    robot = load_robot(path)
    assert len(robot.joint_names) == 12 and "lift" not in robot.joint_names
    np.testing.assert_allclose(robot.velocity_limit[:6], 1 + np.arange(1, 7) / 10)
    np.testing.assert_allclose(robot.torque_limit[:6], 10.0 * np.arange(1, 7))
    np.testing.assert_allclose(robot.lower, -2.5)
    report = check_robot(robot)
    assert report["problems"] == []
    assert any("meshes are not found" in warning for warning in report["warnings"])
    assert any("mimic" in warning and "left_finger_b" in warning for warning in report["warnings"])
    for side, sign in (("left", -1), ("right", 1)):
        arm = report["arms"][side]
        assert sign * arm["tcp_at_home"][0] > 0.05 and arm["tcp_at_home"][1] > 0 and arm["tcp_at_home"][2] > 0
        assert arm["approach_at_home"][2] < -0.3
        assert arm["length"] == pytest.approx(arm["sampled_reach"], rel=0.03)
        # the shoulders stand 0.4 m above the table top
        assert arm["shoulder_at_home"][2] == pytest.approx(0.4, abs=0.02)
    assert math.isfinite(report["joints"][0]["lower"])


def test_a_single_arm_is_mounted_twice(urdf):
    robot = load_robot(described(urdf(SINGLE)))
    assert [part.prefix for part in robot.description.parts] == ["left_", "right_"]
    assert len(robot.joint_names) == 12
    bases = robot.kinematics(robot.home[None], ["left_arm_link1", "right_arm_link1"]).position[0]
    assert bases[1, 0] - bases[0, 0] > 0.4 and abs(bases[0, 1] - bases[1, 1]) < 1e-9
    assert check_robot(robot)["problems"] == []


def test_a_robot_that_looks_along_another_axis_is_turned(urdf):
    turned = DOUBLE.replace('xyz="0 0.25 0.3"', 'xyz="-0.25 0 0.3"').replace('xyz="0 -0.25 0.3"', 'xyz="0.25 0 0.3"')
    robot = load_robot(described(urdf(turned)))
    left, right = robot.kinematics(robot.home[None], ["left_arm_link1", "right_arm_link1"]).position[0]
    np.testing.assert_allclose(right - left, [0.5, 0, 0], atol=1e-9)  # agent frame: x right


def test_every_field_of_the_description_is_explained(urdf):
    text = described(urdf(DOUBLE)).read_text()
    fields = yaml.safe_load(text)
    lines = text.splitlines()
    for field in set(fields) - {"format_version", "name", "note", "torso_joints", "locked_joints"}:
        row = next(i for i, line in enumerate(lines) if line.startswith(f"{field}:"))
        assert any(line.lstrip().startswith("#") for line in lines[row - 2 : row + 3]), field


def test_links_without_primitives_get_capsules_between_their_joints(urdf):
    read = read_model(urdf(DOUBLE))
    assert set(read.missing_meshes) == {"package://none/link.stl"}
    assert {f"{side}_arm_link2" for side in ("left", "right")} <= set(read.stand_ins)
    model = read.spec.compile()
    link = model.body("left_arm_link2")
    (shape,) = range(int(link.geomadr[0]), int(link.geomadr[0] + link.geomnum[0]))
    assert model.geom_type[shape] == mujoco.mjtGeom.mjGEOM_CAPSULE
    np.testing.assert_allclose(model.geom_pos[shape], [0, 0, 0.15], atol=1e-9)  # in the middle of 0.3 m
    assert model.geom_size[shape, 1] + model.geom_size[shape, 0] <= 0.15 + 1e-9
    # tool frames and finger links keep what they have
    assert not any("tool" in name or "finger" in name for name in read.stand_ins)


TRIANGLE = b"\0" * 80 + (4).to_bytes(4, "little")


def tetrahedron() -> bytes:
    corners = 0.1 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
    faces = ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])
    return TRIANGLE + b"".join(np.zeros(3, "<f4").tobytes() + corners[face].tobytes() + b"\0\0" for face in faces)


def test_meshes_are_drawn_where_they_are_found(urdf, tmp_path):
    drawn = MESH.replace("collision", "visual").replace("link.stl", "other.stl")
    path = urdf(SINGLE.replace(MESH, drawn))
    folder = tmp_path / "none"
    folder.mkdir()
    (folder / "other.stl").write_bytes(tetrahedron())
    described(path)
    robot = load_robot(path.with_suffix(".yaml"))
    assert robot.model.nmesh == 0
    with_meshes = robot.spec(meshes=True).compile()
    meshes = with_meshes.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    assert meshes.sum() == 12
    assert not (with_meshes.geom_contype | with_meshes.geom_conaffinity)[meshes].any()
    assert read_model(path).missing_meshes == ()


def test_mjcf_with_missing_meshes_floor_and_free_joint(tmp_path):
    def arm(side: str, y: float) -> str:
        text, end = "", ""
        for i, axis in enumerate(("0 0 1", "0 1 0", "0 0 1", "0 1 0", "1 0 0"), 1):
            pos = f"0 {y} 0.5" if i == 1 else "0.2 0 0"
            text += f'<body name="{side}_l{i}" pos="{pos}"><joint name="{side}_j{i}" axis="{axis}" range="-2 2"/>'
            text += '<geom type="mesh" mesh="gone" mass="1"/><geom type="sphere" size="0.02" mass="1"/>'
            end += "</body>"
        return text + f'<site name="{side}_tcp" pos="0.1 0 0"/>' + end

    path = tmp_path / "robot.xml"
    path.write_text(f"""<mujoco><compiler angle="radian" autolimits="true" meshdir="assets"/>
<asset><mesh name="gone" file="gone.stl"/></asset><worldbody><geom type="plane" size="1 1 1"/>
<body name="pelvis"><freejoint/><geom type="box" size="0.1 0.1 0.3" mass="5"/>
{arm("left", 0.2)}{arm("right", -0.2)}</body>
</worldbody></mujoco>""")
    robot = load_robot(described(path))
    assert robot.arms["left"].tcp_frame == "left_tcp"
    assert len(robot.joint_names) == 10 and robot.model.nmesh == 0
    assert not (robot.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE).any()
    assert any("meshes" in warning for warning in check_robot(robot)["warnings"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'xyz="0 0.25 0.3"',
            'xyz="0 0.25 x"',
            r"joint 'left_arm_joint1', <origin xyz='0 0.25 x'>: not a number.*3 numb",
        ),
        ('xyz="0 0.25 0.3"', 'xyz="0 0.25"', r"joint 'left_arm_joint1'.*2 numbers.*expected 3 numbers"),
        ('xyz="0 0.25 0.3"', 'xyz="0 nan 0.3"', r"joint 'left_arm_joint1'.*not finite"),
        ('<mass value="1"/>', '<mass value="heavy"/>', r"link 'torso', <mass value='heavy'>"),
        ('<child link="left_palm"/>', '<child link="left_plam"/>', "robot.urdf.*MuJoCo cannot read"),
    ],
)
def test_broken_numbers_name_joint_and_attribute(urdf, old, new, message):
    with pytest.raises(FileFormatError, match=message):
        guess_arms(urdf(DOUBLE.replace(old, new)))


def test_links_without_inertia_are_named(urdf):
    weightless = DOUBLE.replace('ixx="0.01"', 'ixx="0"', 1)
    report = check_robot(load_robot(described(urdf(weightless))))
    assert any("torso" in w and "no inertia" in w for w in report["warnings"])


@pytest.mark.parametrize(
    "limits",
    ['lower="0" upper="0"', 'lower="-inf" upper="inf"', "", 'lower="2" upper="-2"'],
    ids=["zero", "infinite", "none", "reversed"],
)
def test_joints_without_a_range(urdf, limits):
    good = urdf(DOUBLE)
    path = described(good)
    broken = DOUBLE.replace('lower="-2.5" upper="2.6" velocity="1.2"', f'{limits} velocity="1.2"')
    urdf(broken)
    with pytest.raises(FileFormatError, match=r"\$.joints.left_arm_joint2: is revolute with limits.*lower and upper"):
        load_robot(path)
    robot = load_robot(described(urdf(broken)))  # a new description gives them
    second = robot.joint_names.index("left_arm_joint2")
    assert robot.lower[second] == pytest.approx(-3.14159) and robot.upper[second] == pytest.approx(3.14159)


def test_limits_of_the_description_replace_those_of_the_model(urdf):
    path = described(urdf(DOUBLE))
    content = yaml.safe_load(path.read_text())
    content["joints"]["left_arm_joint1"] |= {"lower": -1.0, "upper": 0.5, "home": 0.0}
    path.write_text(yaml.safe_dump(content))
    robot = load_robot(path)
    assert (robot.lower[0], robot.upper[0]) == (-1.0, 0.5)
    for wrong, message in (
        ({"lower": 1.0, "upper": 0.5}, "not below"),
        ({"lower": 1.0}, "has only one|not below|both"),
    ):
        content["joints"]["left_arm_joint1"] = {"velocity": 1, "acceleration": 1, "jerk": 1, "torque": 1, **wrong}
        path.write_text(yaml.safe_dump(content))
        with pytest.raises(FileFormatError, match=message):
            load_robot(path)


def test_planned_joints_must_not_mimic(urdf):
    path = described(urdf(DOUBLE))
    axis = '<axis xyz="0 1 0"/>\n  <limit lower="-2.5" upper="2.6" velocity="1.2"'
    assert axis in DOUBLE
    urdf(DOUBLE.replace(axis, '<mimic joint="left_arm_joint1"/>' + axis, 1))
    with pytest.raises(FileFormatError, match=r"left_arm_joint2: mimics 'left_arm_joint1'.*locked_joints"):
        load_robot(path)


@pytest.mark.parametrize(
    ("equality", "message"),
    [
        ('<joint joint1="left_shoulder" joint2="left_elbow"/>', "couples joint 'left_shoulder' with 'left_elbow'"),
        ('<weld body1="left_hand" body2="right_hand"/>', "closes a chain"),
        ('<connect body1="left_hand" body2="platform" anchor="0 0 0"/>', "closes a chain.*'platform'"),
    ],
)
def test_closed_chains_are_refused(write_torso_robot, equality, message):
    path = write_torso_robot({"<actuator>": f"<equality>{equality}</equality><actuator>"}, in_model=True)
    with pytest.raises(FileFormatError, match=message):
        load_robot(path)


def test_couplings_of_fingers_are_no_matter(write_torso_robot):
    coupling = '<equality><joint joint1="left_finger" joint2="right_finger"/></equality>'
    coupled = load_robot(write_torso_robot({"<actuator>": coupling + "<actuator>"}, in_model=True))
    assert coupled.joint_names == load_robot(write_torso_robot({}, in_model=True)).joint_names


def test_missing_frames_and_second_arms(urdf):
    path = described(urdf(DOUBLE))
    text = path.read_text()
    path.write_text(text.replace('tcp: "left_tool"', 'tcp: "left_tol"'))
    with pytest.raises(UnknownNameError, match=r"'left_tol'.*arms.left.tcp.*'left_tool'"):
        load_robot(path)
    content = yaml.safe_load(text)
    del content["arms"]["right"]
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(FileFormatError, match=r"no right arm.*mount it twice"):
        load_robot(path)
    content = yaml.safe_load(text)
    content["may_touch"] = [["left_palm", "nose"]]
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(UnknownNameError, match=r"'nose'.*may_touch\[0\].*'left_palm'"):
        load_robot(path)


def test_a_model_file_alone_is_no_robot(urdf):
    with pytest.raises(FileFormatError, match=r"sbam robots new .*robot\.urdf -o robot\.yaml"):
        load_robot(urdf(DOUBLE))


def test_models_that_hold_no_arm(urdf):
    with pytest.raises(FileFormatError, match=r"no chain of 4 joints.*joints: none"):
        guess_arms(urdf('<robot name="r"><link name="a"/></robot>'))


def test_descriptions_are_yaml_and_models_exist(urdf, tmp_path):
    with pytest.raises(FileFormatError, match=r"ends in \.yaml"):
        new_description(str(urdf(DOUBLE)), tmp_path / "robot.txt")
    with pytest.raises(FileFormatError, match=r"none\.urdf"):
        new_description(str(tmp_path / "none.urdf"), tmp_path / "robot.yaml")
    (tmp_path / "arm.dae").write_text("")
    with pytest.raises(FileFormatError, match=r"MJCF \(\.xml\) or URDF"):
        find_model("arm.dae", tmp_path / "robot.yaml")


@pytest.fixture
def robot_descriptions(tmp_path, monkeypatch):
    """A package of that name: one model that is there, one whose download fails, one that is xacro."""
    folder = tmp_path / "site" / "robot_descriptions"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    (folder / "two_description.py").write_text(f"URDF_PATH = {str(tmp_path / 'robot.urdf')!r}\n")
    (folder / "far_description.py").write_text("raise OSError('could not resolve host')\n")
    (folder / "macro_description.py").write_text("XACRO_PATH = 'robot.xacro'\n")
    monkeypatch.syspath_prepend(folder.parent)


@pytest.mark.usefixtures("robot_descriptions")
def test_models_of_robot_descriptions(urdf, tmp_path):
    urdf(DOUBLE)
    new_description("two_description", tmp_path / "two.yaml")
    robot = load_robot(tmp_path / "two.yaml")
    assert robot.description.parts[0].model == "two_description" and len(robot.joint_names) == 12
    for name, error, message in (
        ("tow_description", UnknownNameError, "'tow_description'.*nearest names; known: .*'two_description'"),
        ("far_description", FileFormatError, "cannot download 'far_description': OSError: could not resolve host"),
        ("macro_description", FileFormatError, "is xacro.*expanded"),
    ):
        with pytest.raises(error, match=message):
            new_description(name, tmp_path / "new.yaml")


def test_without_robot_descriptions_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(FileFormatError, match="pip install robot_descriptions"):
        new_description("baxter_description", tmp_path / "baxter.yaml")


def test_what_overlaps_at_home_is_said(urdf):
    path = described(urdf(DOUBLE))
    urdf(DOUBLE.replace('size="0.2 0.1 0.4"', 'size="1.6 1.6 1.6"'))
    problems = check_robot(load_robot(path))["problems"]
    assert any("'torso' overlap at home" in problem for problem in problems)


def test_shapes_are_left_out_on_request(urdf):
    path = described(urdf(DOUBLE))
    urdf(DOUBLE.replace('size="0.2 0.1 0.4"', 'size="1.6 1.6 1.6"'))
    content = yaml.safe_load(path.read_text())
    content["without_collision"] = ["torso"]
    path.write_text(yaml.safe_dump(content))
    assert check_robot(load_robot(path))["problems"] == []
    content["without_collision"] = ["bust"]
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(UnknownNameError, match=r"'bust'.*without_collision\[0\].*'torso'"):
        load_robot(path)


def test_hands_on_the_wrong_sides_and_out_of_reach_are_said(urdf):
    path = described(urdf(DOUBLE))
    content = yaml.safe_load(path.read_text())
    content["base_in_agent"]["rotation_rpy_deg"] = [0, 0, -90]
    content["base_in_agent"]["position"] = [0, -3, 0]
    path.write_text(yaml.safe_dump(content))
    problems = " ".join(check_robot(load_robot(path))["problems"])
    assert "left hand is at the right" in problems and "none of 5000 postures has its TCP over the table" in problems
