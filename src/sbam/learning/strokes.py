"""Unequal numbers of strokes: whole cycles are cut from the longer demonstrations before time is aligned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import Event, object_motion
from sbam.demonstrations.signals import resample

Array = NDArray[np.float64]

ALTERNATION = -0.3
"""Strokes are reversals whose changes of direction have a cosine below this from one to the next."""
LEAST_STROKES = 4
"""Fewer alternating reversals than this are no strokes, and nothing is cut."""
VELOCITY_TIME = 0.1
"""Weight of a jump in velocity against one in position, s."""
ROTATION_LEVER = 0.1
"""Weight of a jump in rotation against one in position, m/rad."""
MAX_CHOICES = 600
"""Most instants among which a cut is chosen."""


@dataclass(frozen=True)
class EqualizedStrokes:
    """Demonstrations that show the same number of strokes.

    Attributes:
        demonstrations: those that stay, longer ones cut.
        kept: their indices among the given ones.
        notes: what was cut or left out and why, a sentence each.
    """

    demonstrations: tuple[Demonstration, ...]
    kept: tuple[int, ...]
    notes: tuple[str, ...]


def equalize_strokes(
    demonstrations: Sequence[Demonstration],
    events: Sequence[Sequence[Event]],
    roles: Sequence[Mapping[str, str]] | None = None,
) -> EqualizedStrokes:
    """Bring all demonstrations to the median number of strokes (learning recipe, "Unequal numbers of strokes").

    A demonstration with more is shortened by whole cycles (two reversals), each cut where the positions and velocities
    at both ends of the cut are most alike. One that lacks a whole cycle is left out. A difference of a single
    reversal is no cycle; it is left to the alignment of events.

    Args:
        demonstrations: D recordings of one task.
        events: D sequences of their events, ``object`` as in the recording.
        roles: D mappings object -> role; None if every object plays the role of its own name.

    Returns:
        The demonstrations that stay. All of them, unchanged, where strokes do not recur.
    """
    bindings = [{name: name for name in item.objects} for item in demonstrations] if roles is None else list(roles)
    current = dict(enumerate(demonstrations))
    now = dict(enumerate([tuple(sequence) for sequence in events]))
    notes: list[str] = []
    for role in sorted({role for binding in bindings for role in binding.values()}):
        objects = {index: _object_of(bindings[index], role) for index in current}
        counts = {index: len(strokes(now[index], objects[index])) for index in current}
        target = sorted(counts.values())[(len(counts) - 1) // 2]
        if target < LEAST_STROKES:
            continue
        for index, count in counts.items():
            name = current[index].name
            if count <= target - 2:
                notes.append(f"{name} is left out: {count} reversals of {role}, the others have {target}")
                del current[index], now[index]
                continue
            cycles = (count - target) // 2
            for _ in range(cycles):
                current[index], now[index] = _without_cycle(current[index], now[index], objects[index])
            if cycles:
                notes.append(
                    f"{name}: {cycles} of {count // 2} cycles of {role} cut, to match the other demonstrations"
                )
    return EqualizedStrokes(tuple(current.values()), tuple(current), tuple(notes))


def _object_of(binding: Mapping[str, str], role: str) -> str:
    return next((name for name, bound in binding.items() if bound == role), "")


def strokes(events: Sequence[Event], name: str) -> tuple[Event, ...]:
    """The longest series of reversals of one object whose changes of direction alternate."""
    reversals = sorted((e for e in events if e.object == name and e.kind == "reversal"), key=lambda e: e.time)
    series: list[Event] = reversals[:1]
    longest = series
    for previous, event in pairwise(reversals):
        alternates = float(previous.descriptor @ event.descriptor) < ALTERNATION
        series = [*series, event] if alternates else [event]
        longest = max(longest, series, key=len)
    return tuple(longest)


def _without_cycle(
    demonstration: Demonstration, events: Sequence[Event], name: str
) -> tuple[Demonstration, tuple[Event, ...]]:
    """Cut the cycle of the object's strokes whose ends are most alike."""
    turning = np.array([event.time for event in strokes(events, name)])
    time = demonstration.time
    inside = np.flatnonzero((time >= turning[0]) & (time <= turning[-1]))
    inside = inside[:: max(1, -(-len(inside) // MAX_CHOICES))]
    turned = np.searchsorted(turning, time[inside], side="right")
    jump = _jumps(demonstration, inside)
    jump[turned[None, :] - turned[:, None] != 2] = np.inf
    first, second = (int(inside[index]) for index in np.unravel_index(jump.argmin(), jump.shape))
    return cut(demonstration, first, second), _events_without(events, float(time[first]), float(time[second]))


def _jumps(demonstration: Demonstration, choices: NDArray[np.intp]) -> Array:
    """Jump (C, C) in m that a cut from one instant to another leaves, summed over the moving objects."""
    total = np.zeros((len(choices), len(choices)))
    for name in demonstration.objects:
        motion = object_motion(demonstration, name)
        if not motion.moving:
            continue
        velocity = np.gradient(motion.position, motion.grid, axis=0)
        at = demonstration.time[choices]
        for values, weight in ((motion.position, 1.0), (velocity, VELOCITY_TIME)):
            chosen = resample(values, motion.grid, at)
            total += weight * np.linalg.norm(chosen[:, None] - chosen, axis=2)
        rotation = demonstration.T_world_object[name][choices].rotation.as_matrix()
        # 3 - trace(R_a^T R_b) = 2 - 2 cos(angle): the root is about the angle turned.
        turned = np.sqrt(np.maximum(3 - np.einsum("aij,bij->ab", rotation, rotation), 0))
        total += ROTATION_LEVER * turned
    return total


def cut(demonstration: Demonstration, first: int, second: int) -> Demonstration:
    """Remove the frames after ``first`` up to and including ``second``; what follows moves forward in time.

    Args:
        demonstration: the recording.
        first: last frame before the cut.
        second: the frame in whose place ``first`` stands from now on.

    Returns:
        A shorter demonstration that says in its notes what is missing; labels are shortened with it.
    """
    time = demonstration.time
    start, end = float(time[first]), float(time[second])
    keep = np.r_[0 : first + 1, second + 1 : len(time)]
    labels = (
        replace(label, start=_moved(label.start, start, end), end=_moved(label.end, start, end))
        for label in demonstration.labels
    )
    return replace(
        demonstration,
        time=np.where(time > start, time - (end - start), time)[keep],
        T_world_object={name: poses[keep] for name, poses in demonstration.T_world_object.items()},
        T_world_hand={hand: poses[keep] for hand, poses in demonstration.T_world_hand.items()},
        labels=tuple(label for label in labels if label.end > label.start),
        notes=(*demonstration.notes, f"{start:.2f} to {end:.2f} s cut"),
    )


def _moved(time: float, start: float, end: float) -> float:
    """Where a time is after the cut."""
    return time if time <= start else max(start, time - (end - start))


def _events_without(events: Sequence[Event], start: float, end: float) -> tuple[Event, ...]:
    return tuple(
        replace(event, time=_moved(event.time, start, end)) for event in events if not start < event.time <= end
    )
