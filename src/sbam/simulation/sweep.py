"""Many random scenes in physics, on all cores or a cluster. Interrupted sweeps go on where they were."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from sbam.demonstrations.synthetic import BUILT_IN_TASKS
from sbam.errors import UnknownNameError
from sbam.evaluation.fingerprint import code_fingerprint
from sbam.evaluation.parallel import executor
from sbam.files import write_atomically
from sbam.learning.model import Mode
from sbam.robots import load_robot
from sbam.simulation.simulate import yardstick_of
from sbam.simulation.sweep_report import write_failures, write_maps, write_sweep_tables
from sbam.simulation.tasks import TASKS, Values
from sbam.simulation.trial import Case, Row, demonstrations_of, run_case

COMPARED = {"pouring": slice(0, 9, 3), "rolling": slice(0, 8, 3)}
"""Demonstrations that a task's success is measured against: juice into the large cup, one of each layout; rolling."""
TRIALS, FAILURES = "trials", "failures"


def sweep(
    folder: str | Path,
    tasks: Sequence[str] = ("pouring",),
    robots: Sequence[str] = ("panda_dual",),
    constraints: Sequence[str] = ("cartesian", "cylindrical", "symbolic"),
    modes: Sequence[Mode] = ("default",),
    scenes: int = 20,
    paper_scenes: int | None = None,
    jobs: int = -1,
    cluster: str | None = None,
    any_version: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Plan random scenes and try every plan in physics.

    Args:
        folder: keeps a file for every trial as soon as it is finished, so that an interrupted sweep goes on; gets the
            tables (also after an interruption), the maps and pictures of the failures.
        tasks: of `BUILT_IN_TASKS`.
        robots: names or files.
        constraints: types.
        modes: how to learn and plan; ``paper`` takes about a minute a plan.
        scenes: how many random scenes of each task.
        paper_scenes: how many of them in mode ``paper``; by default all.
        jobs: processes; -1 for one per core.
        cluster: address of a Dask scheduler, which then does the work instead of this machine.
        any_version: also take kept trials that another version of the code made; the tables then say so.
        progress: called with the number of finished trials and of all.

    Returns:
        A report with ``rows`` (one a trial), ``cells`` (one a condition) and ``files``.

    Raises:
        UnknownNameError: for an unknown task or robot.
        FileFormatError: if a robot's description cannot be used.
        ClusterError: if the cluster does not answer.
    """
    import joblib

    folder = Path(folder)
    for task in tasks:
        if task not in BUILT_IN_TASKS:
            raise UnknownNameError("task", task, BUILT_IN_TASKS, "sweeps")
    for robot in robots:
        load_robot(robot)
    counts = {
        mode: scenes if mode == "default" or paper_scenes is None else min(scenes, paper_scenes) for mode in modes
    }
    cases = [
        Case(task, robot, constraint, mode, seed)
        for mode in modes
        for seed in range(counts[mode])  # outside, so that an unfinished sweep has as many of every condition
        for task in tasks
        for robot in robots
        for constraint in constraints
    ]
    rows = {case: row for case in cases if (row := _kept(folder, case, any_version)) is not None}
    left = [case for case in cases if case not in rows]
    yardsticks = {task: _yardstick(folder, task) for task in {case.task for case in left}}
    report = progress or (lambda done, total: None)
    report(len(rows), len(cases))
    try:
        with executor(jobs, cluster) as parallel:
            trials = (joblib.delayed(_tried)(case, yardsticks[case.task]) for case in left)
            for case, row, picture in parallel(trials):
                rows[case] = _keep(folder, case, row, picture)
                write_sweep_tables(_ordered(rows, cases), folder)
                report(len(rows), len(cases))
    finally:  # also when it is interrupted
        ordered = _ordered(rows, cases)
        tables, files = write_sweep_tables(ordered, folder)
        files += [*write_maps(ordered, folder), write_failures(ordered, folder)]
    return {
        "ok": True,
        "problems": [],
        "rows": ordered,
        "success": [dict(zip(tables[0].columns, cells, strict=True)) for cells in tables[0].rows],
        "cells": [dict(zip(tables[1].columns, cells, strict=True)) for cells in tables[1].rows],
        "files": [str(file) for file in files],
    }


def _tried(case: Case, yardstick: Values) -> tuple[Case, Row, bytes | None]:
    return case, *run_case(case, yardstick)


def _ordered(rows: dict[Case, Row], cases: Sequence[Case]) -> list[Row]:
    return [rows[case] for case in cases if case in rows]


@cache
def _version() -> str:
    """What the results depend on."""
    own = sorted(Path(__file__).parent.rglob("*.py"))
    digest = hashlib.sha256(code_fingerprint().encode())
    for file in own:
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _kept(folder: Path, case: Case, any_version: bool = False) -> Row | None:
    return _read(folder / TRIALS / f"{case.name}.json", any_version)


def _keep(folder: Path, case: Case, row: Row, picture: bytes | None) -> Row:
    """Keep a finished trial and the picture of its failure; an earlier trial's picture goes."""
    path = folder / FAILURES / f"{case.name}.png"
    path.unlink(missing_ok=True)
    if picture:
        write_atomically(path, picture)
        row = {**row, "picture": f"{FAILURES}/{path.name}"}
    row = {**row, "version": _version()}
    write_atomically(folder / TRIALS / f"{case.name}.json", json.dumps({"version": _version(), "content": row}))
    return row


def _yardstick(folder: Path, task: str) -> Values:
    path = folder / TRIALS / f"yardstick_{task}.json"
    kept = _read(path)
    if kept is None:
        kept = yardstick_of(demonstrations_of(task)[COMPARED[task]], TASKS[task])
        write_atomically(path, json.dumps({"version": _version(), "content": kept}))
    return kept


def _read(path: Path, any_version: bool = False) -> Row | None:
    """What was kept, if this version of the code made it."""
    try:
        kept = json.loads(path.read_bytes())
        return kept["content"] if any_version or kept["version"] == _version() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
