"""Strokes, and unequal numbers of them: whole cycles are cut from the longer demonstrations before time is aligned.

What is cut are the sketches, so that demonstrations can still be added later.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from sbam.constraints import constraint_type
from sbam.demonstrations.events import Event
from sbam.learning.settings import LearningSettings
from sbam.learning.sketch import ChannelCandidates, DemonstrationSketch

ALTERNATION = -0.3
"""Strokes are reversals whose changes of direction have a cosine below this from one to the next."""
LEAST_STROKES = 4
"""Fewer alternating reversals than this are no strokes, and nothing is cut."""


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


def equalize_sketches(
    sketches: Sequence[DemonstrationSketch], settings: LearningSettings
) -> tuple[tuple[DemonstrationSketch, ...], tuple[str, ...]]:
    """Bring all sketches to the median number of strokes.

    A demonstration with more is shortened by whole cycles (two reversals), each cut between two turning points where
    the constraints are most alike. One that lacks a whole cycle is left out. A difference of a single reversal is no
    cycle; it is left to the alignment of events. The result does not depend on the order of the demonstrations.

    Args:
        sketches: D demonstrations.
        settings: amplitude floors.

    Returns:
        The sketches that stay, longer ones cut, and what was cut or left out, a sentence each.
    """
    current = list(sketches)
    notes: list[str] = []
    for role in sorted({role.role for sketch in sketches for role in sketch.roles}):
        counts = [len(strokes(sketch.events, role)) for sketch in current]
        target = sorted(counts)[(len(counts) - 1) // 2]
        if target < LEAST_STROKES:
            continue
        kept = []
        for sketch, count in zip(current, counts, strict=True):
            if count <= target - 2:
                notes.append(f"{sketch.name} is left out: {count} reversals of {role}, the others have {target}")
                continue
            cycles = (count - target) // 2
            for _ in range(cycles):
                sketch = _without_cycle(sketch, role, settings)
            if cycles:
                notes.append(f"{sketch.name}: {cycles} of {count // 2} cycles of {role} cut to match the others")
            kept.append(sketch)
        current = kept
    return tuple(current), tuple(notes)


def _without_cycle(sketch: DemonstrationSketch, role: str, settings: LearningSettings) -> DemonstrationSketch:
    turning = np.array([event.time for event in strokes(sketch.events, role)])
    jump = np.zeros(len(turning) - 2)
    for pair in sketch.candidates:
        units = constraint_type(pair.constraint).channel_units
        for unit, channel in zip(units, pair.channels, strict=True):
            amplitude = max(float(np.ptp(channel.value)), settings.amplitude_floor(unit))
            value = np.interp(turning, channel.time, channel.value) / amplitude
            jump += (value[2:] - value[:-2]) ** 2
    cycle = int(jump.argmin())
    return cut_sketch(sketch, float(turning[cycle]), float(turning[cycle + 2]))


def cut_sketch(sketch: DemonstrationSketch, start: float, end: float) -> DemonstrationSketch:
    """Remove what is after ``start`` up to and including ``end`` (s); what follows moves forward in time.

    Polylines go on from their value at ``start``, so that a small jump spreads over the next segment.
    """

    def moved(time: float) -> float:
        return time if time <= start else max(start, time - (end - start))

    def cut_channel(channel: ChannelCandidates) -> ChannelCandidates:
        before, after = channel.time < start, channel.time > end
        return ChannelCandidates(
            np.concatenate([channel.time[before], [start], channel.time[after] - (end - start)]),
            np.concatenate(
                [
                    channel.value[before],
                    [np.interp(start, channel.time, channel.value)],
                    channel.value[after],
                ]
            ),
        )

    return replace(
        sketch,
        duration=sketch.duration - (end - start),
        events=tuple(
            replace(event, time=moved(event.time)) for event in sketch.events if not start < event.time <= end
        ),
        holds=tuple(replace(hold, grasp=moved(hold.grasp), release=moved(hold.release)) for hold in sketch.holds),
        candidates=tuple(
            replace(pair, channels=tuple(cut_channel(channel) for channel in pair.channels))
            for pair in sketch.candidates
        ),
    )
