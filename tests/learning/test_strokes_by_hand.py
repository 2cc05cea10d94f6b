"""Strokes of an object: the longest series of reversals that alternate."""

import numpy as np
import pytest

from sbam.demonstrations.events import Event
from sbam.learning.strokes import LEAST_STROKES, strokes

FORTH, BACK, ASIDE = (np.array(v, dtype=float) for v in ([0, 1, 0], [0, -1, 0], [1, 0, 0]))


def reversal(time, direction, role="pin", kind="reversal") -> Event:
    return Event(kind, role, time, direction, 1.0)


@pytest.mark.parametrize(
    ("events", "times"),
    [
        ([], []),
        ([(1.0, FORTH)], [1.0]),
        ([(1.0, FORTH), (2.0, FORTH)], [1.0]),
        ([(1.0, FORTH), (2.0, BACK)], [1.0, 2.0]),
        ([(1.0, FORTH), (2.0, ASIDE), (3.0, BACK), (4.0, FORTH)], [3.0, 4.0]),
        ([(1.0, FORTH), (2.0, BACK), (3.0, FORTH), (4.0, FORTH), (5.0, BACK)], [1.0, 2.0, 3.0]),
        ([(1.0, FORTH), (2.0, BACK), (3.0, BACK), (4.0, FORTH)], [1.0, 2.0]),
    ],
)
def test_the_longest_alternating_series(events, times):
    found = [reversal(time, direction) for time, direction in events]
    assert [event.time for event in strokes(found, "pin")] == times
    # Whatever their order in the list.
    assert [event.time for event in strokes(found[::-1], "pin")] == times


def test_only_reversals_of_the_object_count():
    events = [
        reversal(1.0, FORTH),
        reversal(1.5, BACK, role="cup"),
        reversal(2.0, BACK),
        reversal(2.5, FORTH, kind="tilt"),
        reversal(3.0, FORTH),
    ]
    assert [event.time for event in strokes(events, "pin")] == [1.0, 2.0, 3.0]
    assert [event.time for event in strokes(events, "cup")] == [1.5]
    assert strokes(events, "jug") == ()


@pytest.mark.parametrize(("cosine", "count"), [(-0.31, 2), (-0.29, 1), (0.31, 1)])
def test_directions_alternate_below_a_cosine(cosine, count):
    other = np.array([np.sqrt(1.0 - cosine**2), cosine, 0.0])
    assert len(strokes([reversal(1.0, FORTH), reversal(2.0, other)], "pin")) == count


def test_how_many_make_strokes():
    assert LEAST_STROKES == 4
