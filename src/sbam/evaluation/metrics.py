"""How near an execution comes to what a person did in the same scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionPair
from sbam.demonstrations.events import object_axis
from sbam.evaluation.executed_motion import ExecutedMotion
from sbam.evaluation.person import PersonMotion
from sbam.evaluation.smoothness import joint_smoothness, path_smoothness
from sbam.learning.pairs import candidate_pairs
from sbam.learning.settings import LearningSettings
from sbam.planning.task import Task
from sbam.tasks.geometry import measure_put_down
from sbam.tasks.object_motion import region_points, roles_poses
from sbam.tasks.pouring.geometry import ABOUT_TO_POUR_DISTANCE, ABOUT_TO_POUR_TILT, measure_pouring
from sbam.tasks.rolling.geometry import measure_rolling, turning_points

SPREAD_FLOOR = 0.005  # m: spreads below it count as it, as in the weights of the planner
DENSE_SAMPLES = 400
PERSON = " (person)"  # ends the names of what is measured of the person, not of the execution


@dataclass(frozen=True)
class PairDistances:
    """Distances between the demonstrated and the executed vector that connects two regions.

    Attributes:
        pair: the pair, as text.
        seconds: (K) mm at the model's keypoints, the person being looked at at the same second (the paper's measure).
        events: (K) mm with time aligned by events.
        spread: (K) mm: standard deviation of the vector over the training demonstrations, aligned by events.
        dense: mean over the whole motion, not only the keypoints, aligned by events, mm.
        tempo: mean distance of the person from themself, the same second against the same event, mm: what another tempo
            alone makes of ``seconds``.
    """

    pair: str
    seconds: tuple[float, ...]
    events: tuple[float, ...]
    spread: tuple[float, ...]
    dense: float
    tempo: float

    @property
    def relevant(self) -> float:
        """Mean of ``events``, weighted by how much the demonstrations agree: 1 / (spread^2 + (5 mm)^2); mm."""
        weight = 1.0 / (np.square(self.spread) + (1e3 * SPREAD_FLOOR) ** 2)
        return float(np.average(self.events, weights=weight))


def paper_pairs(task: Task) -> tuple[RegionPair, ...]:
    """The pairs that the paper measures: all unordered pairs of regions of the objects involved (section III-A).

    They do not depend on which pairs the model watches.
    """
    roles = {role.name: task.scene.objects[task.binding[role.name]] for role in task.model.roles}
    return candidate_pairs(roles, LearningSettings.paper())


def pair_distances(
    motion: ExecutedMotion, person: PersonMotion, training: Sequence[PersonMotion]
) -> tuple[PairDistances, ...]:
    """The paper's measure of similarity and its variants, for every pair of `paper_pairs`.

    Args:
        motion: the execution in the scene in which the person started.
        person: the demonstration that was held out.
        training: those that were learned from, for the spreads.
    """
    task = motion.task
    keypoints = task.model.keypoint_times
    clock, dense_poses = _dense(motion)
    same_second, same_event = person.poses_at(keypoints), person.poses_at(person.aligned(keypoints))
    same_event_dense = person.poses_at(person.aligned(clock))
    others = [other.poses_at(other.aligned(keypoints)) for other in training]
    result = []
    for pair in paper_pairs(task):
        executed = _vector(task, motion.keypoint_poses, pair, len(keypoints))
        by_second, by_event = (_demonstrated(person, poses, pair) for poses in (same_second, same_event))
        dense = _vector(task, dense_poses, pair, len(clock)) - _demonstrated(person, same_event_dense, pair)
        result.append(
            PairDistances(
                pair=str(pair),
                seconds=_millimetres(executed - by_second),
                events=_millimetres(executed - by_event),
                spread=_spread([_demonstrated(one, poses, pair) for one, poses in zip(training, others, strict=True)]),
                dense=float(np.mean(_millimetres(dense))),
                tempo=float(np.mean(_millimetres(by_second - by_event))),
            )
        )
    return tuple(result)


def measures(motion: ExecutedMotion, person: PersonMotion) -> dict[str, float]:
    """Everything else that is worth a number; names hold the unit.

    Per moved object: mean error of its orientation and of the axis along which its regions lie, and the root mean
    square error of its tilt from the vertical, at the keypoints with time aligned by events; where it ends; its largest
    speed (on the model's clock) and the logarithm of its dimensionless jerk, executed and demonstrated. Then the task's
    geometry, human-likeness and time.
    """
    task = motion.task
    keypoints = task.model.keypoint_times
    aligned = person.poses_at(person.aligned(keypoints))
    values: dict[str, float] = {}
    for moved in task.moved:
        executed, demonstrated = motion.keypoint_poses[moved.role], aligned[moved.role]
        turn = (executed.rotation * demonstrated.rotation.inv()).magnitude()
        axis = object_axis(moved.model, demonstrated.rotation)
        axes = executed.rotation.apply(axis), demonstrated.rotation.apply(axis)
        tilts = [np.arccos(np.clip(one[:, 2], -1.0, 1.0)) for one in axes]
        values[f"{moved.role}: orientation error [deg]"] = float(np.rad2deg(turn.mean()))
        values[f"{moved.role}: axis error [deg]"] = float(np.rad2deg(_angles(*axes).mean()))
        values[f"{moved.role}: tilt error, rms [deg]"] = float(
            np.rad2deg(np.sqrt(np.square(tilts[0] - tilts[1]).mean()))
        )
        path, own = motion.T_agent_object[moved.name].translation, person.T_agent_role[moved.role].translation
        values[f"{moved.role}: ends off by [mm]"] = float(1e3 * np.linalg.norm(path[-1] - own[-1]))
        values |= path_smoothness(f"{moved.role}: ", motion.model_time, path)
        values |= {f"{name}{PERSON}": v for name, v in path_smoothness(f"{moved.role}: ", person.time, own).items()}
    values |= _pouring(motion, person) | _rolling(motion, person)
    if any(change.pair.is_own_start for change in task.model.changes):
        values |= measure_put_down(motion).values
    if motion.human_deviation is not None:
        values["arms off a natural posture [deg]"] = motion.human_deviation
    if motion.trajectory is not None:
        values |= joint_smoothness(motion.trajectory, motion.model_time)
    values["duration of the motion [s]"] = float(motion.time[-1])
    values["objective"] = motion.objective
    return values


def _pouring(motion: ExecutedMotion, person: PersonMotion) -> dict[str, float]:
    """Distance from mouth to rim where the person pours, and the geometry of pouring."""
    if not {"pour_from", "pour_into"} <= motion.task.binding.keys():
        return {}
    task, clock = motion.task, motion.task.model.keypoint_times
    pair = next(p for p in paper_pairs(task) if {p.first.affordance, _second(p)} == {"pour from", "pour into"})
    poses = person.poses_at(person.aligned(clock))
    demonstrated = _demonstrated(person, poses, pair)
    axis = poses["pour_from"].rotation.apply(task.scene.objects[task.binding["pour_from"]].up)
    near = np.linalg.norm(demonstrated, axis=1) < ABOUT_TO_POUR_DISTANCE
    pours = (axis[:, 2] < np.cos(ABOUT_TO_POUR_TILT)) & near
    values: dict[str, float] = {}
    if pours.any():
        off = _vector(task, motion.keypoint_poses, pair, len(clock))[pours] - demonstrated[pours]
        values["mouth - rim while pouring [mm]"] = float(np.mean(_millimetres(off)))
        executed = motion.keypoint_poses["pour_from"].rotation[pours]
        up = task.scene.objects[task.binding["pour_from"]].up
        turned = _angles(executed.apply(up), axis[pours])
        values["bottle's axis while pouring [deg]"] = float(np.rad2deg(turned.mean()))
    measure = measure_pouring(motion)
    return values | dict(measure.values) | {"poured over the cup [share]": float(measure.ok)}


def _rolling(motion: ExecutedMotion, person: PersonMotion) -> dict[str, float]:
    """Turning points of the strokes against the person's, in order of time, and the geometry of rolling."""
    if "handle_left" not in motion.task.binding:
        return {}
    own_clock = np.linspace(0.0, person.time[-1], 100 * round(person.time[-1]) + 1)
    theirs = person.poses_at(own_clock)["handle_left"].translation
    ours = motion.T_agent_object[motion.task.binding["handle_left"]].translation
    values = dict(measure_rolling(motion).values)
    turns, own_turns = turning_points(ours), turning_points(theirs)
    values[f"half-strokes{PERSON}"] = float(max(len(own_turns) - 1, 0))
    if len(turns) and len(own_turns):
        when = person.on_model_axis(own_clock[own_turns])
        nearest = np.abs(motion.model_time[turns][:, None] - when).argmin(axis=0)
        off = ours[turns[nearest]] - theirs[own_turns]
        late = motion.model_time[turns[nearest]] - when
        values["turning points off by [mm]"] = float(1e3 * np.linalg.norm(off, axis=1).mean())
        values["turning points late by, abs. [s]"] = float(np.abs(late).mean())
        strokes = [
            np.linalg.norm(np.diff(path[at], axis=0), axis=1) for path, at in ((ours, turns), (theirs, own_turns))
        ]
        if all(len(one) for one in strokes):
            values["strokes' amplitude / person's"] = float(strokes[0].mean() / strokes[1].mean())
        rolling = slice(own_turns[0], own_turns[-1] + 1)
        theirs_aligned = person.on_model_axis(own_clock[rolling])
        height = np.interp(theirs_aligned, motion.model_time, ours[:, 2]) - theirs[rolling, 2]
        values["pin's height off, mean [mm]"] = float(1e3 * np.abs(height).mean())
    return values


def _dense(motion: ExecutedMotion) -> tuple[Float[np.ndarray, " samples"], Mapping[str, RigidTransform]]:
    """Object poses on an even grid of the model's clock."""
    clock = np.linspace(0.0, motion.task.model.duration, DENSE_SAMPLES)
    samples = np.searchsorted(motion.model_time, clock).clip(0, len(motion.model_time) - 1)
    return clock, {role: poses[samples] for role, poses in roles_poses(motion).items()}


def _vector(
    task: Task, poses: Mapping[str, RigidTransform], pair: RegionPair, count: int
) -> Float[np.ndarray, "samples 3"]:
    assert pair.second is not None
    return region_points(task, poses, pair.first, count) - region_points(task, poses, pair.second, count)


def _demonstrated(
    person: PersonMotion, poses: Mapping[str, RigidTransform], pair: RegionPair
) -> Float[np.ndarray, "samples 3"]:
    """The person's vector between regions of the person's own objects in some poses."""
    assert pair.second is not None
    first, second = (
        poses[reference.role].apply(person.models[reference.role].region(reference.affordance).center)
        for reference in (pair.first, pair.second)
    )
    return first - second


def _spread(vectors: Sequence[Float[np.ndarray, "samples 3"]]) -> tuple[float, ...]:
    """Norm of the standard deviation over demonstrations of vectors, mm; 0 of a single one."""
    if len(vectors) < 2:
        return (0.0,) * len(vectors[0])
    return _millimetres(np.std(vectors, axis=0, ddof=1))


def _second(pair: RegionPair) -> str:
    return pair.second.affordance if pair.second is not None else ""


def _angles(
    first: Float[np.ndarray, "samples 3"], second: Float[np.ndarray, "samples 3"]
) -> Float[np.ndarray, " samples"]:
    """Angles between unit vectors, rad."""
    return np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ki,ki->k", first, second))


def _millimetres(vectors: Float[np.ndarray, "samples 3"]) -> tuple[float, ...]:
    return tuple((1e3 * np.linalg.norm(vectors, axis=1)).tolist())
