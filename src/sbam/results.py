"""Everything there is to hand on of a plan, in one folder: trajectory, report, recording to look at."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from sbam.errors import OutputError
from sbam.planning.plan import Plan

FORMATS = ("npz", "csv")


def write_results(
    plan: Plan,
    folder: str | Path,
    formats: Iterable[str] = FORMATS,
    plots: bool = False,
    further: Iterable[Callable[[Path], object]] = (),
    progress: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write a plan's trajectory, its report, its scene, a self-contained recording and plots; all of them, or nothing.

    Args:
        plan: the plan, whether it is ok or not.
        folder: where to; made if needed. Other files in it stay.
        formats: of the trajectory, see `sbam.export.TRAJECTORY_FORMATS`.
        plots: whether to draw the plan's figures into the folder ``plots``.
        further: functions that write more into a folder that they are given.
        progress: called with the name of each stage as it begins.

    Returns:
        The files that were written.

    Raises:
        OutputError: if a file cannot be written; then none is.
    """
    import json

    from sbam.export import write_plan
    from sbam.planning.report import plan_report
    from sbam.scene import save_scene
    from sbam.viewer.recording import write_recording

    def say(stage: str) -> None:
        if progress:
            progress(stage)

    def write(draft: Path) -> None:
        say("trajectory")
        write_plan(plan, draft, formats, allow_problems=True)
        save_scene(plan.task.scene, draft / "scene.yaml")
        (draft / "report.json").write_text(json.dumps(plan_report(plan), indent=1) + "\n", encoding="utf-8")
        say("recording")
        write_recording(plan, draft / "recording.html")
        if plots:
            from sbam.plots import write_plan_plots

            say("plots")
            write_plan_plots(plan, draft / "plots")
        for one in further:
            one(draft)

    return write_folder(Path(folder), write)


def write_folder(folder: Path, write: Callable[[Path], object]) -> list[Path]:
    """Let ``write`` fill a draft beside ``folder``, then move its files there; if it fails, nothing is left behind.

    Returns:
        The files, sorted, where they are in the end.
    """
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    draft: Path | None = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(dir=folder, prefix=".draft."))
        write(draft)
        files = sorted(path.relative_to(draft) for path in draft.rglob("*") if path.is_file())
        for file in files:
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            os.replace(draft / file, folder / file)
        missing.clear()
        return [folder / file for file in files]
    except OutputError as error:
        raise OutputError(folder, error.problem) from error
    except OSError as error:
        raise OutputError(folder, error.strerror or str(error)) from error
    finally:
        if draft is not None:
            shutil.rmtree(draft, ignore_errors=True)
        for parent in missing:
            with suppress(OSError):  # what is not empty or was never made
                parent.rmdir()
