"""What the pairs shall be at the keypoints, in this scene and with these objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.constraints import CARTESIAN, RegionReference
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.strokes import LEAST_STROKES
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task

START_SPREADS = 2.0
"""A start this many standard deviations from the mean demonstrated one is still as in the demonstrations."""
STROKE_SAMPLES = 200  # of the slope, from the first turning point to the last
IN_PLANE = np.array([1.0, 1.0, 0.0])


def pair_target(
    task: Task, change: GeneralizedChange, times: Float[np.ndarray, " keypoints"], settings: PlanSettings
) -> Float[np.ndarray, "keypoints channels"]:
    """What a pair shall be, in the channels' units: in mode ``paper`` its learned mean.

    In mode ``default`` it is

    - for a pair within one object, which carries its orientation, brought to the object's own length. The mean over
      demonstrations is shorter (directions differ) or of another object's size; taken as it is, the channels' different
      weights would turn that difference into a wrong angle (``rigid_length``),
    - for a pair against a support or an object's own start, the mean of demonstrations that would have started where
      the object starts here (`Placement`, ``slide_supports``).
    """
    mean = change.at(times)[0]
    first, second = change.pair.first, change.pair.second
    if task.model.mode == "paper" or change.constraint != CARTESIAN:
        return mean
    if change.pair.is_same_object and second is not None:
        return (
            _of_length(mean, task.region_center(first) - task.region_center(second)) if settings.rigid_length else mean
        )
    placement = placement_of(task, first) if settings.slide_supports else None
    if placement is None or not (change.pair.is_own_start or change.from_agent):
        return mean
    further = placement.further(times)
    return mean + (further - placement.offset if change.pair.is_own_start else further)


def _of_length(
    mean: Float[np.ndarray, "keypoints 3"], vector: Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "keypoints 3"]:
    length, learned = np.linalg.norm(vector), np.linalg.norm(mean, axis=-1, keepdims=True)
    return np.where(learned > 0.1 * length, mean * length / np.maximum(learned, 1e-9), mean)


def compared_changes(task: Task, settings: PlanSettings) -> list[GeneralizedChange]:
    """The pairs that the objective compares: all but own-start pairs of regions that have a support.

    Given the start, both say the same (`Placement`); twice it would outweigh what objects are to each other.
    """
    follows = task.model.mode == "default" and settings.slide_supports
    placed = {change.pair.first for change in task.model.changes if change.from_agent and follows}
    return [c for c in task.model.changes if not (c.pair.is_own_start and c.pair.first in placed)]


def vector_shift(task: Task, change: GeneralizedChange) -> Float[np.ndarray, " 3"]:
    """What is to be added to a pair's vector first - second, m: that of a support is measured from the agent."""
    second = change.pair.second
    return task.region_at_start(second) * IN_PLANE if second and change.from_agent else np.zeros(3)


@dataclass(frozen=True)
class Placement:
    """Where an object is on its support, given where it starts: a regression over the demonstrations.

    Where a person brings an object depends on where it stood: not at all (the pin is rolled in front of the body) to
    fully (it is set down where it came from). In the plane

        E[A(t) | A(0)] = mean A(t) + slope(t) (A(0) - mean A(0)),  slope(t) = cov(A(t), A(0)) / var A(0)

    where the covariance follows from three learned spreads: 2 cov = var A(t) + var A(0) - var(A(t) - A(0)), the last of
    the own-start pair. Starts beyond what was demonstrated say nothing about the slope; what exceeds their spread is
    followed fully: there the object is moved as it was, but elsewhere.

    Strokes repeat one motion at one place: from the first turning point to the last one slope holds, the mean. That
    of each moment is as uncertain as demonstrations are few, and would shift one stroke against the next.

    Attributes:
        supports: the pairs region - support of the object.
        own_starts: the same regions against their own starts.
        start_std: standard deviation of the region's start in the plane, m.
        offset: of the region's start from the mean demonstrated one, in the plane, agent frame, m.
        strokes: times of the first and the last turning point of an object that goes to and fro, s; else None.
    """

    supports: tuple[GeneralizedChange, ...]
    own_starts: tuple[GeneralizedChange, ...]
    start_std: float
    offset: Float[np.ndarray, " 3"]
    strokes: tuple[float, float] | None = None

    def slope(self, times: Float[np.ndarray, " keypoints"]) -> Float[np.ndarray, " keypoints"]:
        """How far the object follows its start: 0 not at all, 1 all the way; 1 if all started alike."""
        slope = self._momentary_slope(times)
        if self.strokes:
            first, last = self.strokes
            during = (times >= first) & (times <= last)
            slope[during] = self._momentary_slope(np.linspace(first, last, STROKE_SAMPLES)).mean()
        return slope

    def _momentary_slope(self, times: Float[np.ndarray, " keypoints"]) -> Float[np.ndarray, " keypoints"]:
        at_start = _variance(self.supports, np.zeros(1))[0]
        if at_start < 1e-6:
            return np.ones(len(times))
        away = at_start - _variance(self.own_starts, times)
        return np.clip((_variance(self.supports, times) + away) / (2.0 * at_start), 0.0, 1.0)

    def further(self, times: Float[np.ndarray, " keypoints"]) -> Float[np.ndarray, "keypoints 3"]:
        """How much further than in the mean demonstration the region is to be, m."""
        beyond = 1.0 - START_SPREADS * self.start_std / max(float(np.linalg.norm(self.offset)), 1e-9)
        return np.maximum(self.slope(times), beyond)[:, None] * self.offset


def _variance(
    changes: Sequence[GeneralizedChange], times: Float[np.ndarray, " keypoints"]
) -> Float[np.ndarray, " keypoints"]:
    """Sum of the changes' variances in the plane, m^2."""
    return np.square([change.at(times)[1][:, :2] for change in changes]).sum(axis=(0, 2))


def placement_of(task: Task, region: RegionReference) -> Placement | None:
    """The placement of a region, or of another one of its object; None if its role has no support."""
    own_starts = {change.pair.first: change for change in task.model.changes if change.pair.is_own_start}
    supports = {
        change.pair.first: change
        for change in task.model.changes
        if change.pair.first.role == region.role and change.pair.first in own_starts and change.from_agent
    }
    if not supports:
        return None
    known = region if region in supports else next(iter(supports))
    turns = [a.time for a in task.model.anchors if a.kind == "reversal" and a.role == region.role]
    mean, std = supports[known].at(np.zeros(1))
    return Placement(
        supports=tuple(supports.values()),
        own_starts=tuple(own_starts[one] for one in supports),
        start_std=float(np.linalg.norm(std[0, :2])),
        offset=(task.region_at_start(known) - mean[0]) * IN_PLANE,
        strokes=(turns[0], turns[-1]) if len(turns) >= LEAST_STROKES else None,
    )
