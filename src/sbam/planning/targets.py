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

    Things may be placed anywhere on a support: its ellipse is a tolerance, its centre is arbitrary. If the reference
    point slides all the way, the pair starts as in the mean demonstration and the object is moved relative to where it
    was; if not at all, it is brought to the place where people brought it. The share between is what the demonstrations
    tell (`start_share`), but all of it for the part of a start that lies beyond their spread.
    """
    first, second = change.pair.first, change.pair.second
    if task.model.mode == "paper" or not settings.slide_supports:
        return np.zeros(3)
    if second is None or second.role == first.role or not second.affordance.startswith("place onto"):
        return np.zeros(3)
    vector = task.region_at_start(first) - task.region_at_start(second)
    shift = constraint_type(change.constraint).vector(change.at(np.zeros(1))[0])[0] - vector
    shift[2] = 0.0
    distance = max(float(np.linalg.norm(shift)), 1e-9)
    seen = START_SPREADS * float(np.linalg.norm(vector_std(change, np.zeros(1))[0, :2]))
    shift *= max(start_share(task, change), 1.0 - seen / distance)
    reach = 2.0 * task.scene.objects[task.binding[second.role]].region(second.affordance).half_axes.max()
    return shift * min(1.0, reach / max(float(np.linalg.norm(shift)), 1e-9))


def start_share(task: Task, change: GeneralizedChange) -> float:
    """How far an object's place on a support follows its start: 0 not at all, 1 all the way.

    The slope of the regression of d(t) on d(0) over the demonstrations, (var d(t) + var d(0) - var(d(t) - d(0))) /
    (2 var d(0)) in the plane, the last variance being that of the own-start pair; mean over the keypoints while the
    object is held. 1 for models without own-start pairs, and for demonstrations that all start alike.
    """
    first = change.pair.first
    own = next((c for c in task.model.changes if c.pair.is_own_start and c.pair.first == first), None)
    at_start = float(np.square(vector_std(change, np.zeros(1))[0, :2]).sum())
    moved = next((m for m in task.moved if m.role == first.role), None)
    if own is None or moved is None or at_start < 1e-6:
        return 1.0
    times = task.model.keypoint_times
    times = times[(times > moved.lift) & (times < moved.place)]
    if not len(times):
        return 1.0
    later = np.square(vector_std(change, times)[:, :2]).sum(axis=1)
    away = np.square(vector_std(own, times)[:, :2]).sum(axis=1)
    return float(np.clip((later + at_start - away) / (2.0 * at_start), 0.0, 1.0).mean())


def vector_std(change: GeneralizedChange, times: Array) -> Array:
    """Standard deviations (K, 3) of a pair's vector, m, from those of its channels, to first order.

    The channels' variances are explained by variances of x, y and z: ``var_c = sum_i (dc/di)^2 var_i``.
    """
    from scipy.optimize import nnls

    kind = constraint_type(change.constraint)
    mean, std = change.at(times)
    slopes = np.square(kind.jacobian(kind.vector(mean)))
    return np.sqrt([nnls(slope, variance)[0] for slope, variance in zip(slopes, np.square(std), strict=True)])
