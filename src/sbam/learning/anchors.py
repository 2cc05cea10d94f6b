"""Anchors: the events that recur in every demonstration, to which time is aligned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.demonstrations.events import Event

DESCRIPTOR_WEIGHT = 0.25
"""Cost of (1 - cosine) between the descriptors of two events, next to their difference in phase."""
GAP_COST = 0.35
"""Cost of an event that has no partner."""
LEAST_DISTANCE = 0.080
"""Of two anchors that are closer than this in the mean, the weaker is dropped, s."""
LEAST_OWN_DISTANCE = 0.010
"""In a single demonstration two anchors that coincide are moved this far apart, for time must go on between them, s."""
_PRIORITY = {"lift": 3, "place": 2, "tilt": 1, "reversal": 0}
"""Which of two equally strong events stays."""


@dataclass(frozen=True)
class AnchorSet:
    """Anchors common to D demonstrations, in order of time.

    Hands may swap order: where anchors of two objects follow each other in either order, no monotone map can bring
    both to one time. Then each demonstration's times are sorted, so that its n-th event meets the n-th mean. On the
    built-in pours, where one layout in four swaps lifts and places, events end up 0.19 s (rms) from their mean so;
    0.24 s if the weaker of the two is dropped instead, 0.29 s without anchors.

    Attributes:
        kinds: (A) ``start``, ``lift``, ``place``, ``reversal``, ``tilt``, ``end``; first ``start``, last ``end``.
        roles: (A) the role whose object shows it, None for start and end.
        times: s on each demonstration's own time axis, strictly increasing along A, first column 0.
        notes: what was left out and why, a sentence each.
    """

    kinds: tuple[str, ...]
    roles: tuple[str | None, ...]
    times: Float[np.ndarray, "demonstrations anchors"]
    notes: tuple[str, ...] = ()

    @property
    def mean_times(self) -> Float[np.ndarray, " anchors"]:
        """Mean times, s: the anchors on the model's time axis."""
        return self.times.mean(axis=0)


@dataclass(frozen=True)
class _Candidate:
    """An event of one role that was found in all demonstrations: times, s."""

    kind: str
    role: str
    times: Float[np.ndarray, " demonstrations"]
    strength: float

    @property
    def rank(self) -> tuple[float, int]:
        return self.strength, _PRIORITY[self.kind]


def align_events(events: Sequence[Sequence[Event]], durations: Sequence[float]) -> AnchorSet:
    """Anchors common to all demonstrations (docs/method.md, "Time", steps 5 and 6).

    The events of each role are aligned with those of the role's medoid demonstration, keeping their order; what has a
    partner in every demonstration becomes an anchor. The result does not depend on the order of the demonstrations.

    Args:
        events: D sequences of events whose ``object`` is the role.
        durations: D durations, s.

    Returns:
        The anchors with start and end. Only these two, and a note, if no lift and place recurs.
    """
    if len(events) != len(durations) or not len(durations):
        raise ValueError(f"{len(events)} sequences of events for {len(durations)} durations; expected one each")
    roles = sorted({event.object for sequence in events for event in sequence})
    candidates: list[_Candidate] = []
    notes: list[str] = []
    for role in roles:
        sequences = [_of_role(sequence, role) for sequence in events]
        without = sum(not sequence for sequence in sequences)
        if without:
            notes.append(f"{role} moves in {len(sequences) - without} of {len(sequences)} demonstrations: no anchors")
            continue
        candidates += _recurring(role, sequences)
    candidates = _distinct(candidates, np.asarray(durations, dtype=float), notes)
    if not candidates:
        notes.append("no event recurs in every demonstration: time is aligned at start and end only")
    candidates.sort(key=lambda candidate: float(candidate.times.mean()))
    return AnchorSet(
        kinds=("start", *(candidate.kind for candidate in candidates), "end"),
        roles=(None, *(candidate.role for candidate in candidates), None),
        times=_sorted_times(candidates, np.asarray(durations, dtype=float)),
        notes=tuple(notes),
    )


