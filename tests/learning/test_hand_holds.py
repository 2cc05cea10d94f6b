"""Mean holds on the model's time axis, worked out by hand."""

import numpy as np
import pytest

from sbam.demonstrations.events import Event
from sbam.learning.anchors import AnchorSet
from sbam.learning.hand_holds import hand_holds
from sbam.learning.sketch import DemonstrationSketch, SketchedHold

ONE = np.ones(1)


def sketch(name, duration, events, holds) -> DemonstrationSketch:
    found = tuple(Event(kind, role, time, ONE, 1.0) for kind, role, time in events)
    return DemonstrationSketch(name, duration, False, (), found, tuple(holds), ())


def hold(role, hand, grasp, release, position=None, side=0.0) -> SketchedHold:
    return SketchedHold(role, hand, grasp, release, None if position is None else np.array(position), side)


def ends(*durations) -> AnchorSet:
    """Time is stretched from start to end."""
    return AnchorSet(("start", "end"), (None, None), np.array([[0.0, duration] for duration in durations]))


def test_mean_times_on_the_model_s_axis():
    """10 s long in the model: 2 of 8 s are 2.5, 3 of 12 s are 2.5 as well; 6 of 8 s are 7.5, 9.6 of 12 s are 8."""
    sketches = [
        sketch("a", 8.0, (), [hold("cup", "left", 2.0, 6.0, [0.0, 0.0, 0.1])]),
        sketch("b", 12.0, (), [hold("cup", "left", 3.0, 9.6, [0.0, 0.2, 0.1])]),
    ]
    (found,) = hand_holds(sketches, ends(8.0, 12.0), np.array([0.0, 10.0]))
    assert (found.role, found.hand) == ("cup", "left")
    assert (found.grasp, found.release) == (pytest.approx(2.5), pytest.approx(7.75))
    np.testing.assert_array_equal(found.hand_position, [[0.0, 0.0, 0.1], [0.0, 0.2, 0.1]])


def test_in_order_of_grasps_then_of_roles_and_hands():
    holds = [
        hold("pin", "right", 3.0, 5.0),
        hold("pin", "left", 3.0, 6.0),
        hold("cup", "right", 3.0, 4.0),
        hold("jug", "left", 1.0, 2.0),
    ]
    found = hand_holds([sketch("a", 10.0, (), holds)], ends(10.0), np.array([0.0, 10.0]))
    assert [(one.role, one.hand) for one in found] == [
        ("jug", "left"),
        ("cup", "right"),
        ("pin", "left"),
        ("pin", "right"),
    ]
    assert [one.hand_position.shape for one in found] == [(0, 3)] * 4


def test_several_holds_of_one_hand_are_one_with_the_longest_s_position():
    holds = [
        hold("cup", "left", 4.0, 8.0, [0.4, 0.0, 0.0]),
        hold("cup", "left", 1.0, 2.0, [0.1, 0.0, 0.0]),
        hold("cup", "left", 8.5, 9.0, [0.5, 0.0, 0.0]),
    ]
    (found,) = hand_holds([sketch("a", 10.0, (), holds)], ends(10.0), np.array([0.0, 10.0]))
    assert (found.grasp, found.release) == (1.0, 9.0)
    np.testing.assert_array_equal(found.hand_position, [[0.4, 0.0, 0.0]])


def test_a_grasp_is_no_later_than_the_lift_and_a_release_no_earlier_than_the_place():
    """Of the same demonstration, and in the mean of the model's anchors."""
    events = (("lift", "cup", 2.0), ("place", "cup", 7.0), ("lift", "jug", 1.0), ("place", "jug", 9.0))
    own = [hold("cup", "left", 2.5, 6.0), hold("jug", "right", 0.5, 9.5)]
    (jug, cup) = hand_holds([sketch("a", 10.0, events, own)], ends(10.0), np.array([0.0, 10.0]))
    assert (cup.grasp, cup.release) == (2.0, 7.0)
    assert (jug.grasp, jug.release) == (0.5, 9.5)
    anchors = AnchorSet(
        ("start", "lift", "place", "end"), (None, "cup", "cup", None), np.array([[0.0, 2.0, 7.0, 10.0]])
    )
    without = sketch("b", 10.0, (), [hold("cup", "left", 2.5, 6.0)])
    (cup,) = hand_holds([without], anchors, np.array([0.0, 1.5, 7.5, 10.0]))
    assert (cup.grasp, cup.release) == (1.5, 7.5)


@pytest.mark.parametrize(("showing", "kept"), [(1, False), (2, False), (3, True)])
def test_more_than_half_must_show_a_hold(showing, kept):
    sketches = [
        sketch(str(number), 10.0, (), [hold("cup", "left", 2.0, 6.0)] if number < showing else [])
        for number in range(4)
    ]
    assert bool(hand_holds(sketches, ends(*[10.0] * 4), np.array([0.0, 10.0]))) == kept


@pytest.mark.parametrize(
    ("sides", "hand"), [((-0.2, -0.1, 0.3), "left"), ((-0.2, 0.1, 0.3), "right"), ((0.0, 0.0, 0.0), "right")]
)
def test_without_hands_the_side_of_most_tells_which(sides, hand):
    sketches = [
        sketch(str(number), 10.0, (), [hold("cup", None, 2.0, 6.0, side=side)]) for number, side in enumerate(sides)
    ]
    (found,) = hand_holds(sketches, ends(10.0, 10.0, 10.0), np.array([0.0, 10.0]))
    assert found.hand == hand
