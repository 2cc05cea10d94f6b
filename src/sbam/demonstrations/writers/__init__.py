"""Writers of demonstrations, one file a format; a new one is a module with ``encode`` and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.writers import kit_csv, mmm, npz
from sbam.errors import UnknownNameError
from sbam.files import write_atomically

WRITERS: Mapping[str, Callable[[Demonstration], bytes]] = {
    ".xml": mmm.encode,
    ".npz": npz.encode,
    ".csv": kit_csv.encode,
}
"""Suffix of the file -> encoder."""

FORMAT_SUFFIXES: Mapping[str, str] = {"mmm": ".xml", "npz": ".npz", "csv": ".csv"}
"""Short name of a format -> suffix of its files."""


def write_demonstrations(
    demonstrations: Sequence[Demonstration],
    folder: str | Path,
    file_format: str = "mmm",
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write demonstrations into a folder, each to a file with its name.

    Args:
        demonstrations: with unique names.
        folder: where to; made if needed.
        file_format: one of `FORMAT_SUFFIXES`.
        progress: called with the number of written files and of all.

    Returns:
        The files.

    Raises:
        UnknownNameError: if there is no such format.
        OutputError: as `write_demonstration`; the files before it stay.
    """
    if file_format not in FORMAT_SUFFIXES:
        raise UnknownNameError("recording format", file_format, FORMAT_SUFFIXES)
    paths = [Path(folder) / f"{one.name}{FORMAT_SUFFIXES[file_format]}" for one in demonstrations]
    for done, (demonstration, path) in enumerate(zip(demonstrations, paths, strict=True), 1):
        write_demonstration(demonstration, path)
        if progress is not None:
            progress(done, len(paths))
    return paths


def write_demonstration(demonstration: Demonstration, path: str | Path) -> None:
    """Write a demonstration in the format that the suffix names: ``.xml`` (MMM 2.0), ``.npz`` or ``.csv`` (KIT CSV).

    `sbam.demonstrations.read_demonstration` gives it back: from MMM and NPZ all of it, to better than 1e-9 m and rad;
    from CSV without source and notes and with labels cut to frames.

    Raises:
        UnknownNameError: if the suffix names no format.
        OutputError: if the file cannot be written; nothing half-written is left behind.
    """
    path = Path(path)
    encode = WRITERS.get(path.suffix.lower())
    if encode is None:
        raise UnknownNameError("recording format", path.suffix, WRITERS, str(path))
    write_atomically(path, encode(demonstration))