def locate_anchors(
    kinds: Sequence[str],
    roles: Sequence[str | None],
    times: Float[np.ndarray, " anchors"],
    events: Sequence[Event],
    duration: float,
) -> Float[np.ndarray, " anchors"]:
    """When the anchors of a model occur in a demonstration that it was not learned from.

    Args:
        kinds: (A) kinds of the anchors; first ``start``, last ``end``.
        roles: (A) their roles.
        times: their times on the model's axis, s.
        events: events of the demonstration whose ``object`` is the role.
        duration: duration of the demonstration, s.

    Returns:
        In s, strictly increasing from 0 to ``duration``; an anchor that the demonstration does not show lies
        between its neighbours as in the model.
    """
    times = np.asarray(times, dtype=float)
    own = np.full(len(times), np.nan)
    own[[0, -1]] = 0.0, duration
    for role in sorted({role for role in roles if role is not None}):
        mine = np.array([index for index, other in enumerate(roles) if other == role])
        found = sorted((event for event in events if event.object == role), key=lambda event: event.time)
        cost = np.abs(times[mine, None] / times[-1] - np.array([event.time for event in found]) / duration)
        cost[[[kinds[index] != event.kind for event in found] for index in mine]] = np.inf
        for row, column in align_in_order(cost, GAP_COST)[0]:
            own[mine[row]] = found[column].time
    seen = np.isfinite(own)
    # Hands may swap order: what was found is sorted, as it was for the model.
    own[seen] = np.sort(own[seen])
    own = np.interp(times, times[seen], own[seen])
    return _apart(own[None])[0]


def _of_role(events: Sequence[Event], role: str) -> list[Event]:
    """Events of a role in order of time; none if it has no lift or no place."""
    own = sorted((event for event in events if event.object == role), key=lambda event: event.time)
    return own if {"lift", "place"} <= {event.kind for event in own} else []


def _phases(events: Sequence[Event]) -> Float[np.ndarray, " events"]:
    """Times as phase: 0 at the lift, 1 at the place."""
    lift = min(event.time for event in events if event.kind == "lift")
    place = max(event.time for event in events if event.kind == "place")
    return (np.array([event.time for event in events]) - lift) / max(place - lift, np.finfo(float).eps)


def _costs(first: Sequence[Event], second: Sequence[Event]) -> Float[np.ndarray, "rows columns"]:
    """Cost of making events partners; infinite between different kinds and opposite directions."""
    cost = np.abs(_phases(first)[:, None] - _phases(second))
    for row, one in enumerate(first):
        for column, other in enumerate(second):
            if one.kind != other.kind or one.descriptor @ other.descriptor < 0:
                cost[row, column] = np.inf
            else:
                cost[row, column] += DESCRIPTOR_WEIGHT * (1.0 - float(one.descriptor @ other.descriptor))
    return cost


def align_in_order(cost: Float[np.ndarray, "rows columns"], gap: float) -> tuple[list[tuple[int, int]], float]:
    """Order-preserving alignment of two sequences with gaps (Needleman and Wunsch 1970).

    Args:
        cost: of making items partners, may be infinite.
        gap: cost of an item without a partner.

    Returns:
        Partners (row, column), increasing in both, and the least total cost.
    """
    rows, columns = cost.shape
    total = np.zeros((rows + 1, columns + 1))
    total[:, 0] = gap * np.arange(rows + 1)
    total[0] = gap * np.arange(columns + 1)
    for i in range(1, rows + 1):
        for j in range(1, columns + 1):
            total[i, j] = min(total[i - 1, j - 1] + cost[i - 1, j - 1], total[i - 1, j] + gap, total[i, j - 1] + gap)
    partners = []
    i, j = rows, columns
    while i and j:
        if total[i, j] == total[i - 1, j - 1] + cost[i - 1, j - 1]:
            i, j = i - 1, j - 1
            partners.append((i, j))
        elif total[i, j] == total[i - 1, j] + gap:
            i -= 1
        else:
            j -= 1
    return partners[::-1], float(total[-1, -1])


