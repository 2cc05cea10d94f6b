"""Readers of recordings, one file a format; a new one is a module with ``recognises`` and ``read``, and a line here."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.assembly import to_demonstration
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.readers import kit_csv, mmm, mmm_legacy, npz
from sbam.demonstrations.recording import Recording
from sbam.errors import DemonstrationError, FileFormatError


class RecordingFormat(NamedTuple):
    """A format: its name, the suffix of its files, how to recognise it by content, and how to read it."""

    name: str
    suffix: str
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes, Path], Recording]


FORMATS: tuple[RecordingFormat, ...] = (
    RecordingFormat("MMM 2.0", ".xml", mmm.recognises, mmm.read),
    RecordingFormat("legacy MMM", ".xml", mmm_legacy.recognises, mmm_legacy.read),
    RecordingFormat("KIT CSV", ".csv", kit_csv.recognises, kit_csv.read),
    RecordingFormat("SBAM NPZ", ".npz", npz.recognises, npz.read),
)
"""All formats, in the order in which they are tried: by content, then by suffix."""

SUFFIXES: tuple[str, ...] = tuple(dict.fromkeys(known.suffix for known in FORMATS))


def read_demonstration(path: str | Path, T_world_agent: RigidTransform | None = None) -> Demonstration:
    """Read a recording of any known format; damaged frames are mended or refused, see `sbam.demonstrations.repair`.

    Args:
        path: the file.
        T_world_agent: the agent frame, if the recording's own (or the default, see the notes) is not wanted.

    Returns:
        The demonstration; what was found and mended is in its ``notes``.

    Raises:
        FileFormatError: if the file cannot be read; says where and what was expected.
        FileVersionError: if a later version of SBAM wrote it.
        DemonstrationError: if it can be read, but not be learned from.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileFormatError(path, "", f"cannot be read: {error.strerror or error}", "a recording") from error
    if not content.strip():
        raise FileFormatError(path, "", "is empty", "a recording")
    recording = _format_of(content, path).read(content, path)
    if T_world_agent is not None:
        recording = replace(recording, T_world_agent=T_world_agent)
    return to_demonstration(recording, path)


def read_demonstrations(paths: str | Path | Iterable[str | Path]) -> list[Demonstration]:
    """Read recordings: files, and folders with all recordings directly in them (sorted by name).

    Raises:
        FileFormatError: as `read_demonstration`; also if a folder holds no recording.
        DemonstrationError: as `read_demonstration`; also if two recordings have the same name.
    """
    files: list[Path] = []
    for path in [paths] if isinstance(paths, str | Path) else list(paths):
        path = Path(path)
        files += recordings_in(path) if path.is_dir() else [path]
    demonstrations = [read_demonstration(file) for file in files]
    names: dict[str, Path] = {}
    for file, demonstration in zip(files, demonstrations, strict=True):
        if demonstration.name in names:
            raise DemonstrationError(
                demonstration.name, f"is in both {names[demonstration.name]} and {file}", "rename one of the files"
            )
        names[demonstration.name] = file
    return demonstrations


def recordings_in(folder: Path) -> list[Path]:
    """Files directly in a folder that are recordings by their suffix, sorted; raises `FileFormatError` without any."""
    found = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES and file.is_file())
    if not found:
        raise FileFormatError(folder, "", "folder without recordings", f"files named *{', *'.join(SUFFIXES)}")
    return found


def _format_of(content: bytes, path: Path) -> RecordingFormat:
    for known in FORMATS:
        if known.recognises(content):
            return known
    for known in FORMATS:
        if known.suffix == path.suffix.lower():
            return known
    valid = ", ".join(f"{known.name} (*{known.suffix})" for known in FORMATS)
    raise FileFormatError(path, "", "not a recording of a known format", valid)
