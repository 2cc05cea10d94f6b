"""Writers of demonstrations, one file a format; each registers a `RecordingWriter` in the group ``sbam.writers``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.writers.recording_writer import RecordingWriter
from sbam.errors import ExtensionError, UnknownNameError
from sbam.extensions import registered
from sbam.files import write_atomically

WRITERS: Mapping[str, RecordingWriter] = registered("sbam.writers", RecordingWriter)
"""Name of a format -> its writer."""


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
        file_format: one of `WRITERS`.
        progress: called with the number of written files and of all.

    Returns:
        The files.

    Raises:
        UnknownNameError: if there is no such format.
        ExtensionError: if another distribution registers it and it cannot be used.
        OutputError: as `write_demonstration`; the files before it stay.
    """
    if file_format not in WRITERS:
        raise UnknownNameError("recording format", file_format, WRITERS)
    writer = WRITERS[file_format]
    paths = [Path(folder) / f"{one.name}{writer.suffix}" for one in demonstrations]
    for done, (demonstration, path) in enumerate(zip(demonstrations, paths, strict=True), 1):
        write_atomically(path, writer.encode(demonstration))
        if progress is not None:
            progress(done, len(paths))
    return paths


def write_demonstration(demonstration: Demonstration, path: str | Path) -> None:
    """Write a demonstration in the format that the suffix names: ``.xml`` (MMM 2.0), ``.npz`` or ``.csv`` (KIT CSV).

    Other suffixes are those of writers that other distributions register.

    `sbam.demonstrations.read_demonstration` gives it back: from MMM and NPZ all of it, to better than 1e-9 m and rad;
    from CSV without source and notes and with labels cut to frames.

    Raises:
        UnknownNameError: if the suffix names no format.
        OutputError: if the file cannot be written; nothing half-written is left behind.
    """
    path = Path(path)
    writers = _by_suffix()
    if path.suffix.lower() not in writers:
        raise UnknownNameError("recording format", path.suffix, writers, str(path))
    write_atomically(path, writers[path.suffix.lower()].encode(demonstration))


def _by_suffix() -> dict[str, RecordingWriter]:
    """Suffix -> the first writer that can be used and has it."""
    writers: dict[str, RecordingWriter] = {}
    for name in WRITERS:
        with suppress(ExtensionError):
            writers.setdefault(WRITERS[name].suffix, WRITERS[name])
    return writers
