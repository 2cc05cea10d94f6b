"""Success of a task's geometry, measured on every sample of a motion; what all tasks share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sbam.tasks.object_motion import ObjectMotion, region_path

PUT_DOWN = 0.030  # m: of the place where the demonstrations put it, relative to its start


@dataclass(frozen=True)
class GeometryResult:
    """How well a motion of the objects does a task.

    Attributes:
        ok: whether everything required holds.
        values: name with unit -> value.
        problems: what does not hold, a sentence each.
    """

    ok: bool
    values: Mapping[str, float]
    problems: tuple[str, ...]


def measure_put_down(motion: ObjectMotion) -> GeometryResult:
    """Each object ends within 30 mm of where the demonstrations put it relative to its start."""
    values, problems = {}, []
    for moved in motion.task.moved:
        changes = [c for c in motion.task.model.changes if c.pair.is_own_start and c.pair.first.role == moved.role]
        for change in changes:
            path = region_path(motion, moved.role, change.pair.first.affordance)
            wanted = change.at(np.array([motion.task.model.duration]))[0][0]
            off = float(np.linalg.norm(path[-1] - path[0] - wanted))
            values[f"{change.pair.first} put down off by [mm]"] = 1e3 * off
            if off > PUT_DOWN:
                problems.append(f"{change.pair.first} is put down {1e3 * off:.0f} mm from where it was demonstrated")
    return GeometryResult(not problems, values, tuple(problems))
