"""The job of ``sbam simulate``: a plan's folder, the demonstrations to compare with, a report and a video."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.loading import BUILT_IN, load
from sbam.demonstrations.synthetic import BUILT_IN_TASKS
from sbam.errors import RenderingError
from sbam.scene import ObjectLibrary
from sbam.simulation.arms import FINGER_FORCE
from sbam.simulation.holding import GraspKind, check_grasp
from sbam.simulation.plan_folder import read_plan_folder
from sbam.simulation.report import simulation_report
from sbam.simulation.simulate import Progress, comparable, simulate
from sbam.tasks.registry import find_task

MOST_DEMONSTRATIONS = 3


def simulate_folder(
    folder: str | Path,
    task: str | None = None,
    demonstrations: Sequence[str] = (),
    video: str | Path | None = None,
    library: ObjectLibrary | None = None,
    progress: Progress | None = None,
    grasp: GraspKind = "weld",
    grasp_force: float = FINGER_FORCE,
) -> dict[str, Any]:
    """Try a plan that was written into a folder, and report.

    Args:
        folder: what `sbam plan -o` wrote.
        task: how to judge it; by default what fits the objects.
        demonstrations: recordings to compare with; by default the built-in ones of the task, if there are any.
        video: where to write a film (``.mp4``), or a picture of moments (``.png``).
        library: object models.
        progress: called with the simulated time and all of it, s.
        grasp: how hands hold.
        grasp_force: of each finger in contact, N.

    Returns:
        The report; without OpenGL it says so and there is no film.
    """
    action = read_plan_folder(folder, library)
    check_grasp(action, grasp)
    chosen = find_task(action, task)
    recordings = list(demonstrations) or [BUILT_IN + chosen.name] * (chosen.name in BUILT_IN_TASKS)
    compared = spread(comparable(load(recordings), action) if recordings else [], MOST_DEMONSTRATIONS)
    result = simulate(
        action, chosen, compared, library=library, progress=progress, grasp=grasp, grasp_force=grasp_force
    )
    report = {**simulation_report(result), "files": []}
    if video is not None:
        from sbam.simulation.film import write_film

        try:
            write_film(result, video)
            report["files"].append(str(video))
        except RenderingError as error:
            report["warnings"].append(str(error))
    return report


def spread(demonstrations: Sequence[Demonstration], most: int) -> list[Demonstration]:
    """At most so many, taken evenly."""
    if len(demonstrations) <= most:
        return list(demonstrations)
    return [demonstrations[round(i * (len(demonstrations) - 1) / (most - 1))] for i in range(most)]
