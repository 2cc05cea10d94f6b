"""Writers of demonstrations, one file a format; a new one is a module with ``encode`` and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
