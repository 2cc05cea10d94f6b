"""How often the pin must go to and fro, and at which height."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from sbam.tasks.geometry import GeometryResult
from sbam.tasks.object_motion import ObjectMotion, region_path

PIN_HEIGHT = 0.005  # m: of the learned height
STROKE = 0.06  # m: a shorter half-stroke is not one


def measure_rolling(motion: ObjectMotion, half_strokes: int = 8, role: str = "handle_left") -> GeometryResult:
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
    return GeometryResult(not problems, values, tuple(problems))


def turning_points(middle: Float[np.ndarray, "samples 3"]) -> Int[np.ndarray, " turns"]:
    """Samples at which the pin turns, ends of half-strokes longer than `STROKE`."""
    from scipy.signal import find_peaks

    centered = middle[:, :2] - middle[:, :2].mean(axis=0)
    direction = np.linalg.svd(centered[:: max(1, len(centered) // 2000)], full_matrices=False)[2][0]
    along = centered @ direction
    peaks = np.concatenate([find_peaks(s * along, prominence=STROKE)[0] for s in (1.0, -1.0)])
    return np.sort(peaks)
