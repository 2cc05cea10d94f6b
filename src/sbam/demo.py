"""The demo, from end to end: from the built-in recordings to a trajectory in a new scene."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.learning.model import ActionModel
from sbam.learning.model_file import load_model, save_model
from sbam.learning.report import model_report
from sbam.planning.plan import plan
from sbam.planning.report import plan_report
from sbam.results import write_results
from sbam.scene import built_in_scene

SCENE = "pouring_new_layout"


def run_demo(
    folder: str | Path, constraint: str = "cartesian", progress: Callable[[str], None] | None = None
) -> dict[str, Any]:
    """Learn pouring, plan a scene that was not demonstrated, verify the trajectory and write all there is to see.

    Args:
        folder: where to; made if needed.
        constraint: type of the constraints.
        progress: called with the name of each stage as it begins.

    Returns:
        A report with ``ok``, ``problems``, ``seconds`` (stage -> wall time), ``files``, ``scene``, ``model`` and
        ``plan``. Nothing is written unless the trajectory passed every check.

    Raises:
        OutputError: if a file cannot be written; then none is.
    """
    say = progress or (lambda stage: None)
    seconds: dict[str, float] = {}

    def timed(stage: str, work: Callable[[], Any]) -> Any:
        say(stage)
        start = time.perf_counter()
        result = work()
        seconds[stage] = time.perf_counter() - start
        return result

    demonstrations = timed("demonstrate", lambda: built_in_demonstrations("pouring"))
    model = timed("learn", lambda: _read_back(learn(demonstrations, constraint, name="pouring")))
    scene = built_in_scene(SCENE)
    planned = timed("plan", lambda: plan(model, scene, progress=say))
    files: list[Path] = []
    if planned.ok:

        def further(draft: Path) -> None:
            from sbam.plots import write_model_plots

            save_model(model, draft / "model.json")
            write_model_plots(model, draft / "plots", demonstrations)

        files = timed("write", lambda: write_results(planned, folder, plots=True, further=[further], progress=say))
    return {
        "ok": planned.ok,
        "problems": list(planned.problems),
        "seconds": seconds,
        "folder": str(folder),
        "files": [str(path) for path in files],
        "demonstrations": [one.name for one in demonstrations],
        "scene": scene.name,
        "model": model_report(model),
        "plan": plan_report(planned),
    }


def _read_back(model: ActionModel) -> ActionModel:
    """The model as it is in its file, for that is what a user plans with."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.json")
        save_model(model, path)
        return load_model(path)
