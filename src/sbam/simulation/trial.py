"""One trial of a sweep: plan a random scene, try the plan in physics, draw the moment at which it fails."""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.synthetic import BUILT_IN_TASKS, built_in_demonstrations
from sbam.errors import RenderingError, SbamError
from sbam.learning.learn import learn
from sbam.learning.model import ActionModel, Mode
from sbam.plain import plain
from sbam.planning.plan import Plan, plan
from sbam.planning.settings import PlanSettings
from sbam.scene import Scene
from sbam.simulation.simulate import SimulationResult, simulate
from sbam.tasks.physics_task import Values
from sbam.tasks.pouring.scenes import random_pouring_scene
from sbam.tasks.registry import TASKS
from sbam.tasks.rolling.scenes import random_rolling_scene

Row = Mapping[str, Any]
SCENES: Mapping[str, Callable[[int], Scene]] = {"pouring": random_pouring_scene, "rolling": random_rolling_scene}
AROUND = (-1.0, 0.0, 1.0)
"""Pictures of a failure: before, at and after its moment, s."""


@dataclass(frozen=True)
class Case:
    """What is tried.

    Attributes:
        task: of `BUILT_IN_TASKS`.
        robot: name or file of the robot, options included.
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
        robot = re.sub(r"[^\w.=,-]+", "_", self.robot).strip("_")
        return f"{self.task}_{robot}_{self.constraint}_{self.mode}_{self.seed:03d}"


def run_case(case: Case, yardstick: Values) -> tuple[Row, bytes | None]:
    """Plan one scene and try the plan, also one that did not pass all checks.

    Args:
        case: the trial.
        yardstick: what success is measured against.

    Returns:
        A row and a picture (PNG) of the failing moment. The row holds the case's fields; ``verified``, whether the plan
        passed all its checks; ``succeeds``, what physics says (None if there was nothing to try); ``ok``, both;
        ``stage``, where it failed; ``problems``, ``warnings`` and numbers.
    """
    scene = SCENES[case.task](case.seed)
    moved = [name for name, model in scene.objects.items() if model.movable]
    row: dict[str, Any] = {**asdict(case), "ok": False, "verified": False, "succeeds": None, "stage": "plan"}
    row |= {"values": {}, "warnings": [], "problems": []}
    row["places"] = {name: scene.T_world_object[name].translation[:2] for name in moved}
    begin = time.perf_counter()
    planned = result = None
    try:
        planned = plan(_model(case.task, case.constraint, case.mode), scene, case.robot, PlanSettings(solver=case.mode))
        row |= {"planning_s": time.perf_counter() - begin, "verified": planned.ok, "problems": list(planned.problems)}
        row["duration_s"] = planned.trajectory.duration
        result = simulate(planned, TASKS[case.task], yardstick=yardstick)
    except SbamError as error:
        row["problems"].append(str(error))
    except Exception as error:  # a fault in the code fails this trial, not the hours of a sweep
        row["problems"].append(f"{type(error).__name__}: {error}")
    if result is not None:
        row |= {"succeeds": result.ok, "ok": row["verified"] and result.ok, "physics_s": result.record.seconds}
        row["problems"] += result.problems
        row["warnings"] += result.warnings
        row["values"] = {key: value for key, value in result.values.items() if isinstance(value, float)}
        row["tracking_error"] = max(result.record.tracking_error.values(), default=0.0)
        row["torque_ratio"] = max(result.record.torque_ratio.values(), default=0.0)
    if row["verified"]:
        row["stage"] = "physics"
    picture = None
    if planned is not None and not row["ok"]:
        try:
            picture = _picture_of_result(result) if result and row["verified"] else _picture_of_plan(planned)
        except RenderingError as error:
            row["warnings"].append(str(error))
    return plain(row), picture


def demonstrations_of(task: str) -> tuple[Demonstration, ...]:
    """The built-in demonstrations that a task is learned from."""
    return built_in_demonstrations(BUILT_IN_TASKS[BUILT_IN_TASKS.index(task)])


@cache
def _model(task: str, constraint: str, mode: Mode) -> ActionModel:
    return learn(demonstrations_of(task), constraint, mode)


def _picture_of_result(result: SimulationResult) -> bytes:
    from sbam.simulation.film import frames_at, picture

    return picture(result, frames_at(result, [result.moment + offset for offset in AROUND]))


def _picture_of_plan(planned: Plan) -> bytes:
    """The first failed check that names a moment says which; else the whole action."""
    from sbam.viewer.pictures import render_plan

    named = [re.search(r"at (\d+\.\d+) s", check.where) for check in planned.checks if not check.ok]
    moment = next((float(found[1]) for found in named if found), None)
    times = None if moment is None else [moment + offset for offset in AROUND]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan.png"
        render_plan(planned, path, times)
        return path.read_bytes()
