"""Writing plans for other programs: one trajectory format a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np

from sbam.errors import TrajectoryError, UnknownNameError
from sbam.export.npz import SavedTrajectory, read_trajectory_npz
from sbam.extensions import registered
from sbam.files import write_atomically
from sbam.planning.plan import Plan


@runtime_checkable
class PlanWriter(Protocol):
    """Encodes a plan in one format."""

    def __call__(self, plan: Plan, /) -> Mapping[str, bytes]:
        """File name -> content."""
        ...


TRAJECTORY_FORMATS: Mapping[str, PlanWriter] = registered("sbam.plan_writers", PlanWriter)
"""Format -> what encodes a plan in it; those that other distributions register included."""


def write_plan(
    plan: Plan, folder: str | Path, formats: Iterable[str] = ("npz", "csv"), allow_problems: bool = False
) -> list[Path]:
    """Write a plan's trajectory.

    Args:
        plan: the plan.
        folder: where to; made if needed.
        formats: of `TRAJECTORY_FORMATS`.
        allow_problems: write a trajectory that failed its checks too, which no robot should be given.

    Returns:
        The files that were written.

    Raises:
        TrajectoryError: if the plan has problems and was not allowed to, or holds numbers that are not finite.
        UnknownNameError: for an unknown format.
        ExtensionError: if another distribution registers the format and it cannot be used.
        OutputError: if a file cannot be written; nothing half-written is left behind.
    """
    encoders = []
    for name in formats:
        if name not in TRAJECTORY_FORMATS:
            raise UnknownNameError("trajectory format", name, TRAJECTORY_FORMATS)
        encoders.append(TRAJECTORY_FORMATS[name])
    if plan.problems and not allow_problems:
        raise TrajectoryError("the trajectory is not written, because it has problems: " + "; ".join(plan.problems))
    trajectory = plan.trajectory
    for name in ("time", "position", "velocity", "acceleration"):
        if not np.isfinite(getattr(trajectory, name)).all():
            raise TrajectoryError(
                f"the trajectory is not written, because its {name} holds numbers that are not finite"
            )
    contents = {file: content for encode in encoders for file, content in encode(plan).items()}
    paths = []
    for file, content in contents.items():
        path = Path(folder) / file
        write_atomically(path, content)
        paths.append(path)
    return paths


__all__ = ["TRAJECTORY_FORMATS", "PlanWriter", "SavedTrajectory", "read_trajectory_npz", "write_plan"]
