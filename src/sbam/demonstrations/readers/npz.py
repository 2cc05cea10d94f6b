"""Reader of SBAM's own NPZ: NumPy arrays without pickled objects.

Arrays of format version 1 (T frames, N objects, H hands):

| key | shape | content |
|---|---|---|
| ``format_version`` | () | integer, 1 |
| ``time`` | (T,) | s, strictly increasing |
| ``object_names`` | (N,) | text |
| ``position`` | (T, N, 3) | m, world, z up |
| ``rotation_xyzw`` | (T, N, 4) | unit quaternions, scalar last |
| ``hand_names`` | (H,) | ``left``, ``right``; optional, as the next two |
| ``hand_position`` | (T, H, 3) | m, world |
| ``hand_rotation_xyzw`` | (T, H, 4) | unit quaternions, scalar last |
| ``T_world_agent`` | (4, 4) | homogeneous matrix; optional |
| ``meta`` | () | JSON text; optional: ``name``, ``source``, ``synthetic``, ``notes``, ``labels`` |

NaN marks a pose that was not seen. A label is ``{"hand", "start", "end", "action", "target"}``, times in s.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand, Label
from sbam.demonstrations.readers.checks import check_time, unit_quaternions
from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.demonstrations.recording import Recording, Track
from sbam.errors import FileFormatError, FileVersionError

FORMAT_VERSION = 1
_UNREADABLE = (ValueError, OSError, EOFError, KeyError, NotImplementedError, zipfile.BadZipFile, zlib.error)
_REQUIRED = ("time", "object_names", "position", "rotation_xyzw")


class Meta(msgspec.Struct, forbid_unknown_fields=True):
    """What the arrays do not hold."""

    name: str = ""
    source: str = ""
    synthetic: bool = False
    notes: tuple[str, ...] = ()
    labels: tuple[Label, ...] = ()


def recognises(content: bytes) -> bool:
    """Whether it is a ZIP archive, as NPZ files are."""
    return content.startswith(b"PK\x03\x04")


def read(content: bytes, path: Path) -> Recording:
    """Read a file's content.

    Raises:
        FileFormatError: if it is not an NPZ file, or an array is missing, of wrong shape or of Python objects.
        FileVersionError: if a later version wrote it.
    """
    arrays = _load(content, path)
    version = arrays.get("format_version")
    if version is None or version.size != 1 or version.dtype.kind not in "iu":
        raise FileFormatError(path, "format_version", "is missing or no integer", f"{FORMAT_VERSION}")
    if int(version.item()) > FORMAT_VERSION:
        raise FileVersionError(path, int(version.item()), FORMAT_VERSION)
    if missing := [key for key in _REQUIRED if key not in arrays]:
        raise FileFormatError(path, missing[0], f"is missing (arrays: {', '.join(arrays)})", ", ".join(_REQUIRED))
    time = _floats(arrays, "time", (None,), path)
    check_time(time, path, "time")
    objects = _tracks(arrays, time, "object_names", "position", "rotation_xyzw", path)
    hands: dict[Hand, Track] = {}
    if "hand_names" in arrays:
        found = _tracks(arrays, time, "hand_names", "hand_position", "hand_rotation_xyzw", path)
        if unknown := set(found) - {"left", "right"}:
            raise FileFormatError(path, "hand_names", f"unknown hand {sorted(unknown)[0]!r}", "left, right")
        hands = {hand: found[hand] for hand in ("left", "right") if hand in found}
    meta = _meta(arrays, path)
    return Recording(
        name=meta.name or path.stem,
        objects=objects,
        hands=hands,
        T_world_agent=_agent(arrays, path),
        labels=meta.labels,
        synthetic=meta.synthetic,
        source=meta.source,
        notes=meta.notes,
    )


def _load(content: bytes, path: Path) -> dict[str, NDArray[np.generic]]:
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files}
    except _UNREADABLE as error:
        raise FileFormatError(path, "", f"not a readable NPZ file: {error}", "arrays saved without pickle") from error


def _floats(arrays: dict[str, NDArray[np.generic]], key: str, shape: tuple[int | None, ...], path: Path) -> NDArray:
    if key not in arrays:
        raise FileFormatError(path, key, f"is missing (arrays: {', '.join(arrays)})")
    array = arrays[key]
    fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=True))
    if not fits or array.dtype.kind not in "fiu":
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        raise FileFormatError(path, key, f"is {array.dtype} of shape {array.shape}", f"numbers of shape ({wanted})")
    return array.astype(float)


def _tracks(
    arrays: dict[str, NDArray[np.generic]], time: NDArray, names: str, position: str, rotation: str, path: Path
) -> dict[str, Track]:
    if arrays[names].ndim != 1 or arrays[names].dtype.kind != "U":
        raise FileFormatError(path, names, f"is {arrays[names].dtype}", "a list of text")
    bodies = [str(name) for name in arrays[names]]
    if len(set(bodies)) < len(bodies):
        raise FileFormatError(path, names, "a name occurs twice", "unique names")
    p = _floats(arrays, position, (len(time), len(bodies), 3), path)
    q = _floats(arrays, rotation, (len(time), len(bodies), 4), path)
    p[~np.isfinite(p)] = np.nan
    q[~np.isfinite(q)] = np.nan
    return {
        body: Track(time, p[:, k], unit_quaternions(q[:, k], path, f"{rotation}, {body!r}"))
        for k, body in enumerate(bodies)
    }


def _agent(arrays: dict[str, NDArray[np.generic]], path: Path) -> RigidTransform | None:
    if "T_world_agent" not in arrays:
        return None
    matrix = _floats(arrays, "T_world_agent", (4, 4), path)
    rotation = matrix[:3, :3]
    if not (
        np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        and np.linalg.det(rotation) > 0
        and np.isclose(rotation[2, 2], 1.0, atol=1e-6)
        and np.isfinite(matrix).all()
    ):
        raise FileFormatError(path, "T_world_agent", "is no gravity-aligned pose", "z axis up, orthonormal")
    return RigidTransform.from_components(matrix[:3, 3], Rotation.from_matrix(rotation))


def _meta(arrays: dict[str, NDArray[np.generic]], path: Path) -> Meta:
    if "meta" not in arrays:
        return Meta()
    try:
        return msgspec.json.decode(str(arrays["meta"].item()), type=Meta)
    except (msgspec.DecodeError, ValueError) as error:
        raise FileFormatError(path, "meta", str(error), "JSON text") from error


FORMAT = RecordingFormat("SBAM NPZ", ".npz", recognises, read)
