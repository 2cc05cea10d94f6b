"""Many random scenes in physics, on all cores or a cluster. Interrupted sweeps go on where they were."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sbam.batch.fingerprint import code_fingerprint, definition_fingerprint, fingerprint, robot_fingerprint
from sbam.batch.kept_results import KeptResults, Key
from sbam.batch.resumable import Progress, resumed
from sbam.constraints import BUILT_IN_CONSTRAINTS, constraint_type
from sbam.demonstrations.synthetic import BUILT_IN_TASKS
from sbam.errors import UnknownNameError
from sbam.files import write_atomically
from sbam.learning.model import Mode
from sbam.robots import load_robot
from sbam.simulation.simulate import yardstick_of
from sbam.simulation.sweep_report import write_failures, write_maps, write_sweep_tables
from sbam.simulation.trial import Case, Row, demonstrations_of, run_case
from sbam.tasks.physics_task import Values
from sbam.tasks.registry import TASKS

COMPARED = {"pouring": slice(0, 9, 3), "rolling": slice(0, 8, 3)}
"""Demonstrations that a task's success is measured against: juice into the large cup, one of each layout; rolling."""
TRIALS, FAILURES = "trials", "failures"


def sweep(
    folder: str | Path,
    tasks: Sequence[str] = ("pouring",),
    robots: Sequence[str] = ("panda_dual",),
    constraints: Sequence[str] = BUILT_IN_CONSTRAINTS,
    modes: Sequence[Mode] = ("default",),
    scenes: int = 20,
    paper_scenes: int | None = None,
    jobs: int = -1,
    cluster: str | None = None,
    any_version: bool = False,
    progress: Progress | None = None,
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
        UnknownNameError: for an unknown task, robot or constraint type.
        FileFormatError: if a robot's description cannot be used.
        ClusterError: if the cluster does not answer.
    """
    folder = Path(folder)
    for task in tasks:
        if task not in BUILT_IN_TASKS:
            raise UnknownNameError("task", task, BUILT_IN_TASKS, "sweeps")
    robot_keys = {robot: robot_fingerprint(load_robot(robot)) for robot in robots}
    types = {name: definition_fingerprint(constraint_type(name)) for name in constraints}
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
    version = code_fingerprint("simulation")
    keys = [Key(case.name, fingerprint(version, robot_keys[case.robot], types[case.constraint])) for case in cases]
    kept = KeptResults(folder / TRIALS, dict[str, Any], any_version)

    def piece(index: int) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return run_case, (cases[index], _yardstick(folder, cases[index].task))

    def receive(index: int, returned: tuple[Row, bytes | None]) -> dict[str, Any]:
        row, picture = returned
        return {**row, **_write_picture(folder, cases[index], picture), "version": version[:16]}

    rows: Mapping[int, Row] = {}
    try:
        for rows in resumed(keys, piece, kept, jobs, cluster, progress, receive):
            write_sweep_tables(_ordered(rows), folder)
    finally:  # also when it is interrupted
        ordered = _ordered(rows)
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


def _ordered(rows: Mapping[int, Row]) -> list[Row]:
    return [rows[index] for index in sorted(rows)]


def _write_picture(folder: Path, case: Case, picture: bytes | None) -> Row:
    """Write the picture of a failure and say where it is; an earlier trial's picture goes."""
    path = folder / FAILURES / f"{case.name}.png"
    path.unlink(missing_ok=True)
    if not picture:
        return {}
    write_atomically(path, picture)
    return {"picture": f"{FAILURES}/{path.name}"}


def _yardstick(folder: Path, task: str) -> Values:
    kept = KeptResults(folder / TRIALS, dict[str, Any])
    key = Key(f"yardstick_{task}", code_fingerprint("simulation"))
    found = kept.find(key)
    if found is None:
        found = dict(yardstick_of(demonstrations_of(task)[COMPARED[task]], TASKS[task]))
        kept.keep(key, found)
    return found
