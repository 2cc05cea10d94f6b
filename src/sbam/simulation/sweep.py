"""Many random scenes in physics: a table and a map of where it works. Interrupted sweeps go on where they were."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.synthetic import BUILT_IN_TASKS, built_in_demonstrations
from sbam.errors import RenderingError, SbamError, UnknownNameError
from sbam.evaluation import random_pouring_scene, random_rolling_scene
from sbam.evaluation.evaluate import write_tables
from sbam.evaluation.fingerprint import code_fingerprint
from sbam.evaluation.tables import Table
from sbam.files import write_atomically
from sbam.learning.learn import learn
from sbam.learning.model import ActionModel, Mode
from sbam.planning.plan import plan
from sbam.planning.report import plain
from sbam.planning.settings import PlanSettings
from sbam.scene import Scene
from sbam.simulation.action import action_of_plan
from sbam.simulation.simulate import simulate, yardstick_of
from sbam.simulation.tasks import TASKS, Values

Row = Mapping[str, Any]
SCENES: Mapping[str, Callable[[int], Scene]] = {"pouring": random_pouring_scene, "rolling": random_rolling_scene}
COMPARED = {"pouring": slice(0, 9, 3), "rolling": slice(0, 8, 3)}
"""Demonstrations that a task's success is measured against: juice into the large cup, one of each layout; rolling."""


@dataclass(frozen=True)
class Case:
    """One trial.

    Attributes:
        task: of `BUILT_IN_TASKS`.
        robot: name or file of the robot.
        constraint: type of the constraints.
        mode: how to learn, and with which solver to plan.
        seed: of the random scene.
    """

    task: str
    robot: str
    constraint: str
    mode: Mode
    seed: int

    @property
    def name(self) -> str:
        """Name for files."""
        return f"{self.task}_{Path(self.robot).stem}_{self.constraint}_{self.mode}_{self.seed:03d}"


