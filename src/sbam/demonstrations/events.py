"""Events: what an object does that can be recognised in every demonstration of a task, without knowing the task.

An object is lifted, placed, turns back (strokes) and tilts. Method: docs, "Time and anchors"; thresholds measured on
pouring and rolling, synthetic and real.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.signals import (
    RATE,
    Run,
    bridge,
    even_times,
    resample,
    smooth_axes,
    smooth_positions,
    speed,
    true_runs,
)
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import ObjectModel

Array = NDArray[np.float64]
EventKind = Literal["lift", "place", "reversal", "tilt"]

MOVING_SPEED = 0.030
"""An object moves above this speed, m/s..."""
MOVING_NOISE_FACTOR = 3.0
"""...or above this multiple of its own 10 % quantile of speed, if that is more..."""
MOVING_SPEED_LIMIT = 0.050
"""...but the quantile says nothing of the noise of an object that never rests, so no more than this, m/s."""
MOVING_DURATION = 0.1
"""Shortest motion, s."""
MOVING_GAP = 0.6
"""Motions are one if they are not farther apart than this, s."""
MOVING_DISPLACEMENT = 0.030
"""Least distance that a motion leads away from its start, m."""
EDGE_REST = 0.2
"""A rest at the edge of the recording counts from this duration; else the object is in motion there, s."""

REVERSAL_PROMINENCE = 0.040
"""Least prominence of a minimum of speed, m/s..."""
REVERSAL_RELATIVE_PROMINENCE = 0.08
"""...or this part of the largest speed, if that is more."""
REVERSAL_ARM = 0.030
"""Distance before and after that shows the direction, m..."""
REVERSAL_ARM_DURATION = 0.5
"""...reached within this time; an object that is slower rests, and when in its rest it turns is chance, s."""

TILT_RATE = np.radians(40.0)
"""Least peak of the angular speed of the object's axis, rad/s..."""
TILT_RELATIVE_RATE = 0.35
"""...or this part of the largest, if that is more."""
TILT_ANGLE = np.radians(20.0)
"""Least angle turned, rad."""


@dataclass(frozen=True)
class Event:
    """Something an object does at one time.

    Attributes:
        kind: ``lift``, ``place``, ``reversal`` or ``tilt`` (the fastest moment of a rotation of the object's axis).
        object: the object (or the role it plays, once roles are bound).
        time: s from the start of the recording.
        descriptor: unit vector that tells events of one kind apart: (3,) change of the direction of motion in the
            agent frame for a reversal; (1,) +1 away from the attitude at rest and -1 back for a tilt; (1,) 1 otherwise.
        strength: how marked it is, 0 to 1; lift and place are 1.
    """

    kind: EventKind
    object: str
    time: float
    descriptor: Array
    strength: float


@dataclass(frozen=True)
class ObjectMotion:
    """How one object moves, on an even grid of times.

    Attributes:
        grid: (N,) s from the start of the recording.
        position: (N, 3) smoothed, world, m.
        speed: (N,) m/s; 0 for an object that stays where it is.
        moving: stretches of motion, in order; empty if the object stays where it is.
    """

    grid: Array
    position: Array
    speed: Array
    moving: tuple[Run, ...]


def object_axis(model: ObjectModel | None, R_world_object: Rotation) -> Array:
    """The axis of an object whose rotation matters: the line along which its affordance regions lie.

    Rotation about this line is invisible to the constraints between the centres of the regions. An object with fewer
    than two regions has its upright axis instead, an unknown object the axis that points up at the start.

    Args:
        model: what is known of the object, or None.
        R_world_object: (T,) its orientations.

    Returns:
        (3,) unit vector, object frame.
    """
    if model is None:
        return R_world_object[0].inv().apply([0.0, 0.0, 1.0])
    centers = np.array([region.center for region in model.affordance_regions]).reshape(-1, 3)
    if len(centers) < 2 or np.ptp(centers, axis=0).max() < 0.01:
        return np.asarray(model.up, dtype=float)
    direction = np.linalg.svd(centers - centers.mean(axis=0))[2][0]
    return direction if direction @ model.up >= 0 else -direction


def known_models(
    demonstration: Demonstration, models: Mapping[str, ObjectModel] | ObjectLibrary | None
) -> dict[str, ObjectModel]:
    """Models of the objects of a demonstration, from ``models`` or, if that is None, the built-in object library."""
    if models is None:
        models = ObjectLibrary.built_in()
    return {name: models[name] for name in demonstration.objects if name in models}


def object_motion(demonstration: Demonstration, name: str) -> ObjectMotion:
    """Smoothed motion of one object and its stretches of motion."""
    time = demonstration.time
    position = demonstration.T_world_object[name].translation
    grid = even_times(time)
    if np.linalg.norm(np.ptp(position, axis=0)) <= MOVING_DISPLACEMENT:
        return ObjectMotion(grid, resample(position, time, grid), np.zeros(len(grid)), ())
    smooth = smooth_positions(position, time, grid)
    object_speed = speed(smooth, grid)
    return ObjectMotion(grid, smooth, object_speed, _moving(smooth, object_speed))


