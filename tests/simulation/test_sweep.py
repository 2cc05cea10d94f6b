import json
from dataclasses import asdict
from pathlib import Path

import pytest

from sbam.errors import UnknownNameError
from sbam.simulation import simulate
from sbam.simulation import sweep as module
from sbam.simulation.sweep import sweep
from sbam.simulation.sweep_report import success_table, sweep_table


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """One scene of rolling, swept in this process, and its folder."""
    folder = tmp_path_factory.mktemp("sweep")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(module.COMPARED, "rolling", slice(0, 1))
        return folder, sweep(folder, ["rolling"], constraints=["cartesian"], scenes=1, jobs=1)


def test_a_sweep_says_what_came_of_every_scene(swept) -> None:
    folder, report = swept
    (row,) = report["rows"]
    assert row["stage"] == "physics", row["problems"]
    assert row["ok"] == (row["verified"] and row["succeeds"])
    assert row["physics_s"] > 0.0
    assert row["values"]["half-strokes"] == 8
    assert report["cells"][0]["scenes"] == "1"
    assert report["success"][0]["cartesian"] == ("1 of 1 (100 %)" if row["ok"] else "0 of 1 (0 %)")
    written = {Path(file).name for file in report["files"]}
    assert {"success.md", "physics.md", "map_rolling_default.png", "failures.md"} <= written
    assert all((folder / name).is_file() for name in written)


def test_an_interrupted_sweep_goes_on_and_has_its_tables(swept, tmp_path: Path, monkeypatch) -> None:
    folder, report = swept
    kept = next((folder / "trials").glob("rolling_panda*.json"))
    for file in (folder / "trials").iterdir():
        (tmp_path / "trials").mkdir(exist_ok=True)
        (tmp_path / "trials" / file.name).write_bytes(file.read_bytes())

    def interrupted(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(module, "run_case", interrupted)
        with pytest.raises(KeyboardInterrupt):
            sweep(tmp_path, ["rolling"], constraints=["cartesian"], scenes=2, jobs=1)
    assert "of 1 (" in (tmp_path / "success.md").read_text()
    with monkeypatch.context() as patch:
        patch.setattr(module, "run_case", interrupted)  # nothing is tried again
        again = sweep(tmp_path, ["rolling"], constraints=["cartesian"], scenes=1, jobs=1)
    assert again["rows"] == report["rows"]
    # a trial that another version of the code made
    trial = tmp_path / "trials" / kept.name
    content = json.loads(trial.read_text())
    content["result"]["version"] = "another"
    trial.write_text(json.dumps({**content, "fingerprint": "another"}))
    seen: list[tuple[int, int]] = []
    options = {"constraints": ["cartesian"], "scenes": 1, "jobs": 1, "progress": lambda *n: seen.append(n)}
    (row,) = sweep(tmp_path, ["rolling"], any_version=True, **options)["rows"]
    assert (row["version"], seen) == ("another", [(1, 1)])
    with monkeypatch.context() as patch:
        patch.setattr(module, "run_case", interrupted)
        with pytest.raises(KeyboardInterrupt):
            sweep(tmp_path, ["rolling"], **options)
    assert seen[1:] == [(0, 1)]


def test_a_fault_in_one_trial_does_not_end_the_sweep(tmp_path: Path, monkeypatch) -> None:
    def faulty(*_):
        raise ZeroDivisionError("in the planner")

    monkeypatch.setattr("sbam.simulation.trial.plan", faulty)
    monkeypatch.setattr(module, "_yardstick", lambda folder, task: {})
    report = sweep(tmp_path, ["rolling"], ["panda_dual:base_distance=0.9"], ["cartesian"], scenes=2, jobs=1)
    assert [row["problems"] for row in report["rows"]] == [["ZeroDivisionError: in the planner"]] * 2
    assert report["success"][0]["cartesian"] == "0 of 2 (0 %)"
    assert "ZeroDivisionError" in (tmp_path / "failures.md").read_text()


def test_a_failure_has_a_picture_of_its_moment(pour, good_values) -> None:
    from sbam.errors import RenderingError
    from sbam.simulation.trial import _picture_of_result

    result = simulate(pour(aside=0.065), yardstick=good_values)
    assert result.moment == pytest.approx(min(spill["time [s]"] for spill in result.values["spills"]))
    try:
        picture = _picture_of_result(result)
    except RenderingError as error:
        pytest.skip(str(error))
    assert picture.startswith(b"\x89PNG")


@pytest.fixture(scope="module")
def good_values():
    return {"poured": 1.0, "spilled": 0.0}


def test_fewer_scenes_for_the_paper(monkeypatch, tmp_path: Path) -> None:
    seen = []

    def noted(case, yardstick):
        seen.append(case)
        return {**asdict(case), **FAILED, "places": {"pin": [0.0, 0.5]}}, None

    monkeypatch.setattr(module, "run_case", noted)
    monkeypatch.setattr(module, "_yardstick", lambda folder, task: {})
    sweep(
        tmp_path, ["rolling"], constraints=["cartesian"], modes=["default", "paper"], scenes=3, paper_scenes=1, jobs=1
    )
    assert [(case.mode, case.seed) for case in seen] == [("default", 0), ("default", 1), ("default", 2), ("paper", 0)]


def test_unknown_tasks_and_robots_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="rolling"):
        sweep(tmp_path, ["juggling"])
    with pytest.raises(UnknownNameError, match="armar6"):
        sweep(tmp_path, ["rolling"], ["armar5"])


FAILED = {"ok": False, "verified": False, "succeeds": None, "problems": ["why"], "values": {}, "warnings": []}


def test_tables_count_plans_and_successes_apart() -> None:
    base = {"task": "pouring", "robot": "r", "constraint": "c", "mode": "default", **FAILED}
    tried = {**base, "verified": True, "succeeds": True, "torque_ratio": 0.5, "values": {"poured": 0.9, "spilled": 0.0}}
    rows = [{**tried, "ok": True}, {**tried, "succeeds": False}, {**tried, "verified": False}, base]
    (cells,) = sweep_table(rows).rows
    assert cells[4:8] == ("4", "2", "2", "1")
    assert cells[8:] == (pytest.approx(90.0), 0.0, None, 0.5, None, None)
    assert success_table(rows).rows == (("pouring", "r", "default", "1 of 4 (25 %)"),)
