"""A small robot with a lift, a continuous torso joint, continuous arm joints and fingers, written as a user would."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from sbam.robots import Robot, load_robot

ARM = """
<body name="{s}_upper" pos="{x} 0 0.3" euler="0 20 0">
  <joint name="{s}_shoulder" axis="1 0 0" range="-170 170"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.05"/>
  <body name="{s}_fore" pos="0 0 -0.3">
    <joint name="{s}_elbow" axis="0.6 0 0.8" pos="0.01 0 0.02" limited="false"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.04"/>
    <body name="{s}_hand" pos="0 0 -0.3">
      <joint name="{s}_wrist" axis="0 1 0" range="-90 90"/>
      <geom type="box" size="0.02 0.05 0.03"/>
      <site name="{s}_tcp" pos="0 0.01 -0.1" euler="180 0 30"/>
      <body name="{s}_finger" pos="0 0.05 -0.05" euler="0 0 90">
        <joint name="{s}_finger" axis="1 0 0" pos="0.01 0 0" range="0 60" ref="10"/>
        <geom type="box" size="0.01 0.01 0.03"/>
      </body>
    </body>
  </body>
</body>"""
MODEL = f"""<mujoco model="torso"><compiler angle="degree" autolimits="true"/><worldbody>
<body name="platform"><geom type="box" size="0.3 0.3 0.1"/>
<body name="torso" pos="0 0 0.8"><joint name="lift" type="slide" axis="0 0 1" range="-0.3 0.2"/>
<joint name="yaw" axis="0 0 1" limited="false"/><geom type="box" size="0.1 0.15 0.2"/>
{ARM.format(s="left", x=-0.2)}{ARM.format(s="right", x=0.2)}
</body></body></worldbody>
<actuator><position joint="left_finger"/></actuator></mujoco>"""
JOINT = "{velocity: 1.7, acceleration: 10, jerk: 1000, torque: 50}"


def arm_yaml(side: str) -> str:
    return f"""
  {side}:
    joints: [{side}_shoulder, {side}_elbow, {side}_wrist]
    tcp: {side}_tcp
    shoulder: {side}_upper
    elbow: {side}_fore
    wrist: {side}_hand
    length: 0.7
    hand: {{body: {side}_hand, approach: [0, 0, 1], opening: [1, 0, 0], max_width: 0.1}}"""


JOINTS = ["lift", "yaw", *(f"{side}_{joint}" for side in ("left", "right") for joint in ("shoulder", "elbow", "wrist"))]
DESCRIPTION = f"""format_version: 1
name: torso_robot
parts: [{{model: torso.xml}}]
base_in_agent: {{position: [0, -0.5, -1.0]}}
joints: {{{", ".join(f"{name}: {JOINT}" for name in JOINTS)}}}
locked_joints: {{left_finger: 0.5}}
torso_joints: [lift, yaw]
arms:{arm_yaml("left")}{arm_yaml("right")}
"""


def write(folder: Path, description: str = DESCRIPTION, model: str = MODEL) -> Path:
    (folder / "torso.xml").write_text(model)
    path = folder / "torso.yaml"
    path.write_text(description)
    return path


@pytest.fixture(scope="session")
def torso_robot(tmp_path_factory) -> Robot:
    return load_robot(write(tmp_path_factory.mktemp("robot")))


@pytest.fixture
def write_torso_robot(tmp_path) -> Callable[..., Path]:
    """Writes the robot with texts replaced in its description or in its model (``in_model=True``)."""

    def write_changed(changes: Mapping[str, str], in_model: bool = False) -> Path:
        text = MODEL if in_model else DESCRIPTION
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new)
        return write(tmp_path, model=text) if in_model else write(tmp_path, text)

    return write_changed
