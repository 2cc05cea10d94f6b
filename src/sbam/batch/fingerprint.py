"""A fingerprint of everything that a result depends on, so that finished work is found again and never mistaken."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.robots import Robot

SHARED = (
    *("errors", "extensions", "files", "plain", "schema"),
    *("batch", "constraints", "demonstrations", "learning", "planning", "robots", "scene", "tasks"),
)
"""Packages and modules whose code and data all long work depends on, beside its own package."""


def fingerprint(*values: Any) -> str:
    """Hexadecimal SHA-256 of any values made of text, numbers, arrays, poses, mappings, sequences and dataclasses.

    Raises:
        TypeError: for anything else.
    """
    digest = hashlib.sha256()
    for value in values:
        _feed(digest, value)
    return digest.hexdigest()


@cache
def code_fingerprint(package: str) -> str:
    """Fingerprint of the code and the data files that results depend on.

    Args:
        package: name of the package below ``sbam`` that makes them, such as ``evaluation``; `SHARED` counts always.
    """
    root = Path(__file__).parents[1]
    paths = [path for name in (*SHARED, package) for path in (root / f"{name}.py", *(root / name).rglob("*"))]
    files = sorted(path for path in paths if path.is_file() and path.suffix != ".pyc")
    return fingerprint([(str(path.relative_to(root)), path.read_bytes()) for path in files])


def definition_fingerprint(extension: object) -> str:
    """Fingerprint of the file that defines the class of something that another distribution may have registered."""
    return fingerprint(Path(inspect.getfile(type(extension))).read_bytes())


def robot_fingerprint(robot: Robot) -> str:
    """Fingerprint of a robot: where it stands, and its compiled model."""
    import mujoco

    buffer = np.empty(mujoco.mj_sizeModel(robot.model), dtype=np.uint8)
    mujoco.mj_saveModel(robot.model, None, buffer)
    return fingerprint(robot.T_world_base, repr(robot.description), buffer)


def _feed(digest: hashlib._Hash, value: Any) -> None:
    """Add one value with its type and length, so that different structures never look alike."""
    if value is None or isinstance(value, bool | int | float | str | np.number | np.bool_):
        content = f"{type(value).__name__}:{value!r}".encode()
    elif isinstance(value, bytes):
        content = value
    elif isinstance(value, Path):
        content = str(value).encode()
    elif isinstance(value, np.ndarray):
        content = f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    elif isinstance(value, RigidTransform):
        return _feed(digest, value.as_matrix())
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        return _feed(digest, {type(value).__name__: fields})
    elif isinstance(value, Mapping):
        return _feed(digest, [item for pair in value.items() for item in pair])
    elif isinstance(value, Iterable):
        items = list(value)
        digest.update(f"[{len(items)}".encode())
        for item in items:
            _feed(digest, item)
        return None
    else:
        raise TypeError(f"no fingerprint of {type(value).__name__}")
    digest.update(f"{len(content)}:".encode() + content)
    return None
