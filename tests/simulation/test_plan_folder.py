import json
from pathlib import Path

import numpy as np
import pytest

from sbam.errors import FileFormatError, SimulationError
from sbam.results import write_results
from sbam.simulation.action import action_of_plan
from sbam.simulation.plan_folder import read_plan_folder


@pytest.fixture(scope="module")
def folder(small_plan, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("plan")
    write_results(small_plan, folder)
    return folder


def test_a_written_plan_comes_back(small_plan, folder: Path) -> None:
    wanted, found = action_of_plan(small_plan), read_plan_folder(folder)
    assert found.roles == wanted.roles
    assert found.arms is not None
    assert wanted.arms is not None
    assert np.array_equal(found.arms.trajectory.position, wanted.arms.trajectory.position)
    assert found.arms.robot.T_world_base.as_matrix() == pytest.approx(wanted.arms.robot.T_world_base.as_matrix())
    assert set(found.scene.objects) == set(wanted.scene.objects)
    key = lambda grip: (grip.object, grip.hand)  # noqa: E731
    for one, other in zip(sorted(found.arms.grips, key=key), sorted(wanted.arms.grips, key=key), strict=True):
        assert (one.hand, one.object, one.width) == (other.hand, other.object, other.width)
        assert (one.closing, one.start, one.end, one.opened) == pytest.approx(
            (other.closing, other.start, other.end, other.opened)
        )
        assert one.T_object_tcp.as_matrix() == pytest.approx(other.T_object_tcp.as_matrix())


def test_a_folder_without_a_plan_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match=r"lacks trajectory\.npz, report\.json, scene\.yaml"):
        read_plan_folder(tmp_path)


def test_a_damaged_report_is_refused(folder: Path, tmp_path: Path) -> None:
    for file in ("trajectory.npz", "scene.yaml"):
        (tmp_path / file).write_bytes((folder / file).read_bytes())
    report = json.loads((folder / "report.json").read_text())
    del report["grasps"][0]["hand"]
    (tmp_path / "report.json").write_text(json.dumps(report))
    with pytest.raises(FileFormatError, match=r"hand.*grasps"):
        read_plan_folder(tmp_path)
