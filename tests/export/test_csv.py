"""The CSV files hold the plan's numbers under names with units."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sbam.export.csv import encode
from sbam.planning.plan import Plan


def table(content: bytes) -> tuple[list[str], np.ndarray]:
    lines = content.decode()
    header = next(csv.reader(io.StringIO(lines)))
    return header, np.loadtxt(io.StringIO(lines), delimiter=",", skiprows=1)


@pytest.fixture(scope="module")
def files(small_plan: Plan) -> dict[str, tuple[list[str], np.ndarray]]:
    return {name: table(content) for name, content in encode(small_plan).items()}


def test_joint_values_stand_in_named_columns(small_plan: Plan, files) -> None:
    header, values = files["trajectory.csv"]
    trajectory = small_plan.trajectory
    assert np.allclose(values[:, header.index("time[s]")], trajectory.time, atol=0, rtol=1e-9)
    for joint, name in enumerate(trajectory.joint_names):
        for quantity, unit in (("position", "rad"), ("velocity", "rad/s"), ("acceleration", "rad/s^2")):
            column = values[:, header.index(f"{name}.{quantity}[{unit}]")]
            assert np.allclose(column, getattr(trajectory, quantity)[:, joint], atol=1e-15, rtol=1e-9)
    assert len(header) == 1 + 3 * len(trajectory.joint_names)
    last = values[-1, [column for column, name in enumerate(header) if ".velocity" in name]]
    assert not last.any()  # controllers refuse anything but an exact zero


def test_object_poses_stand_in_named_columns(small_plan: Plan, files) -> None:
    header, values = files["objects.csv"]
    for name, pose in small_plan.object_poses().items():
        position = values[:, [header.index(f"{name}.{axis}[m]") for axis in "xyz"]]
        assert np.abs(position - pose.translation).max() < 1e-9
        rotation = Rotation.from_quat(values[:, [header.index(f"{name}.q{axis}") for axis in "xyzw"]])
        assert (rotation.inv() * pose.rotation).magnitude().max() < 1e-7


def test_prismatic_joints_are_in_metres(small_plan: Plan) -> None:
    robot = small_plan.robot.placed(small_plan.robot.T_world_base)
    robot.is_prismatic = np.array([True, *[False] * 13])
    header, _ = table(encode(replace(small_plan, robot=robot))["trajectory.csv"])
    first, second = small_plan.trajectory.joint_names[:2]
    assert {f"{first}.position[m]", f"{first}.acceleration[m/s^2]", f"{second}.velocity[rad/s]"} <= set(header)


def test_a_comma_in_an_object_s_name_stays_one_column(small_plan: Plan) -> None:
    poses = {name.replace("cup_large", 'cup, "mine"'): pose for name, pose in small_plan.T_agent_object.items()}
    header, values = table(encode(replace(small_plan, T_agent_object=poses))["objects.csv"])
    assert 'cup, "mine".x[m]' in header
    assert values.shape[1] == len(header)
