"""Evaluation as a whole: from recordings to tables and a report."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec

from sbam.batch.table import Table, write_tables
from sbam.constraints import BUILT_IN_CONSTRAINTS, constraint_type
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.loading import BUILT_IN, load
from sbam.demonstrations.synthetic import BUILT_IN_TASKS, BuiltInTask, built_in_demonstrations
from sbam.errors import SettingsError
from sbam.evaluation.cross_validation import evaluate_folds, learning_only_from, leave_one_out, train_and_test
from sbam.evaluation.fold import FLYING_HANDS, Condition, FoldResult
from sbam.evaluation.tables import evaluation_tables
from sbam.learning.settings import LearningSettings
from sbam.plain import plain
from sbam.planning.settings import PlanSettings
from sbam.scene import ObjectLibrary


def evaluate(
    recordings: Sequence[str | Path],
    train: Sequence[str | Path] = (),
    train_objects: Sequence[str] = (),
    robot: str = FLYING_HANDS,
    constraints: Sequence[str] = BUILT_IN_CONSTRAINTS,
    modes: Sequence[str] = ("default",),
    solvers: Sequence[str] = ("default",),
    prune: float | None = None,
    seed: int = 0,
    library: ObjectLibrary | None = None,
    jobs: int = -1,
    cache: Path | None = None,
    cluster: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[FoldResult]:
    """Measure how near executions come to what people did.

    Args:
        recordings: what to compare with: a task (``pouring``, ``rolling``: the built-in demonstrations), or anything
            that `sbam.load` takes. Without ``train`` they are cross-validated (`leave_one_out`).
        train: what to learn from instead.
        train_objects: learn only from demonstrations that show all of these objects; none means from all.
        robot: name or description file of a robot, or ``flying_hands``: none.
        constraints: constraint types.
        modes: how to learn: ``default``, ``paper``.
        solvers: how to solve: ``default``, ``paper`` (about a minute a fold; not with flying hands, whose solution
            is that of ``default``).
        prune: least relative precision of pairs that are kept; None keeps all.
        seed: of the built-in demonstrations.
        library: models of the objects; by default the built-in ones.
        jobs: processes; -1 for one per core.
        cache: folder for finished folds; None keeps none. See `evaluate_folds`.
        cluster: address of a Dask scheduler.
        progress: called with the number of finished folds and of all.

    Raises:
        SbamError: if recordings, robot, constraint type, mode or cluster cannot be used.
    """
    if robot == FLYING_HANDS and "paper" in solvers:
        raise SettingsError("solver", "paper", f"'default' with {FLYING_HANDS}: the paper's needs arms")
    conditions = [
        Condition(f"{mode}/{solver}", constraint, LearningSettings.for_mode(mode), _planning(solver, prune), robot)
        for mode in modes
        for solver in solvers
        for constraint in map(_known_constraint, constraints)
    ]
    tests = recordings_for(recordings, seed)
    folds = train_and_test(recordings_for(train, seed), tests) if train else leave_one_out(tests)
    if train_objects:
        folds = learning_only_from(folds, train_objects)
    return evaluate_folds(conditions, folds, library, jobs, cache, cluster, progress)


def recordings_for(sources: Sequence[str | Path], seed: int = 0) -> list[Demonstration]:
    """Demonstrations of tasks or from anything that `sbam.load` takes; whole built-in tasks with the given seed."""
    found: list[Demonstration] = []
    rest: list[str | Path] = []
    for source in sources:
        task = str(source).removeprefix(BUILT_IN)
        known: BuiltInTask | None = next((name for name in BUILT_IN_TASKS if name == task), None)
        if known and (str(source) != task or not Path(source).exists()):
            found += built_in_demonstrations(known, seed)
        else:
            rest.append(source)
    return found + (load(rest) if rest else [])


def evaluation_report(results: Sequence[FoldResult], tables: Sequence[Table]) -> dict[str, Any]:
    """All of an evaluation as plain numbers and words; keys: docs, "Reports"."""
    return {
        "report": "evaluation",
        "report_version": 1,
        "synthetic": results[0].synthetic,
        "synthetic_training": results[0].synthetic_training,
        "robot": results[0].robot,
        "tables": [
            {"name": t.name, "caption": t.caption, "columns": list(t.columns), "rows": [list(row) for row in t.rows]}
            for t in tables
        ],
        "folds": plain([msgspec.to_builtins(result) for result in results]),
    }


def run_evaluation(recordings: Sequence[str | Path], output: Path | None = None, **options: Any) -> dict[str, Any]:
    """`evaluate` and its report; its tables are written into a folder if one is given.

    Args:
        recordings: as for `evaluate`.
        output: folder for the tables as Markdown, CSV and LaTeX.
        **options: those of `evaluate`.

    Returns:
        The report, with ``ok`` if there was any execution.
    """
    begin = time.perf_counter()
    results = evaluate(recordings, **options)
    tables = evaluation_tables(results)
    executed = any(result.executed for result in results)
    report = {
        "ok": executed,
        "problems": [] if executed else list(dict.fromkeys(p for result in results for p in result.problems)),
        "seconds": {"total": time.perf_counter() - begin},
        **evaluation_report(results, tables),
    }
    if output is not None:
        report["files"] = [str(path) for path in write_tables(tables, output)]
    return report


def default_cache() -> Path:
    """Where finished folds are kept: ``sbam/folds`` in the user's cache folder (XDG_CACHE_HOME)."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "sbam" / "folds"


def _known_constraint(name: str) -> str:
    constraint_type(name)
    return name


def _planning(solver: str, prune: float | None) -> PlanSettings:
    return PlanSettings(solver="paper" if solver == "paper" else "default", prune=prune)
