"""Tasks by name, built-in or registered by other distributions, and from files."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path

from sbam.errors import FileFormatError, SimulationError, UnknownNameError
from sbam.extensions import registered
from sbam.tasks.action import Action
from sbam.tasks.physics_task import PhysicsTask

GROUP = "sbam.tasks"
"""Entry points of this group, in any installed distribution, are tasks: objects or classes that are `PhysicsTask`."""
TASKS: Mapping[str, PhysicsTask] = registered(GROUP, PhysicsTask)
"""Name -> task, the built-in ones and those that other distributions register; each is loaded when it is asked for."""


def find_task(action: Action, wanted: PhysicsTask | str | None = None) -> PhysicsTask:
    """The task that an action is judged by.

    Args:
        action: what will be done.
        wanted: a task, its name in `TASKS`, or a Python file that defines ``TASK``; None for the one that fits.

    Raises:
        UnknownNameError: for an unknown name.
        FileFormatError: for a file without a task.
        ExtensionError: if a task that a distribution registers cannot be loaded.
        SimulationError: if no task fits, or more than one.
    """
    if isinstance(wanted, PhysicsTask):
        return wanted
    if wanted is not None:
        return load_task(wanted) if wanted.endswith(".py") else _known(wanted)
    fitting = [task for task in TASKS.values() if task.fits(action)]
    if len(fitting) != 1:
        found = ", ".join(task.name for task in fitting) or "none"
        raise SimulationError(f"{action.name}: which task is it? fitting: {found}; known: {', '.join(TASKS)}")
    return fitting[0]


def load_task(path: str | Path) -> PhysicsTask:
    """A task of your own, from a Python file that defines ``TASK``; the file is executed.

    Raises:
        FileFormatError: if there is no such file, or it defines no task.
    """
    path = Path(path)
    spec = importlib.util.spec_from_file_location(f"sbam_task_{path.stem}", path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise FileFormatError(path, "", "is not a Python file", "a file that defines TASK, see docs/simulation.md")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except TypeError as error:  # also that of a task that leaves out `measure` or `judge`
        raise FileFormatError(path, "", f"fails: {error}", "a task with `measure` and `judge`") from error
    task = getattr(module, "TASK", None)
    if not isinstance(task, PhysicsTask):
        raise FileFormatError(path, "TASK", f"is {type(task).__name__}", "a sbam.tasks.PhysicsTask")
    return task


def _known(name: str) -> PhysicsTask:
    if name not in TASKS:
        raise UnknownNameError("task", name, TASKS, "the simulation; or give a .py file that defines TASK")
    return TASKS[name]