def _moving(position: Array, object_speed: Array) -> tuple[Run, ...]:
    noise = MOVING_NOISE_FACTOR * float(np.quantile(object_speed, 0.1))
    threshold = max(MOVING_SPEED, min(noise, MOVING_SPEED_LIMIT))
    long_enough = [
        run for run in true_runs(object_speed > threshold) if run.stop - run.start >= round(MOVING_DURATION * RATE)
    ]
    moving = []
    for run in bridge(long_enough, MOVING_GAP):
        way = np.linalg.norm(position[run.start : run.stop] - position[run.start], axis=1)
        if way.max() > MOVING_DISPLACEMENT:
            moving.append(run)
    if moving and moving[0].start < EDGE_REST * RATE:
        moving[0] = Run(0, moving[0].stop)
    if moving and len(object_speed) - moving[-1].stop < EDGE_REST * RATE:
        moving[-1] = Run(moving[-1].start, len(object_speed))
    return tuple(moving)


def objects_that_move(demonstration: Demonstration) -> tuple[str, ...]:
    """Names of the objects that are moved in a demonstration, in its order."""
    return tuple(name for name in demonstration.objects if object_motion(demonstration, name).moving)


def find_events(
    demonstration: Demonstration, models: Mapping[str, ObjectModel] | ObjectLibrary | None = None
) -> tuple[Event, ...]:
    """Events of all objects that move, in order of time.

    Args:
        demonstration: the recording, at any rate, also uneven.
        models: object name -> model; None looks the names up in the built-in library. Objects without a model
            are taken as standing upright at the start.

    Returns:
        Per moving object one ``lift`` and one ``place``, and its reversals and tilts in between.
    """
    known = known_models(demonstration, models)
    events: list[Event] = []
    for name in demonstration.objects:
        motion = object_motion(demonstration, name)
        if motion.moving:
            events += _events_of(demonstration, name, motion, known.get(name))
    return tuple(sorted(events, key=lambda event: event.time))


def _events_of(demonstration: Demonstration, name: str, motion: ObjectMotion, model: ObjectModel | None) -> list[Event]:
    whole = Run(motion.moving[0].start, motion.moving[-1].stop)
    rotation = demonstration.T_world_object[name].rotation
    axis = smooth_axes(rotation.apply(object_axis(model, rotation)), demonstration.time, motion.grid)
    one = np.ones(1)
    return [
        Event("lift", name, float(motion.grid[whole.start]), one, 1.0),
        Event("place", name, float(motion.grid[whole.stop - 1]), one, 1.0),
        *_reversals(name, motion, whole, demonstration.T_world_agent.rotation),
        *_tilts(name, motion.grid[whole.start : whole.stop], axis[whole.start : whole.stop]),
    ]


def _reversals(name: str, motion: ObjectMotion, whole: Run, R_world_agent: Rotation) -> list[Event]:
    from scipy.signal import find_peaks

    position = motion.position[whole.start : whole.stop]
    object_speed = motion.speed[whole.start : whole.stop]
    least = max(REVERSAL_PROMINENCE, REVERSAL_RELATIVE_PROMINENCE * float(object_speed.max()))
    minima, properties = find_peaks(-object_speed, prominence=least)
    events = []
    for minimum, prominence in zip(minima, properties["prominences"], strict=True):
        before = -_arm(position[minimum::-1])
        after = _arm(position[minimum:])
        if before @ after < 0:
            change = after - before
            descriptor = R_world_agent.inv().apply(change / np.linalg.norm(change))
            strength = float(prominence / object_speed.max())
            events.append(Event("reversal", name, float(motion.grid[whole.start + minimum]), descriptor, strength))
    return events


def _arm(path: Array) -> Array:
    """Direction (3,) from the start of a path (N, 3) to where it is `REVERSAL_ARM` away; 0 if it does not get there."""
    path = path[: round(REVERSAL_ARM_DURATION * RATE) + 1]
    distance = np.linalg.norm(path - path[0], axis=1)
    far = np.flatnonzero(distance >= REVERSAL_ARM)
    return (path[far[0]] - path[0]) / distance[far[0]] if len(far) else np.zeros(3)


def _tilts(name: str, grid: Array, axis: Array) -> list[Event]:
    from scipy.signal import find_peaks

    rate = speed(axis, grid)
    least = max(TILT_RATE, TILT_RELATIVE_RATE * float(rate.max()))
    # Half of the threshold as prominence: a rotation with a short hesitation stays one rotation.
    peaks, _ = find_peaks(np.concatenate([[0.0], rate, [0.0]]), height=least, prominence=0.5 * least)
    peaks = peaks - 1
    # Each peak turns from one valley to the next; without a peak there is nothing to do.
    valleys = [
        0,
        *(first + int(rate[first:second].argmin()) for first, second in pairwise(peaks)),
        len(rate) - 1,
    ]
    angle_to_rest = np.arccos(np.clip(axis @ axis[0], -1.0, 1.0))
    events = []
    for peak, (start, stop) in zip(peaks, pairwise(valleys), strict=False):
        turned = np.arccos(np.clip(axis[start] @ axis[stop], -1.0, 1.0))
        if turned > TILT_ANGLE:
            away = 1.0 if angle_to_rest[stop] > angle_to_rest[start] else -1.0
            events.append(Event("tilt", name, float(grid[peak]), np.array([away]), float(rate[peak] / rate.max())))
    return events
