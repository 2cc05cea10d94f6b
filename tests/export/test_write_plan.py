"""Writing plans: which files, and when nothing is written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sbam.errors import OutputError, TrajectoryError, UnknownNameError
from sbam.export import TRAJECTORY_FORMATS, read_trajectory_npz, write_plan
from sbam.planning.plan import Plan


def test_every_format_writes_its_files(small_plan: Plan, tmp_path: Path) -> None:
    paths = write_plan(small_plan, tmp_path / "new" / "folder", TRAJECTORY_FORMATS)
    assert {path.name for path in paths} == {"trajectory.npz", "trajectory.csv", "objects.csv", "trajectory_ros.json"}
    assert set(paths) == set((tmp_path / "new" / "folder").iterdir())


def test_a_plan_with_problems_is_written_only_on_request(small_plan: Plan, tmp_path: Path) -> None:
    bad = replace(small_plan, problems=("keypoint 3 is out of reach",))
    with pytest.raises(TrajectoryError, match="keypoint 3 is out of reach"):
        write_plan(bad, tmp_path)
    assert not list(tmp_path.iterdir())
    (path,) = write_plan(bad, tmp_path, ["npz"], allow_problems=True)
    assert read_trajectory_npz(path).meta.problems == bad.problems


def test_numbers_that_are_not_finite_are_never_written(small_plan: Plan, tmp_path: Path) -> None:
    velocity = small_plan.trajectory.velocity.copy()
    velocity[5, 2] = np.inf
    bad = replace(small_plan, trajectory=replace(small_plan.trajectory, velocity=velocity))
    with pytest.raises(TrajectoryError, match="velocity"):
        write_plan(bad, tmp_path, allow_problems=True)
    assert not list(tmp_path.iterdir())


def test_unknown_formats_are_named_before_anything_is_written(small_plan: Plan, tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"'xlsx'; known: 'npz', 'csv', 'ros'"):
        write_plan(small_plan, tmp_path, ["npz", "xlsx"])
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_named(small_plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        write_plan(small_plan, tmp_path / "file", ["ros"])
