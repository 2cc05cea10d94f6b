"""Which hand holds which object, when and where: from motion and distance alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Demonstration, Hand
from sbam.demonstrations.events import ObjectMotion, known_models, object_axis, object_motion
from sbam.demonstrations.signals import (
    POSITION_CUTOFF,
    RATE,
    Run,
    bridge,
    low_pass,
    resample,
    speed,
    true_runs,
)
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import ObjectModel

Array = NDArray[np.float64]

RELATIVE_SPEED = 0.080
"""A hand that moves faster than this in the frame of an object does not hold it, m/s."""
RELATIVE_PATH = 0.5
"""While an object moves, its holder's path in the object's frame is less than this part of the object's own path."""
CARRIED_PATH = 0.030
"""Shortest path of an object that tells its holder, m."""
REACH_MARGIN = 0.025
"""A hand holds up to this much farther from the object's axis than its median while the object moves, m."""
REACH_STILL = 0.120
"""Largest distance to the axis of an object that is held without being moved, m."""
COMPANION_PATH = 0.5
"""Of two hands that go along with an object the one holds too if it does so over this part of the other's way."""
SLIP_GAP = 0.3
"""Shorter interruptions are none, s."""
REGRIP_GAP = 1.0
"""Holds of one object by one hand are one if the hand re-grips within this time, s."""
STILL_DURATION = 0.5
"""Shortest hold of an object that is not moved, s."""
GRASP_DELAY = 0.5
"""A hand that takes hold later than this after the object began to move took it over from another, s."""
HOLD_FRAMES = 100
"""The pose of the hand is taken from about this many frames of a hold, evenly spread."""
REST_DISTANCE = 0.002
"""The grasp is when the object was last this close to its rest before it moved, m. An object that is not moved is
grasped when the hand's distance is this close to its median."""


@dataclass(frozen=True)
class Hold:
    """One hand holds one object for a while.

    Attributes:
        hand: which hand; None if the recording has no hands, so that the hold is known from the object's motion only.
        object: the object.
        start: grasp, s from the start of the recording.
        end: release, s from the start of the recording.
        T_object_hand: mean pose of the hand in the object's frame (median position), or None without hands.
        spread: root mean square distance of the hand from that position while it holds, m; 0 without hands.
    """

    hand: Hand | None
    object: str
    start: float
    end: float
    T_object_hand: RigidTransform | None
    spread: float


@dataclass(frozen=True)
class _Relative:
    """A hand seen from an object, on the grid: speed (N,) m/s and distance to the object's axis (N,) m."""

    speed: Array
    distance: Array


@dataclass(frozen=True)
class _Claim:
    """A hand goes along with a moving object for ``path`` m of its way."""

    hand: Hand
    object: str
    span: Run
    path: float


def find_holds(
    demonstration: Demonstration, models: Mapping[str, ObjectModel] | ObjectLibrary | None = None
) -> tuple[Hold, ...]:
    """Holds of all movable objects, in order of time.

    An object that moves is held by every hand that stays slow in the object's frame meanwhile (both, for a rolling
    pin). An object that stays is held by a hand that comes close, stays and leaves. Without hands every object that
    moves is held from its lift to its place, by ``hand=None``: who will hold it is then for the planner to choose.

    Args:
        demonstration: the recording, at any rate, also uneven.
        models: object name -> model; None looks the names up in the built-in library. Furniture is never held.

    Returns:
        The holds; one per hand for an object in both hands.
    """
    known = known_models(demonstration, models)
    movable = [name for name in demonstration.objects if name not in known or known[name].movable]
    motions = {name: object_motion(demonstration, name) for name in movable}
    if not demonstration.T_world_hand:
        moved = [_hold_without_hand(name, motion) for name, motion in motions.items() if motion.moving]
        return tuple(sorted(moved, key=lambda hold: hold.start))
    relatives: dict[tuple[Hand, str], _Relative] = {}
    for name in movable:
        poses = demonstration.T_world_object[name]
        R_object_world, axis = poses.rotation.inv(), object_axis(known.get(name), poses.rotation)
        for hand, T_world_hand in demonstration.T_world_hand.items():
            position = R_object_world.apply(T_world_hand.translation - poses.translation)
            relatives[hand, name] = _relative_motion(position, axis, demonstration.time, motions[name].grid)
    claims = [
        _Claim(hand, name, span, _carried_path(span, motions[name], relative))
        for (hand, name), relative in relatives.items()
        for span in _carrying(motions[name], relative)
    ]
    holds = _without_conflicts(claims, motions)
    # A hand that carries one object does not hold another that it pauses beside.
    busy = {hand: [claim.span for claim in holds if claim.hand == hand] for hand in demonstration.T_world_hand}
    for (hand, name), relative in relatives.items():
        if not motions[name].moving:
            holds += [_Claim(hand, name, span, 0.0) for span in _steadying(relative, busy[hand])]
    found = [_hold(demonstration, claim, motions[claim.object].grid) for claim in holds]
    return tuple(sorted(found, key=lambda hold: (hold.start, hold.object, hold.hand or "")))


def _without_conflicts(claims: Sequence[_Claim], motions: Mapping[str, ObjectMotion]) -> list[_Claim]:
    """Of claims that exclude each other those that carry an object farther."""
    kept: list[_Claim] = []
    for claim in sorted(claims, key=lambda item: -item.path):
        if not any(_excludes(other, claim, motions[claim.object]) for other in kept):
            kept.append(claim)
    return kept


