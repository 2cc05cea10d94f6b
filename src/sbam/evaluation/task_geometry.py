"""Success of a task's geometry, measured on every sample of a plan's trajectory or of another motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.constraints import RegionReference
from sbam.evaluation.executed_motion import ObjectMotion, region_points, roles_poses, sample_times

Array = NDArray[np.float64]

POUR_TILT = np.deg2rad(60.0)  # rad: beyond it something may flow
POUR_HEIGHT = (0.010, 0.080)  # m: of the mouth above the rim while something may flow
PUT_DOWN = 0.030  # m: of the place where the demonstrations put it, relative to its start
PIN_HEIGHT = 0.005  # m: of the learned height
STROKE = 0.06  # m: a shorter half-stroke is not one


@dataclass(frozen=True)
class Measure:
    """How well a task was done.

    Attributes:
        ok: whether everything required holds.
        values: name with unit -> value.
        problems: what does not hold, a sentence each.
    """

    ok: bool
    values: Mapping[str, float]
    problems: tuple[str, ...]


def region_path(motion: ObjectMotion, role: str, affordance: str) -> Array:
    """(N, 3) centre of a role's region at every sample, agent frame, m."""
    return region_points(motion.task, roles_poses(motion), RegionReference(role, affordance), len(motion.model_time))


def measure_pouring(motion: ObjectMotion, pour_from: str = "pour_from", pour_into: str = "pour_into") -> Measure:
    """Whenever the bottle is tilted beyond 60 degrees its mouth is over the cup and 10-80 mm above the rim.

    Args:
        motion: a plan, or another motion of the objects.
        pour_from: role of what is poured from.
        pour_into: role of what is poured into.
    """
    bottle_name = motion.task.binding[pour_from]
    bottle = motion.task.scene.objects[bottle_name]
    cup = motion.task.scene.objects[motion.task.binding[pour_into]]
    up = motion.T_agent_object[bottle_name].rotation.apply(bottle.up)
    tilt = np.arccos(np.clip(up[:, 2], -1.0, 1.0))
    offset = region_path(motion, pour_from, "pour from") - region_path(motion, pour_into, "pour into")
    aside, above = np.hypot(offset[:, 0], offset[:, 1]), offset[:, 2]
    pouring = tilt > POUR_TILT
    rim = float(cup.region("pour into").half_axes.min())
    values = {"largest tilt [deg]": float(np.rad2deg(tilt.max()))}
    problems = []
    if not pouring.any():
        problems.append(f"never tilted beyond 60 degrees (at most {values['largest tilt [deg]']:.0f})")
    else:
        step = float(np.diff(sample_times(motion)[:2])[0])
        values["tilted for [s]"] = float(pouring.sum() * step)
        values["tilted beside the cup for [s]"] = float((pouring & (aside > rim)).sum() * step)
        values["mouth aside, worst [mm]"] = float(1e3 * aside[pouring].max())
        values["mouth above, least [mm]"] = float(1e3 * above[pouring].min())
        values["mouth above, most [mm]"] = float(1e3 * above[pouring].max())
        if aside[pouring].max() > rim:
            problems.append(f"mouth {1e3 * aside[pouring].max():.0f} mm aside while tilted (rim {1e3 * rim:.0f} mm)")
        if above[pouring].min() < POUR_HEIGHT[0] or above[pouring].max() > POUR_HEIGHT[1]:
            low, high = values["mouth above, least [mm]"], values["mouth above, most [mm]"]
            problems.append(f"mouth {low:.0f} to {high:.0f} mm above the rim while tilted")
    return Measure(not problems, values, tuple(problems))


def measure_put_down(motion: ObjectMotion) -> Measure:
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
    return Measure(not problems, values, tuple(problems))


def measure_rolling(motion: ObjectMotion, half_strokes: int = 8, role: str = "handle_left") -> Measure:
    """All strokes are done, the pin's axis within 5 mm of its learned height, if there is one, while it rolls.

    A half-stroke is a run of the pin's middle between two turning points along the direction in which it moves most.
    Five strokes have eight of them: the first and the last run into the pick-up and the put-down.

    Args:
        motion: a plan, or another motion of the objects.
        half_strokes: how many are demanded.
        role: role of the rolling pin.
    """
    left, right = (region_path(motion, role, f"handle {side}") for side in ("left", "right"))
    middle = 0.5 * (left + right)
    learned = [
        path[0, 2] + change.at(motion.model_time)[0][:, 2]
        for path, side in ((left, "left"), (right, "right"))
        for change in motion.task.model.changes
        if change.pair.is_own_start and change.pair.first.affordance == f"handle {side}"
    ]
    turns = turning_points(middle)
    found = max(len(turns) - 1, 0)
    values: dict[str, float] = {"half-strokes": float(found)}
    problems = []
    if found < half_strokes:
        problems.append(f"{found} half-strokes instead of {half_strokes}")
    if len(turns) > 1:
        lengths = np.linalg.norm(np.diff(middle[turns, :2], axis=0), axis=1)
        values["half-stroke, mean [mm]"] = float(1e3 * lengths.mean())
    if len(turns) > 1 and learned:
        rolling = slice(turns[0], turns[-1] + 1)
        off = np.abs(middle[:, 2] - np.mean(learned, axis=0))[rolling]
        values["height off, worst [mm]"] = float(1e3 * off.max())
        if off.max() > PIN_HEIGHT:
            problems.append(f"pin {1e3 * off.max():.1f} mm from its learned height")
    return Measure(not problems, values, tuple(problems))


def turning_points(middle: Array) -> NDArray[np.int_]:
    """Samples at which the pin turns, ends of half-strokes longer than `STROKE`."""
    from scipy.signal import find_peaks

    centered = middle[:, :2] - middle[:, :2].mean(axis=0)
    direction = np.linalg.svd(centered[:: max(1, len(centered) // 2000)], full_matrices=False)[2][0]
    along = centered @ direction
    peaks = np.concatenate([find_peaks(s * along, prominence=STROKE)[0] for s in (1.0, -1.0)])
    return np.sort(peaks)
