"""Reader of KIT CSV: one row a frame, ``timestep`` and seven columns a body; positions in mm, quaternions named.

Columns of a body: ``name[x],name[y],name[z],name[qw],name[qx],name[qy],name[qz]``, in any order. Bodies named
``left_hand`` and ``right_hand`` are the hands; ``agent``, which must stand still, is the agent frame. Other columns are
labels and ignored, except for the three that the project's writer adds: ``synthetic`` (1 or 0),
``left_hand_label`` and ``right_hand_label`` (``action`` or ``action:target`` at each frame).
"""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand, Label
from sbam.demonstrations.readers.checks import check_time, unit_quaternions
from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.demonstrations.recording import Recording, Track
from sbam.errors import FileFormatError

Array = NDArray[np.float64]

AXES = ("x", "y", "z", "qw", "qx", "qy", "qz")
HANDS: dict[str, Hand] = {"left_hand": "left", "right_hand": "right"}
AGENT = "agent"
TIME = "timestep"
SYNTHETIC = "synthetic"
LABELS: dict[str, Hand] = {"left_hand_label": "left", "right_hand_label": "right"}
_COLUMN = re.compile(r"(?P<body>.+)\[(?P<axis>[a-z]+)\]")
_MISSING = ("", "nan", "NaN", "NAN")


def recognises(content: bytes) -> bool:
    """Whether the first line is a header of pose columns."""
    header = content[:65536].partition(b"\n")[0]
    return b"[qw]" in header or (b"," in header and header.lstrip(b"\xef\xbb\xbf").strip().startswith(TIME.encode()))


def read(content: bytes, path: Path) -> Recording:
    """Read a file's content.

    Raises:
        FileFormatError: if a column is missing, a value is no number, a quaternion is not of unit length, or time
            stamps do not increase.
    """
    try:
        rows = list(csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileFormatError(path, "", f"not readable as CSV: {error}", "comma-separated text in UTF-8") from error
    header = [column.strip() for column in rows[0]] if rows else []
    rows = [row for row in rows[1:] if any(cell.strip() for cell in row)]
    bodies = _bodies(header, path)
    if not rows:
        raise FileFormatError(path, "", "has a header but no frame", "one row a frame")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise FileFormatError(path, f"line {line}", f"{len(row)} values", f"{len(header)}, as the header has")
    cells = {name: [row[k].strip() for row in rows] for k, name in enumerate(header)}
    time = _numbers(cells[TIME], TIME, path)
    check_time(time, path, TIME)
    tracks = {body: _track(body, cells, time, path) for body in bodies}
    objects = {body: track for body, track in tracks.items() if body not in HANDS and body != AGENT}
    if not objects:
        raise FileFormatError(path, "", f"no object (bodies: {', '.join(bodies) or 'none'})", "columns of an object")
    used = {TIME, SYNTHETIC, *LABELS}
    ignored = [column for column in header if column not in used and not _COLUMN.fullmatch(column)]
    return Recording(
        name=path.stem,
        objects=objects,
        hands={HANDS[body]: track for body, track in tracks.items() if body in HANDS},
        T_world_agent=_agent(tracks.get(AGENT), path),
        labels=tuple(label for column, hand in LABELS.items() for label in _labels(hand, cells.get(column), time)),
        synthetic="1" in cells.get(SYNTHETIC, []),
        notes=(f"ignored columns: {', '.join(ignored)}",) if ignored else (),
    )


def _bodies(header: list[str], path: Path) -> list[str]:
    """Bodies in the order of the file, each with all its columns."""
    present = ", ".join(header) or "none"
    if TIME not in header:
        raise FileFormatError(path, "line 1", f"column {TIME!r} is missing (columns: {present})", "time in s")
    if len(set(header)) < len(header):
        twice = next(column for column in header if header.count(column) > 1)
        raise FileFormatError(path, "line 1", f"column {twice!r} occurs twice", "unique columns")
    found = [match for column in header if (match := _COLUMN.fullmatch(column))]
    bodies = list(dict.fromkeys(match["body"] for match in found if match["axis"] in AXES))
    for body in bodies:
        if missing := [f"{body}[{axis}]" for axis in AXES if f"{body}[{axis}]" not in header]:
            names = ", ".join(missing)
            raise FileFormatError(path, "line 1", f"missing {names} (columns: {present})", "all seven of a body")
    return bodies


def _numbers(cells: list[str], column: str, path: Path) -> Array:
    """Cells as numbers; NaN where empty."""
    try:
        return np.array([float("nan") if cell in _MISSING else float(cell) for cell in cells])
    except ValueError:
        for k, cell in enumerate(cells):
            try:
                float(cell or "nan")
            except ValueError:
                raise FileFormatError(path, f"line {k + 2}, column {column!r}", f"{cell!r}", "a number") from None
        raise


def _track(body: str, cells: dict[str, list[str]], time: Array, path: Path) -> Track:
    values = np.stack([_numbers(cells[f"{body}[{axis}]"], f"{body}[{axis}]", path) for axis in AXES], axis=-1)
    values[~np.isfinite(values)] = np.nan
    xyzw = unit_quaternions(values[:, [4, 5, 6, 3]], path, f"body {body!r}")
    return Track(time, values[:, :3] * 1e-3, xyzw)


def _agent(track: Track | None, path: Path) -> RigidTransform | None:
    if track is None:
        return None
    if not track.seen.all() or np.ptp(track.position, axis=0).max() > 1e-6:
        raise FileFormatError(path, f"body {AGENT!r}", "does not stand still", "one pose of the agent frame throughout")
    return track.poses[0]


def _labels(hand: Hand, cells: list[str] | None, time: Array) -> list[Label]:
    """One label for each run of equal cells that are not empty; it ends where the next begins."""
    if cells is None:
        return []
    starts = [k for k in range(len(cells)) if k == 0 or cells[k] != cells[k - 1]]
    labels = []
    for start, end in zip(starts, [*starts[1:], len(cells) - 1], strict=True):
        action, _, target = cells[start].partition(":")
        if action:
            labels.append(Label(hand, float(time[start]), float(time[end]), action, target))
    return labels


FORMAT = RecordingFormat("KIT CSV", ".csv", recognises, read)
