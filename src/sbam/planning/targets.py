"""What the pairs shall be at the keypoints, in this scene and with these objects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.constraints import constraint_type
from sbam.learning.generalization import GeneralizedChange
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task

Array = NDArray[np.float64]


START_SPREADS = 2.0
"""A start this many standard deviations from the mean demonstrated one is still as in the demonstrations."""


def pair_target(task: Task, change: GeneralizedChange, times: Array, settings: PlanSettings) -> Array:
    """Learned mean of a pair, (K, C) in the channels' units.

    A pair within one object carries its orientation; its length is the object's own. The mean over demonstrations is
    shorter (directions differ) or of another object's size; taken as it is, the channels' different weights would turn
    that difference into a wrong angle. In mode ``default`` it is brought to the object's length (``rigid_length``).
    """
    mean = change.at(times)[0]
    second = change.pair.second
    if task.model.mode == "paper" or not settings.rigid_length or change.constraint != "cartesian":
        return mean
    if second is None or not change.pair.is_same_object:
        return mean
    length = np.linalg.norm(task.region_center(change.pair.first) - task.region_center(second))
    learned = np.linalg.norm(mean, axis=-1, keepdims=True)
    return np.where(learned > 0.1 * length, mean * length / np.maximum(learned, 1e-9), mean)


def support_slide(task: Task, change: GeneralizedChange, settings: PlanSettings) -> Array:
    """How far the reference point of a support slides in its plane, (3,) m, agent frame; zero for other pairs.

    Things may be placed anywhere on a support: its ellipse is a tolerance, its centre is arbitrary. The reference point
    is the one from which the pair starts within the spread of the demonstrations, as far as the ellipse reaches. Within
    that spread nothing slides: from starts as different as this one people went to the same place.
    """
    first, second = change.pair.first, change.pair.second
    if task.model.mode == "paper" or not settings.slide_supports:
        return np.zeros(3)
    if second is None or second.role == first.role or not second.affordance.startswith("place onto"):
        return np.zeros(3)
    vector = task.region_at_start(first) - task.region_at_start(second)
    shift = constraint_type(change.constraint).vector(change.at(np.zeros(1))[0])[0] - vector
    shift[2] = 0.0
    shift *= max(0.0, 1.0 - START_SPREADS * start_spread(change) / max(float(np.linalg.norm(shift)), 1e-9))
    reach = 2.0 * task.scene.objects[task.binding[second.role]].region(second.affordance).half_axes.max()
    return shift * min(1.0, reach / max(float(np.linalg.norm(shift)), 1e-9))


def start_spread(change: GeneralizedChange) -> float:
    """Standard deviation in the plane of a pair's vector at the start over the demonstrations, m, to first order."""
    kind = constraint_type(change.constraint)
    mean, std = change.at(np.zeros(1))
    deviations = [kind.vector(mean + step)[0] - kind.vector(mean - step)[0] for step in np.diag(std[0])]
    return 0.5 * float(np.linalg.norm(np.array(deviations)[:, :2]))
