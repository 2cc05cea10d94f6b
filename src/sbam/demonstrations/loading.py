"""Loading recordings from wherever they are: files, folders, or the built-in ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import get_args

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.readers import read_demonstration, recordings_in
from sbam.demonstrations.synthetic import BuiltInTask, built_in_demonstrations
from sbam.errors import DemonstrationError, UnknownNameError

BUILT_IN = "built-in:"
"""What a source begins with that comes with SBAM."""


def load(
    sources: str | Path | Iterable[str | Path], progress: Callable[[int, int], None] | None = None
) -> list[Demonstration]:
    """Load recordings.

    Args:
        sources: one or more of: a file of any known format, a folder (all recordings directly in it, sorted by name),
            ``built-in:pouring`` or ``built-in:rolling`` (all synthetic demonstrations of the task), or
            ``built-in:NAME`` with the name of one of them.
        progress: called with the number of loaded sources and of all.

    Returns:
        The demonstrations, with unique names.

    Raises:
        FileFormatError: if a file cannot be read or a folder holds no recording.
        DemonstrationError: if a recording cannot be learned from, or two have the same name.
        UnknownNameError: if there is no such built-in demonstration.
    """
    given = [sources] if isinstance(sources, str | Path) else list(sources)
    expanded = [part for source in given for part in _expanded(source)]
    demonstrations: dict[str, tuple[str | Path, Demonstration]] = {}
    for done, source in enumerate(expanded, 1):
        loaded = _built_in(source) if isinstance(source, str) else [read_demonstration(source)]
        for demonstration in loaded:
            if demonstration.name in demonstrations:
                other = demonstrations[demonstration.name][0]
                raise DemonstrationError(
                    demonstration.name, f"is in both {other} and {source}", "give it once, or rename one of the files"
                )
            demonstrations[demonstration.name] = (source, demonstration)
        if progress is not None:
            progress(done, len(expanded))
    return [demonstration for _, demonstration in demonstrations.values()]


def as_demonstrations(
    given: Demonstration | str | Path | Iterable[Demonstration | str | Path],
) -> list[Demonstration]:
    """Demonstrations as they are, those that paths and ``built-in:`` names stand for loaded (`load`)."""
    parts = [given] if isinstance(given, Demonstration | str | Path) else list(given)
    return [one for part in parts for one in ([part] if isinstance(part, Demonstration) else load(part))]


def as_demonstration(given: Demonstration | str | Path) -> Demonstration:
    """A demonstration as it is, or the one that a path or a ``built-in:`` name stands for.

    Raises:
        DemonstrationError: if there are several.
    """
    found = as_demonstrations(given)
    if len(found) > 1:
        names = ", ".join(one.name for one in found)
        raise DemonstrationError(str(given), "are several recordings, but one is needed", f"choose one of {names}")
    return found[0]


def _expanded(source: str | Path) -> list[str | Path]:
    """Files of a folder; anything else is itself, as text only if it is built in."""
    if str(source).startswith(BUILT_IN):
        return [str(source)]
    path = Path(source)
    return list(recordings_in(path)) if path.is_dir() else [path]


def _built_in(source: str) -> list[Demonstration]:
    """All demonstrations of a built-in task, or the one with that name."""
    wanted = source.removeprefix(BUILT_IN)
    tasks: tuple[BuiltInTask, ...] = get_args(BuiltInTask)
    for task in tasks:
        if wanted == task:
            return list(built_in_demonstrations(task))
    by_name = {one.name: one for task in tasks if task in wanted for one in built_in_demonstrations(task)}
    if wanted not in by_name:
        raise UnknownNameError("built-in demonstration", wanted, (*tasks, *by_name), source)
    return [by_name[wanted]]
