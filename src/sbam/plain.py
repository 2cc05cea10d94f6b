"""Poses and arrays as plain data for reports: what JSON can say, and what notebooks show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform


def pose_dict(T: RigidTransform) -> dict[str, Any]:
    """A pose as ``position`` [x, y, z] in m and ``quaternion_wxyz`` (scalar first, w >= 0)."""
    return {
        "position": T.translation.tolist(),
        "quaternion_wxyz": T.rotation.as_quat(canonical=True, scalar_first=True).tolist(),
    }


def plain(value: Any) -> Any:
    """The same of JSON's own types: numpy's become Python's, numbers that are not finite become None."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, Sequence | set | frozenset):
        return [plain(item) for item in value]
    raise TypeError(f"{type(value).__name__} has no place in a report")


def html_summary(title: str, rows: Mapping[str, object]) -> str:
    """A small table for notebooks: a title, and a row for each name and value."""
    body = "".join(
        f"<tr><th style='text-align:left'>{escape(k)}</th><td>{escape(str(v))}</td></tr>" for k, v in rows.items()
    )
    return f"<table><caption>{escape(title)}</caption>{body}</table>"
