"""Readers of recordings, one file a format; each registers a `RecordingFormat` in the group ``sbam.readers``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.assembly import to_demonstration
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.errors import DemonstrationError, ExtensionError, FileFormatError
from sbam.extensions import registered

FORMATS: Mapping[str, RecordingFormat] = registered("sbam.readers", RecordingFormat)
"""All formats by name, in the order in which they are tried: by content, then by suffix."""


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
    broken: dict[str, ExtensionError] = {}
    suffixes = tuple(dict.fromkeys(known.suffix for known in _usable(broken)))
    found = sorted(file for file in folder.iterdir() if file.suffix.lower() in suffixes and file.is_file())
    if not found and broken:
        raise next(iter(broken.values()))
    if not found:
        raise FileFormatError(folder, "", "folder without recordings", f"files named *{', *'.join(suffixes)}")
    return found


def _usable(broken: dict[str, ExtensionError]) -> Iterator[RecordingFormat]:
    """The formats that can be used; why others cannot is put into ``broken``."""
    for name in FORMATS:
        try:
            yield FORMATS[name]
        except ExtensionError as error:
            broken[name] = error


def _format_of(content: bytes, path: Path) -> RecordingFormat:
    broken: dict[str, ExtensionError] = {}
    usable = list(_usable(broken))
    recognised = [known for known in usable if known.recognises(content)]
    named = [known for known in usable if known.suffix == path.suffix.lower()]
    # Content decides, and the suffix between those that take it for theirs, as any archive may look alike.
    for known in (*(known for known in recognised if known in named), *recognised, *named):
        return known
    if broken:  # it may have been for one of these
        raise next(iter(broken.values()))
    valid = ", ".join(f"{known.name} (*{known.suffix})" for known in FORMATS.values())
    raise FileFormatError(path, "", "not a recording of a known format", valid)