def sweep(
    folder: str | Path,
    tasks: Sequence[str] = ("pouring",),
    robots: Sequence[str] = ("panda_dual",),
    constraints: Sequence[str] = ("cartesian", "cylindrical", "symbolic"),
    modes: Sequence[Mode] = ("default",),
    scenes: int = 20,
    jobs: int = -1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Plan random scenes and try every plan in physics.

    Args:
        folder: keeps a file for every trial, so that an interrupted sweep goes on; gets the tables, the maps and
            pictures of the failures.
        tasks: of `BUILT_IN_TASKS`.
        robots: names or files.
        constraints: types.
        modes: how to learn and plan.
        scenes: how many random scenes of each task.
        jobs: processes; -1 for one per core.
        progress: called with the number of finished trials and of all.

    Returns:
        A report with ``rows`` (one a trial), ``cells`` (one a condition) and ``files``.

    Raises:
        UnknownNameError: for an unknown task.
    """
    import joblib

    folder = Path(folder)
    for task in tasks:
        if task not in BUILT_IN_TASKS:
            raise UnknownNameError("task", task, BUILT_IN_TASKS, "sweeps")
    cases = [
        Case(task, robot, constraint, mode, seed)
        for task in tasks
        for robot in robots
        for constraint in constraints
        for mode in modes
        for seed in range(scenes)
    ]
    rows = {case: row for case in cases if (row := _kept(folder, case)) is not None}
    left = [case for case in cases if case not in rows]
    yardsticks = {task: _yardstick(folder, task) for task in {case.task for case in left}}
    report = progress or (lambda done, total: None)
    report(len(rows), len(cases))
    trials = (joblib.delayed(_keep)(folder, case, yardsticks[case.task]) for case in left)
    finished: Any = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")(trials)
    for case, row in finished:
        rows[case] = row
        report(len(rows), len(cases))
    ordered = [rows[case] for case in cases]
    table = sweep_table(ordered)
    files = write_tables([table], folder)
    files += [_write_map(ordered, task, folder / f"map_{task}.png") for task in tasks]
    return {
        "ok": True,
        "problems": [],
        "rows": ordered,
        "cells": [dict(zip(table.columns, cells, strict=True)) for cells in table.rows],
        "files": [str(file) for file in files],
    }


def run_case(case: Case, yardstick: Values, picture: Path | None = None) -> Row:
    """Plan one scene and try the plan.

    Args:
        case: the trial.
        yardstick: what success is measured against.
        picture: where moments of a failure are drawn.

    Returns:
        The case's fields, ``stage`` (``plan`` if there was nothing to try), ``ok``, ``problems`` and numbers.
    """
    scene = SCENES[case.task](case.seed)
    moved = [name for name, model in scene.objects.items() if model.movable]
    row: dict[str, Any] = {**asdict(case), "ok": False, "stage": "plan", "values": {}, "warnings": []}
    row["places"] = {name: scene.T_world_object[name].translation[:2] for name in moved}
    begin = time.perf_counter()
    try:
        planned = plan(_model(case.task, case.constraint, case.mode), scene, case.robot, PlanSettings(solver=case.mode))
        row["planning_s"] = time.perf_counter() - begin
        if planned.problems:
            return plain({**row, "problems": planned.problems})
        result = simulate(action_of_plan(planned), TASKS[case.task], yardstick=yardstick)
    except SbamError as error:
        return plain({**row, "problems": [str(error)]})
    if picture is not None and not result.ok:
        from sbam.simulation.film import write_film

        try:
            write_film(result, picture)
        except RenderingError as error:
            row["warnings"].append(str(error))
    row |= {"ok": result.ok, "stage": "physics", "problems": result.problems}
    row["warnings"] += result.warnings
    row["values"] = {key: value for key, value in result.values.items() if isinstance(value, float)}
    row["tracking_error"] = max(result.record.tracking_error.values(), default=0.0)
    row["torque_ratio"] = max(result.record.torque_ratio.values(), default=0.0)
    return plain(row)


def sweep_table(rows: Sequence[Row]) -> Table:
    """Success of every condition."""
    names = ("task", "robot", "constraint", "mode")
    keys = list(dict.fromkeys(tuple(str(row[name]) for name in names) for row in rows))
    lines = []
    for key in keys:
        own = [row for row in rows if tuple(str(row[name]) for name in names) == key]
        tried = [row for row in own if row["stage"] == "physics"]
        main = "poured" if key[0] == "pouring" else "off the planned thickness, 95 % [mm]"
        lines.append(
            (
                *key,
                float(len(own)),
                float(len(tried)),
                100.0 * sum(row["ok"] for row in tried) / len(tried) if tried else None,
                100.0 * sum(row["ok"] for row in own) / len(own),
                _mean(tried, main, 100.0 if main == "poured" else 1.0),
                _mean(tried, "spilled", 100.0),
                max((row["torque_ratio"] for row in tried), default=None),
            )
        )
    return Table(
        name="physics",
        caption="Random scenes in physics. Poured and spilled: % of the content; off: mm off the planned thickness.",
        columns=(
            *names,
            "scenes",
            "planned",
            "success, % of planned",
            "success, % of scenes",
            "poured % / off mm",
            "spilled %",
            "largest torque / limit",
        ),
        rows=tuple(lines),
    )


def _mean(rows: Sequence[Row], key: str, factor: float) -> float | None:
    found = [row["values"][key] for row in rows if key in row["values"]]
    return factor * float(np.mean(found)) if found else None


def _write_map(rows: Sequence[Row], task: str, path: Path) -> Path:
    """Where the moved objects stood: the last one of each scene, by what came of it."""
    import io

    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 5.0), dpi=110)
    axes = figure.subplots()
    looks = {"success": ("tab:green", "o"), "failure in physics": ("tab:red", "X"), "no plan": ("tab:gray", "s")}
    for label, (color, marker) in looks.items():
        own = [row for row in rows if row["task"] == task and _outcome(row) == label]
        places = np.array([list(row["places"].values())[-1] for row in own]).reshape(-1, 2)
        axes.scatter(places[:, 0], places[:, 1], c=color, marker=marker, alpha=0.6, label=f"{label} ({len(own)})")
    axes.set_xlabel("to the agent's right, m")
    axes.set_ylabel("before the agent, m")
    axes.set_aspect("equal")
    axes.set_title(f"{task}: where the {'bottle' if task == 'pouring' else 'pin'} stood")
    axes.legend()
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_atomically(path, content.getvalue())
    return path


def _outcome(row: Row) -> str:
    return "success" if row["ok"] else "failure in physics" if row["stage"] == "physics" else "no plan"


def _demonstrations(task: str) -> tuple[Demonstration, ...]:
    return built_in_demonstrations(BUILT_IN_TASKS[BUILT_IN_TASKS.index(task)])


@cache
def _model(task: str, constraint: str, mode: Mode) -> ActionModel:
    return learn(_demonstrations(task), constraint, mode)


@cache
def _version() -> str:
    """What the results depend on."""
    own = sorted(Path(__file__).parent.rglob("*.py"))
    digest = hashlib.sha256(code_fingerprint().encode())
    for file in own:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _kept(folder: Path, case: Case) -> Row | None:
    return _read(folder / "trials" / f"{case.name}.json")


def _keep(folder: Path, case: Case, yardstick: Values) -> tuple[Case, Row]:
    row = run_case(case, yardstick, folder / "failures" / f"{case.name}.png")
    write_atomically(folder / "trials" / f"{case.name}.json", json.dumps({"version": _version(), "content": row}))
    return case, row


def _yardstick(folder: Path, task: str) -> Values:
    path = folder / "trials" / f"yardstick_{task}.json"
    kept = _read(path)
    if kept is None:
        kept = yardstick_of(_demonstrations(task)[COMPARED[task]], TASKS[task])
        write_atomically(path, json.dumps({"version": _version(), "content": kept}))
    return kept


def _read(path: Path) -> Row | None:
    """What was kept, if this version of the code made it."""
    try:
        kept = json.loads(path.read_bytes())
        return kept["content"] if kept["version"] == _version() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
