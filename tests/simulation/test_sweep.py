import json
import time
from pathlib import Path

import pytest

from sbam.errors import UnknownNameError
from sbam.simulation import sweep as module
from sbam.simulation.sweep import sweep, sweep_table


def test_a_sweep_keeps_its_trials_and_goes_on(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(module.COMPARED, "rolling", slice(0, 1))
    first = sweep(tmp_path, ["rolling"], constraints=["cartesian"], scenes=1, jobs=1)
    (row,) = first["rows"]
    assert row["stage"] == "physics", row["problems"]
    assert first["cells"][0]["scenes"] == 1.0
    assert {Path(file).name for file in first["files"]} == {
        "physics.md", "physics.csv", "physics.tex", "map_rolling.png",
    }  # fmt: skip
    begin = time.perf_counter()
    assert sweep(tmp_path, ["rolling"], constraints=["cartesian"], scenes=1, jobs=1)["rows"] == first["rows"]
    assert time.perf_counter() - begin < 3.0
    (trial,) = (tmp_path / "trials").glob("rolling_panda*.json")
    kept = json.loads(trial.read_text())
    trial.write_text(json.dumps({**kept, "version": "another"}))
    assert module._kept(tmp_path, module.Case("rolling", "panda_dual", "cartesian", "default", 0)) is None


def test_an_unknown_task_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="rolling"):
        sweep(tmp_path, ["juggling"])


def test_table_counts_plans_and_successes_apart() -> None:
    base = {"task": "pouring", "robot": "r", "constraint": "c", "mode": "default", "warnings": [], "torque_ratio": 0.5}
    tried = {**base, "stage": "physics", "values": {"poured": 0.9, "spilled": 0.0}}
    rows = [{**tried, "ok": True}, {**tried, "ok": False}, {**base, "stage": "plan", "values": {}, "ok": False}]
    (cells,) = sweep_table(rows).rows
    assert cells[4:] == pytest.approx((3.0, 2.0, 50.0, 100.0 / 3.0, 90.0, 0.0, 0.5))
