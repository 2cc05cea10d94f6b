"""Measures of the two faults that the paper reports of its executions (section IV-C).

An abrupt move at the end, where deviations are large and nothing holds the objects to a path; and a carton that is
tilted while its spout is not over the cup.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from sbam.planning.motion.object_path import acting_point
from sbam.tasks.object_motion import ObjectMotion
from sbam.tasks.pouring.geometry import mouth_of_motion, rim_radius

END = 0.2
"""Share of the time from the first lift to the last place that counts as the end, and all that follows."""


def measure_faults(
    motion: ObjectMotion, pour_from: str = "pour_from", pour_into: str = "pour_into"
) -> dict[str, float]:
    """The two faults, at the speed of the demonstrations: how far a robot's limits stretch time does not count.

    Args:
        motion: a plan, or another motion of the objects.
        pour_from: role of what is poured from; without it in the task only speeds are measured.
        pour_into: role of what is poured into.

    Returns:
        Name with unit -> value: ``largest speed at the end [mm/s]`` of any object's acting region in the last fifth of
        the time from the first lift to the last place, and after it; ``largest speed before [mm/s]``; ``tilted beside
        the cup for [s]``: beyond 60 degrees with the mouth farther aside than the rim of the cup.
    """
    task, clock = motion.task, motion.model_time
    lift, place = min(moved.lift for moved in task.moved), max(moved.place for moved in task.moved)
    begin = place - END * (place - lift)
    at_end, before = [0.0], [0.0]
    for moved in task.moved:
        speed, when = _speed(clock, motion.T_agent_object[moved.name].apply(acting_point(task, moved)))
        at_end.append(float(speed[when >= begin].max(initial=0.0)))
        before.append(float(speed[when < begin].max(initial=0.0)))
    values = {"largest speed at the end [mm/s]": 1e3 * max(at_end), "largest speed before [mm/s]": 1e3 * max(before)}
    if {pour_from, pour_into} <= set(task.binding):
        mouth = mouth_of_motion(motion, pour_from, pour_into)
        beside = mouth.aside > rim_radius(task.scene.objects[task.binding[pour_into]])
        values["tilted beside the cup for [s]"] = float((np.gradient(clock) * (mouth.may_flow & beside)).sum())
    return values


def _speed(
    clock: Float[np.ndarray, " samples"], path: Float[np.ndarray, "samples 3"]
) -> tuple[Float[np.ndarray, " steps"], Float[np.ndarray, " steps"]]:
    """Speeds between samples of a path, m/s, and when they occur, s."""
    step = np.diff(clock)
    moving = step > 1e-9
    speed = np.linalg.norm(np.diff(path, axis=0)[moving], axis=1) / step[moving]
    return speed, 0.5 * (clock[1:] + clock[:-1])[moving]