def _excludes(stronger: _Claim, claim: _Claim, motion: ObjectMotion) -> bool:
    """Whether the hand holds another object then, or merely goes along for a while with what the other hand carries."""
    common = Run(max(stronger.span.start, claim.span.start), min(stronger.span.stop, claim.span.stop))
    if stronger.hand == claim.hand:
        return stronger.object != claim.object and 2 * (common.stop - common.start) > claim.span.stop - claim.span.start
    if stronger.object != claim.object or common.stop <= common.start:
        return False
    shared = _path(motion, common)
    return 2 * shared > claim.path and claim.path < COMPANION_PATH * stronger.path


def _hold_without_hand(name: str, motion: ObjectMotion) -> Hold:
    start, end = motion.moving[0].start, motion.moving[-1].stop - 1
    return Hold(None, name, float(motion.grid[start]), float(motion.grid[end]), None, 0.0)


def _median_of_three(positions: Array) -> Array:
    """Positions (T, 3) without single frames that stick out."""
    result = positions.copy()
    first, second, third = positions[:-2], positions[1:-1], positions[2:]
    result[1:-1] = np.maximum(np.minimum(first, second), np.minimum(np.maximum(first, second), third))
    return result


def _relative_motion(position: Array, axis: Array, time: Array, grid: Array) -> _Relative:
    """From the positions (T, 3) of a hand in an object's frame, m."""
    smooth = low_pass(resample(_median_of_three(position), time, grid), POSITION_CUTOFF)
    distance = np.linalg.norm(smooth - np.outer(smooth @ axis, axis), axis=1)
    return _Relative(speed(smooth, grid), distance)


def _carrying(motion: ObjectMotion, relative: _Relative) -> list[Run]:
    """When the hand holds an object that is moved."""
    slow = relative.speed < RELATIVE_SPEED
    along = [run for run in bridge(true_runs(slow), SLIP_GAP) if _carried_path(run, motion, relative) > 0]
    if not along:
        return []
    samples = np.concatenate([np.arange(*run) for run in along])
    moves = _moves(motion)
    reach = float(np.median(relative.distance[samples[moves[samples]]])) + REACH_MARGIN
    spans = []
    for span in bridge(true_runs(slow & (relative.distance < reach)), REGRIP_GAP):
        if _carried_path(span, motion, relative) > 0:
            first = next(run for run in motion.moving if run.stop > span.start)
            spans.append(Run(_grasp(motion, first, span), span.stop))
    return spans


def _moves(motion: ObjectMotion) -> NDArray[np.bool_]:
    moves = np.zeros(len(motion.grid), dtype=bool)
    for run in motion.moving:
        moves[run.start : run.stop] = True
    return moves


def _carried_path(run: Run, motion: ObjectMotion, relative: _Relative) -> float:
    """Path of the object in a run, m; 0 if it is too short or if the hand does not go along."""
    path = _path(motion, run)
    slip = float(relative.speed[run.start : run.stop][_moves(motion)[run.start : run.stop]].sum()) / RATE
    return path if path > CARRIED_PATH and slip < RELATIVE_PATH * path else 0.0


def _path(motion: ObjectMotion, run: Run) -> float:
    """Path of the object in a run where it moves, m."""
    return float(motion.speed[run.start : run.stop][_moves(motion)[run.start : run.stop]].sum()) / RATE


def _grasp(motion: ObjectMotion, move: Run, span: Run) -> int:
    """Sample at which the object leaves its rest, or the hand takes it over."""
    if span.start - move.start > GRASP_DELAY * RATE:
        return span.start
    earlier = [run.stop for run in motion.moving if run.stop <= move.start]
    first = earlier[-1] if earlier else 0
    if move.start - first < 2:
        return move.start
    before = motion.position[first : move.start]
    near = np.linalg.norm(before - np.median(before, axis=0), axis=1) < REST_DISTANCE
    return first + int(np.flatnonzero(near)[-1]) if near.any() else move.start


def _steadying(relative: _Relative, busy: list[Run]) -> list[Run]:
    """When the hand holds an object that is not moved: it comes close, stays and leaves, and has no other object."""
    holds = (relative.speed < RELATIVE_SPEED) & (relative.distance < REACH_STILL)
    for run in busy:
        holds[run.start : run.stop] = False
    spans = []
    for span in bridge(true_runs(holds), REGRIP_GAP):
        if span.start > 0 and span.stop < len(holds):
            distance = relative.distance[span.start : span.stop]
            settled = Run(span.start + int(np.argmax(distance < np.median(distance) + REST_DISTANCE)), span.stop)
            if settled.stop - settled.start >= STILL_DURATION * RATE:
                spans.append(settled)
    return spans


def _hold(demonstration: Demonstration, claim: _Claim, grid: Array) -> Hold:
    start, end = float(grid[claim.span.start]), float(grid[claim.span.stop - 1])
    held = np.flatnonzero((demonstration.time >= start) & (demonstration.time <= end))
    if not len(held):
        held = np.array([np.abs(demonstration.time - start).argmin()])
    held = held[:: max(1, len(held) // HOLD_FRAMES)]
    T_object_world = demonstration.T_world_object[claim.object][held].inv()
    poses = T_object_world * demonstration.T_world_hand[claim.hand][held]
    position = np.median(poses.translation, axis=0)
    spread = float(np.sqrt(np.mean(np.sum((poses.translation - position) ** 2, axis=1))))
    return Hold(
        claim.hand, claim.object, start, end, RigidTransform.from_components(position, poses.rotation.mean()), spread
    )
