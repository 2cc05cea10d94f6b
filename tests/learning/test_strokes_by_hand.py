"""Strokes of an object: the longest series of reversals that alternate."""

import numpy as np
import pytest

from sbam.demonstrations.events import Event
from sbam.learning import LearningSettings
from sbam.learning.sketch import DemonstrationSketch, SketchedRole
from sbam.learning.strokes import LEAST_STROKES, equalize_sketches, strokes

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


def test_the_number_of_strokes_is_the_lower_median():
    """Of 4, 6 and 6 six; of 4, 4, 6 and 6 four: those that lack a cycle are left out."""

    def shown(name, count) -> DemonstrationSketch:
        events = tuple(reversal(1.0 + k, FORTH if k % 2 else BACK) for k in range(count))
        return DemonstrationSketch(name, 10.0, False, (SketchedRole("pin", "a pin", (), True),), events, (), ())

    settings = LearningSettings.default()
    kept, notes = equalize_sketches([shown("a", 4), shown("b", 6), shown("c", 6)], settings)
    assert [sketch.name for sketch in kept] == ["b", "c"]
    assert notes == ("a is left out: 4 reversals of pin, the others have 6",)
    kept, _ = equalize_sketches([shown("a", 4), shown("b", 6), shown("c", 4), shown("d", 6)], settings)
    assert [len(strokes(sketch.events, "pin")) for sketch in kept] == [4, 4, 4, 4]
    assert [sketch.duration for sketch in kept] == [10.0, 8.0, 10.0, 8.0]