def _recurring(role: str, sequences: list[list[Event]]) -> list[_Candidate]:
    """Events of one role that have a partner in every demonstration."""
    count = len(sequences)
    distance = np.zeros((count, count))
    partners: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for first in range(count):
        partners[first, first] = [(index, index) for index in range(len(sequences[first]))]
        for second in range(first + 1, count):
            pairs, cost = align_in_order(_costs(sequences[first], sequences[second]), GAP_COST)
            distance[first, second] = distance[second, first] = cost
            partners[first, second] = pairs
            partners[second, first] = [(column, row) for row, column in pairs]
    medoid = int(distance.sum(axis=1).argmin())
    matches = [dict(partners[medoid, other]) for other in range(count)]
    candidates = []
    for index, event in enumerate(sequences[medoid]):
        if all(index in match for match in matches):
            found = [sequence[match[index]] for sequence, match in zip(sequences, matches, strict=True)]
            times = np.array([other.time for other in found])
            strength = float(np.mean([other.strength for other in found]))
            candidates.append(_Candidate(event.kind, role, times, strength))
    return candidates


def _sorted_times(
    candidates: Sequence[_Candidate], durations: Float[np.ndarray, " demonstrations"]
) -> Float[np.ndarray, "demonstrations anchors"]:
    """Times of start, candidates and end, sorted in each demonstration and apart where there is room."""
    columns = [np.zeros(len(durations)), *(candidate.times for candidate in candidates), durations]
    return _apart(np.sort(np.stack(columns, axis=1), axis=1))


def _apart(times: Float[np.ndarray, "demonstrations anchors"]) -> Float[np.ndarray, "demonstrations anchors"]:
    """Sorted times moved apart, as far as there is room between the first and the last."""
    last = times.shape[1] - 1
    for column in range(1, last):
        times[:, column] = np.maximum(times[:, column], times[:, column - 1] + LEAST_OWN_DISTANCE)
    for column in range(last - 1, 0, -1):
        times[:, column] = np.minimum(times[:, column], times[:, column + 1] - LEAST_OWN_DISTANCE)
    return times


def _distinct(
    candidates: list[_Candidate], durations: Float[np.ndarray, " demonstrations"], notes: list[str]
) -> list[_Candidate]:
    """Drop the weaker of any two candidates that are too close, and those too close to start or end."""
    kept = sorted(candidates, key=lambda candidate: float(candidate.times.mean()))
    while kept:
        times = _sorted_times(kept, durations)
        too_close = (np.diff(times.mean(axis=0)) < LEAST_DISTANCE) | (np.diff(times, axis=1) <= 0).any(axis=0)
        if not too_close.any():
            break
        before = int(np.argmax(too_close)) - 1
        neighbours = [index for index in (before, before + 1) if 0 <= index < len(kept)]
        dropped = kept.pop(min(neighbours, key=lambda index: kept[index].rank))
        notes.append(
            f"{dropped.kind} of {dropped.role} at {dropped.times.mean():.2f} s is too close to a neighbour: no anchor"
        )
    return kept


def warp(
    time: Float[np.ndarray, " *batch"],
    own_anchor_times: Float[np.ndarray, " own_anchors"],
    model_anchor_times: Float[np.ndarray, " model_anchors"],
) -> Float[np.ndarray, " *batch"]:
    """Map times of a demonstration to the model's time axis (swap the anchors for the way back).

    Args:
        time: s; times before the first or after the last anchor are clamped to it.
        own_anchor_times: s, strictly increasing: when the anchors occur in the demonstration.
        model_anchor_times: s, strictly increasing, as many: when they occur in the model.

    Returns:
        Times on the model's axis, s; strictly monotone between the first and the last anchor.

    Raises:
        ValueError: if the anchors do not correspond or do not increase.
    """
    own, model = np.asarray(own_anchor_times, dtype=float), np.asarray(model_anchor_times, dtype=float)
    if own.ndim != 1 or own.shape != model.shape or len(own) < 2:
        raise ValueError(f"anchor times of shapes {own.shape} and {model.shape}; expected two or more, alike")
    if not (np.all(np.diff(own) > 0) and np.all(np.diff(model) > 0)):
        raise ValueError(f"anchor times must increase strictly: {own.tolist()}, {model.tolist()}")
    return np.interp(time, own, model)
