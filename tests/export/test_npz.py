"""trajectory.npz gives back what the plan holds, and bad files are refused."""

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.errors import FileFormatError, FileVersionError
from sbam.export import npz, read_trajectory_npz, write_plan
from sbam.planning.plan import Plan


@pytest.fixture(scope="module")
def file(small_plan: Plan, tmp_path_factory) -> Path:
    (path,) = write_plan(small_plan, tmp_path_factory.mktemp("npz"), ["npz"])
    return path


@pytest.fixture
def changed(file: Path, tmp_path: Path):
    """Writes the file with some arrays replaced (None: left out)."""

    def write(**changes) -> Path:
        with np.load(file) as archive:
            arrays = {key: archive[key] for key in archive.files} | changes
        path = tmp_path / "changed.npz"
        np.savez(path, **{key: array for key, array in arrays.items() if array is not None})
        return path

    return write


def test_everything_comes_back(small_plan: Plan, file: Path) -> None:
    saved = read_trajectory_npz(file)
    trajectory = small_plan.trajectory
    assert saved.trajectory.joint_names == trajectory.joint_names
    for name in ("time", "position", "velocity", "acceleration"):
        assert np.array_equal(getattr(saved.trajectory, name), getattr(trajectory, name))
    assert np.array_equal(saved.model_time, small_plan.model_time)
    assert saved.phases == small_plan.phases
    assert set(saved.T_world_object) == set(small_plan.object_poses())
    for name, pose in small_plan.object_poses().items():
        difference = pose.inv() * saved.T_world_object[name]
        assert np.abs(difference.translation).max() < 1e-12
        assert difference.rotation.magnitude().max() < 1e-7
    assert saved.meta.synthetic is True
    assert saved.meta.ok is small_plan.ok
    assert "kitchen_sideboard" in saved.meta.standing_objects


def test_it_is_understood_without_this_package(small_plan: Plan, file: Path) -> None:
    with np.load(file, allow_pickle=False) as archive:
        assert archive["joint_names"].tolist() == list(small_plan.trajectory.joint_names)
        assert archive["object_position"].shape == (len(archive["time"]), len(archive["object_names"]), 3)
        quaternions_wxyz = archive["object_quaternion_wxyz"]
        assert np.allclose(np.linalg.norm(quaternions_wxyz, axis=-1), 1.0)
        assert np.abs(np.diff(quaternions_wxyz, axis=0)).max() < 0.01  # signs do not jump
        assert json.loads(archive["meta"].item())["units"]["object_position"] == "m"
        at = archive["time"][archive["keypoint_index"]]
        assert np.abs(at - archive["keypoint_time"]).max() <= 0.5005e-3
        assert len(at) == len(small_plan.task.model.keypoint_times)


def test_the_robots_frame_is_given_in_the_world(small_plan: Plan) -> None:
    away = RigidTransform.from_translation([1.0, 2.0, 3.0])
    turned = replace(small_plan.task.scene, T_world_agent=away * small_plan.T_world_agent)
    robot = small_plan.robot.placed(away * small_plan.robot.T_world_base)
    moved = replace(small_plan, task=replace(small_plan.task, scene=turned), robot=robot)
    arrays = np.load(io.BytesIO(npz.encode(moved)[npz.FILE]))
    base = json.loads(arrays["meta"].item())["T_world_base"]["position"]
    assert np.allclose(base, small_plan.robot.T_world_base.translation + np.array([1.0, 2.0, 3.0]))
    first = arrays["object_names"].tolist()[0]
    there = small_plan.object_poses()[first].translation + np.array([1.0, 2.0, 3.0])
    assert np.allclose(arrays["object_position"][:, 0], there)


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"velocity": None}, "velocity"),
        ({"meta": None}, "meta"),
        ({"meta": np.array("{")}, "meta"),
        ({"meta": np.array(1.0)}, "meta"),
        ({"joint_names": np.array(["one"])}, "position"),
        ({"joint_names": np.arange(14)}, "joint_names"),
        ({"time": np.array(["a"])}, "time"),
        ({"time": np.zeros((2, 2))}, "time"),
        ({"phase_start": np.array([np.nan] * 10)}, "phase_start"),
        ({"format_version": None}, "format_version"),
    ],
)
def test_damaged_files_say_where(changed, changes, where: str) -> None:
    with pytest.raises(FileFormatError) as error:
        read_trajectory_npz(changed(**changes))
    assert error.value.where == where


def test_numbers_that_are_not_finite_are_refused(small_plan: Plan, changed) -> None:
    position = small_plan.trajectory.position.copy()
    position[7, 3] = np.nan
    with pytest.raises(FileFormatError, match="position: holds numbers that are not finite"):
        read_trajectory_npz(changed(position=position))


def test_a_later_version_says_so(changed) -> None:
    with pytest.raises(FileVersionError, match="format version 2 is later than 1"):
        read_trajectory_npz(changed(format_version=np.array(2)))


def test_other_files_are_refused(tmp_path: Path, changed) -> None:
    path = tmp_path / "a.npz"
    with pytest.raises(FileFormatError):
        read_trajectory_npz(path)
    path.write_bytes(b"nothing")
    with pytest.raises(FileFormatError, match="not a readable NPZ file"):
        read_trajectory_npz(path)
    with zipfile.ZipFile(path, "w"):
        pass
    with pytest.raises(FileFormatError, match="format_version: is missing"):
        read_trajectory_npz(path)
    with pytest.raises(FileFormatError):  # pickled objects are never loaded
        read_trajectory_npz(changed(position=np.array([object()], dtype=object)))
