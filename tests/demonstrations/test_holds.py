"""Holds found in motions made here, in built-in recordings, and in real ones against the labels people gave."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.holds import find_holds
from sbam.demonstrations.readers import read_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations

UPRIGHT = Rotation.from_euler("x", 90, degrees=True)
AWAY_LEFT, AWAY_RIGHT = np.array([-0.5, -0.3, 0.1]), np.array([0.5, -0.3, 0.1])
GRIP = np.array([0.0, -0.06, 0.08])
TIME = np.arange(0, 8, 0.01)


def path(knot_times, knots, time=TIME):
    """Minimum-jerk path through the knots, at rest at each."""
    knot_times, knots = np.asarray(knot_times, dtype=float), np.asarray(knots, dtype=float)
    piece = np.clip(np.searchsorted(knot_times, time, side="right") - 1, 0, len(knot_times) - 2)
    phase = np.clip((time - knot_times[piece]) / (knot_times[piece + 1] - knot_times[piece]), 0, 1)
    blend = phase**3 * (10 - 15 * phase + 6 * phase**2)
    return knots[piece] + blend[:, None] * (knots[piece + 1] - knots[piece])


def poses(position):
    return RigidTransform.from_components(position, Rotation.concatenate([UPRIGHT] * len(position)))


def demonstration(objects, hands, time=TIME):
    return Demonstration(
        name="made",
        time=time,
        T_world_object={name: poses(position) for name, position in objects.items()},
        T_world_hand={hand: poses(position) for hand, position in hands.items()},
        T_world_agent=RigidTransform.identity(),
    )


def carried(hand="right"):
    """The hand comes at 1 to 2 s, carries the carton at 2.5 to 5 s, waits and leaves at 6 s; the other rests."""
    box = path([0, 2.5, 5, 9], [[0, 0, 0], [0, 0, 0], [0.3, 0.1, 0.1], [0.3, 0.1, 0.1]])
    away = AWAY_RIGHT if hand == "right" else AWAY_LEFT
    come = path([0, 1, 2, 9], [away, away, GRIP, GRIP])
    leave = path([0, 6, 7, 9], [GRIP, GRIP, away, away])
    other = np.tile(AWAY_LEFT if hand == "right" else AWAY_RIGHT, (len(TIME), 1))
    moving = np.where((TIME < 4)[:, None], come, leave) + box
    return demonstration({"milk_small": box}, {hand: moving, "left" if hand == "right" else "right": other})


@pytest.mark.parametrize("hand", ["left", "right"])
def test_the_hand_that_goes_along_holds(hand):
    (hold,) = find_holds(carried(hand))
    assert (hold.hand, hold.object) == (hand, "milk_small")
    # Minimum jerk: 2 mm from rest after 11 % of the motion; 80 mm/s after 11 % of the hand's.
    assert hold.start == pytest.approx(2.6, abs=0.15)
    assert hold.end == pytest.approx(6.1, abs=0.1)
    assert hold.T_object_hand is not None
    np.testing.assert_allclose(hold.T_object_hand.translation, UPRIGHT.inv().apply(GRIP), atol=1e-6)
    np.testing.assert_allclose(hold.T_object_hand.rotation.magnitude(), 0, atol=1e-9)
    assert hold.spread < 0.005


@settings(max_examples=10, deadline=None)
@given(yaw=st.floats(-180, 180), x=st.floats(-2, 2), delay=st.floats(0, 2))
def test_holds_do_not_depend_on_where_and_when(yaw, x, delay):
    recording = carried()
    T = RigidTransform.from_components([x, 1.0, 0.9], Rotation.from_euler("z", yaw, degrees=True))
    wait = round(delay / 0.01)
    index = np.maximum(np.arange(len(TIME) + wait) - wait, 0)
    moved = replace(
        recording,
        time=np.arange(len(index)) * 0.01,
        T_world_object={name: T * item[index] for name, item in recording.T_world_object.items()},
        T_world_hand={hand: T * item[index] for hand, item in recording.T_world_hand.items()},
    )
    (hold,), (other,) = find_holds(recording), find_holds(moved)
    assert (other.hand, other.object) == (hold.hand, hold.object)
    assert [other.start, other.end] == pytest.approx([hold.start + wait * 0.01, hold.end + wait * 0.01], abs=0.03)


def test_both_hands_hold_one_object():
    pin = path([0, 2, 3, 4, 5, 9], [[0, 0, 0], [0, 0, 0], [0, 0.2, 0], [0, 0, 0], [0, 0.2, 0], [0, 0.2, 0]])
    hands = {}
    for hand, side in (("left", -1), ("right", 1)):
        grip, away = np.array([0.2 * side, 0, 0.04]), np.array([0.4 * side, -0.4, 0.1])
        come, leave = path([0, 1, 1.8, 9], [away, away, grip, grip]), path([0, 5.5, 6.5, 9], [grip, grip, away, away])
        hands[hand] = np.where((TIME < 4)[:, None], come, leave) + pin
    recording = demonstration({}, hands)
    recording = replace(
        recording, T_world_object={"rolling_pin": RigidTransform.from_components(pin, Rotation.identity(len(TIME)))}
    )
    holds = find_holds(recording)
    assert {(hold.hand, hold.object) for hold in holds} == {("left", "rolling_pin"), ("right", "rolling_pin")}
    assert [hold.start for hold in holds] == pytest.approx([2.1, 2.1], abs=0.15)
    assert [hold.end for hold in holds] == pytest.approx([5.6, 5.6], abs=0.15)


def test_an_object_is_handed_over():
    box = path([0, 2, 3.5, 4.5, 6, 9], [[0, 0, 0], [0, 0, 0], [0.3, 0, 0.2], [0.3, 0, 0.2], [0.6, 0, 0], [0.6, 0, 0]])
    left_grip, right_grip = np.array([-0.06, 0, 0.05]), np.array([0.06, 0, 0.05])
    away = np.array([0.9, -0.4, 0.3])
    giving = path([0, 1, 1.8, 4.1, 5, 9], [AWAY_LEFT, AWAY_LEFT, left_grip, left_grip, AWAY_LEFT, AWAY_LEFT]) + box
    taking = path([0, 2.8, 3.8, 6.5, 7.5, 9], [away, away, right_grip, right_grip, away, away]) + box
    holds = find_holds(demonstration({"milk_small": box}, {"left": giving, "right": taking}))
    assert [hold.hand for hold in holds] == ["left", "right"]
    assert holds[0].start == pytest.approx(2.1, abs=0.15)
    assert holds[0].end == pytest.approx(4.2, abs=0.15)
    assert 3.5 < holds[1].start < 4.7
    assert holds[1].end == pytest.approx(6.6, abs=0.15)


def test_an_object_that_stays_is_held_while_the_hand_stays_at_it():
    still = np.zeros((len(TIME), 3))
    hand = path([0, 1, 2, 5, 6, 9], [AWAY_RIGHT, AWAY_RIGHT, GRIP, GRIP, AWAY_RIGHT, AWAY_RIGHT])
    (hold,) = find_holds(demonstration({"apple_juice": still}, {"right": hand}))
    assert (hold.hand, hold.object) == ("right", "apple_juice")
    assert [hold.start, hold.end] == pytest.approx([1.9, 5.1], abs=0.15)
    # A hand that merely rests there, or passes, holds nothing; nobody holds furniture.
    rests = path([0, 5, 6, 9], [GRIP, GRIP, AWAY_RIGHT, AWAY_RIGHT])
    assert find_holds(demonstration({"apple_juice": still}, {"right": rests})) == ()
    passes = path([0, 1, 2, 9], [AWAY_RIGHT, AWAY_RIGHT, AWAY_LEFT, AWAY_LEFT])
    assert find_holds(demonstration({"apple_juice": still}, {"right": passes})) == ()
    assert find_holds(demonstration({"kitchen_sideboard": still}, {"right": hand})) == ()


def test_a_glitch_of_a_hand_ends_no_hold():
    recording = carried()
    position = recording.T_world_hand["right"].translation.copy()
    position[[300, 420]] += 0.2
    damaged = replace(recording, T_world_hand={**recording.T_world_hand, "right": poses(position)})
    (hold,), (other,) = find_holds(recording), find_holds(damaged)
    assert [other.start, other.end] == pytest.approx([hold.start, hold.end], abs=0.02)


def test_without_hands_an_object_is_held_while_it_moves():
    (hold,) = find_holds(replace(carried(), T_world_hand={}))
    assert hold.hand is None
    assert hold.T_object_hand is None
    assert [hold.start, hold.end] == pytest.approx([2.7, 4.8], abs=0.2)


@pytest.mark.parametrize("task", ["pouring", "rolling"])
def test_built_in_recordings(task):
    for recording in built_in_demonstrations(task, 0):
        holds = {(hold.hand, hold.object): hold for hold in find_holds(recording)}
        if task == "rolling":
            assert set(holds) == {("left", "rolling_pin"), ("right", "rolling_pin")}
        else:
            cup = next(name for name in recording.objects if name.startswith("cup"))
            vessel = next(name for name in recording.objects if name in ("apple_juice", "milk_small"))
            assert set(holds) == {("left", cup), ("right", vessel)}
        for (hand, _), hold in holds.items():
            actions = {label.action: label for label in recording.labels if label.hand == hand}
            assert hold.start == pytest.approx(actions["Approach"].end, abs=0.18)
            assert hold.end == pytest.approx(actions["Retreat"].start, abs=0.18)
            assert hold.spread < 0.04


def test_real_recordings_against_their_labels(recordings_folder):
    expected = {
        "Pour": {("left", "cup_small"), ("right", "milk_small")},
        "RollOut": {("left", "rolling_pin"), ("right", "rolling_pin")},
        "Stir": {("left", "cup_large"), ("right", "tablespoon")},
        "Close": {("left", "apple_juice_lid"), ("right", "apple_juice")},
    }
    grasp_errors, release_errors = [], []
    for action, held in expected.items():
        recording = read_demonstration(next((recordings_folder / "kit_bimanual").glob(f"{action}_*.xml")))
        holds = find_holds(recording)
        assert {(hold.hand, hold.object) for hold in holds} == held
        assert len(holds) == len(held)
        for hold in holds:
            labels = [label for label in recording.labels if label.hand == hold.hand]
            approach = min(label.end for label in labels if label.action == "Approach")
            retreat = max(label.start for label in labels if label.action == "Retreat")
            grasp_errors.append(abs(hold.start - approach))
            release_errors.append(abs(hold.end - retreat))
    # The labels are given to 0.1 s; the bottle that is held without being moved is the worst.
    assert np.mean(grasp_errors) < 0.1
    assert max(grasp_errors) < 0.3
    assert np.mean(release_errors) < 0.08
    assert max(release_errors) < 0.2


def test_real_recordings_without_hands(recordings_folder):
    for path_ in sorted((recordings_folder / "mmlfd_pouring").glob("*.csv")):
        recording = read_demonstration(path_)
        (hold,) = find_holds(recording)
        assert (hold.hand, hold.object, hold.start) == (None, "bottle", 0.0)
        assert hold.end == pytest.approx(recording.duration)
