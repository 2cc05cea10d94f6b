"""Alignment of events: an independent oracle, properties, and what is found in built-in and real demonstrations."""

import itertools
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.events import Event, find_events
from sbam.demonstrations.readers import read_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.anchors import LEAST_DISTANCE, align_events, align_in_order, locate_anchors

ONE = np.ones(1)
FORTH, BACK = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])


def event(kind, role, time, descriptor=ONE, strength=1.0):
    return Event(kind, role, time, descriptor, strength)


def pour(lift, tilt, back, place, role="vessel"):
    return [
        event("lift", role, lift),
        event("tilt", role, tilt),
        event("tilt", role, back, -ONE),
        event("place", role, place),
    ]


def carry(lift, place, role="cup"):
    return [event("lift", role, lift), event("place", role, place)]


def labels(anchors):
    return list(zip(anchors.kinds, anchors.roles, strict=True))


def least_cost(cost, gap):
    """Oracle: all alignments, by recursion."""

    @cache
    def rest(i, j):
        if i == cost.shape[0] or j == cost.shape[1]:
            return gap * (cost.shape[0] - i + cost.shape[1] - j)
        return min(cost[i, j] + rest(i + 1, j + 1), gap + rest(i + 1, j), gap + rest(i, j + 1))

    return rest(0, 0)


@given(
    st.integers(0, 6),
    st.integers(0, 6),
    st.integers(0, 2**32 - 1),
    st.floats(0.05, 1.0),
)
def test_alignment_is_ordered_and_costs_least(rows, columns, seed, gap):
    random = np.random.default_rng(seed)
    cost = random.uniform(0, 2, (rows, columns))
    cost[random.uniform(size=cost.shape) < 0.2] = np.inf
    partners, total = align_in_order(cost, gap)
    assert total == pytest.approx(least_cost(cost, gap))
    assert total == pytest.approx(sum(cost[i, j] for i, j in partners) + gap * (rows + columns - 2 * len(partners)))
    assert all(a < c and b < d for (a, b), (c, d) in itertools.pairwise(partners))


def test_what_recurs_becomes_an_anchor_and_what_does_not_is_left():
    first = pour(1.0, 2.0, 4.0, 5.0)
    second = [*pour(1.4, 2.3, 4.4, 5.2), event("reversal", "vessel", 3.0, FORTH)]
    anchors = align_events([first, second], [6.0, 7.0])
    assert labels(anchors) == [
        ("start", None),
        ("lift", "vessel"),
        ("tilt", "vessel"),
        ("tilt", "vessel"),
        ("place", "vessel"),
        ("end", None),
    ]
    np.testing.assert_allclose(anchors.times, [[0, 1, 2, 4, 5, 6], [0, 1.4, 2.3, 4.4, 5.2, 7]])
    np.testing.assert_allclose(anchors.mean_times, [0, 1.2, 2.15, 4.2, 5.1, 6.5])


def test_a_missing_stroke_leaves_the_right_gap():
    def strokes(*turns):
        directions = [FORTH if index % 2 else BACK for index in range(9)]
        reversals = [event("reversal", "pin", 1.5 + 0.5 * k, directions[k], 0.5) for k in turns]
        return [event("lift", "pin", 1.0), *reversals, event("place", "pin", 6.5)]

    anchors = align_events([strokes(*range(9)), strokes(*range(9)), strokes(0, 1, 2, 3, 5, 6, 7, 8)], [8.0] * 3)
    np.testing.assert_allclose(anchors.times[0], [0, 1, 1.5, 2, 2.5, 3, 4, 4.5, 5, 5.5, 6.5, 8])
    np.testing.assert_allclose(anchors.times, anchors.times[:1].repeat(3, axis=0))


def test_opposite_directions_are_no_partners():
    first = [*carry(1, 5, "pin"), event("reversal", "pin", 3, FORTH)]
    second = [*carry(1, 5, "pin"), event("reversal", "pin", 3, BACK)]
    assert "reversal" not in align_events([first, second], [6.0, 6.0]).kinds


def test_one_demonstration_has_all_its_events_as_anchors():
    anchors = align_events([[*pour(1, 2, 4, 5), *carry(0.5, 5.5)]], [7.0])
    np.testing.assert_allclose(anchors.times, [[0, 0.5, 1, 2, 4, 5, 5.5, 7]])
    assert anchors.notes == ()


def test_hands_may_swap_order():
    anchors = align_events(
        [[*carry(1.0, 5.0, "cup"), *carry(2.0, 6.0, "vessel")], [*carry(1.9, 5.0, "cup"), *carry(1.3, 6.0, "vessel")]],
        [7.0, 7.0],
    )
    assert Counter(labels(anchors)[1:3]) == Counter([("lift", "cup"), ("lift", "vessel")])
    np.testing.assert_allclose(anchors.times, [[0, 1, 2, 5, 6, 7], [0, 1.3, 1.9, 5, 6, 7]])


def test_events_that_coincide_in_one_demonstration_are_moved_apart():
    anchors = align_events(
        [[*carry(1, 5, "cup"), *carry(2, 5, "vessel")], [*carry(1, 5, "cup"), *carry(1, 6, "vessel")]], [5.0, 7.0]
    )
    assert Counter(anchors.kinds)["lift"] == 2
    assert np.all(np.diff(anchors.times, axis=1) > 0)
    np.testing.assert_allclose(anchors.times[1], [0, 1, 1, 5, 6, 7], atol=0.011)


def test_of_two_close_anchors_the_weaker_is_dropped_and_said():
    events = [*carry(1, 5), event("reversal", "cup", 3.0, FORTH, 0.4), *pour(2, 3.05, 4, 5.5)]
    anchors = align_events([events], [7.0])
    assert "reversal" not in anchors.kinds
    assert ("tilt", "vessel") in labels(anchors)
    assert any("reversal of cup at 3.00 s" in note for note in anchors.notes)


def test_anchors_at_the_edges_give_way_to_start_and_end():
    anchors = align_events([pour(0.0, 1, 3, 4.0), pour(0.0, 1.2, 3, 4.5)], [4.0, 4.5])
    assert anchors.kinds == ("start", "tilt", "tilt", "end")


def test_without_recurring_lift_and_place_only_start_and_end_stay_and_it_is_said():
    for events in ([[], carry(1, 2)], [[event("lift", "cup", 1.0)], carry(1, 2)], [[], []]):
        anchors = align_events(events, [4.0, 5.0])
        np.testing.assert_allclose(anchors.times, [[0, 4], [0, 5]])
        assert any("start and end only" in note for note in anchors.notes)
    assert any("moves in 1 of 2" in note for note in align_events([[], carry(1, 2)], [4.0, 5.0]).notes)


def test_numbers_of_sequences_and_durations_must_agree():
    with pytest.raises(ValueError, match="expected one each"):
        align_events([[]], [1.0, 2.0])
    with pytest.raises(ValueError, match="expected one each"):
        align_events([], [])


def test_anchors_are_located_in_another_demonstration():
    anchors = align_events([[*pour(2, 3, 5, 6), *carry(1, 6.5)]], [8.0])
    other = [*pour(1.5, 2.5, 5.5, 6.2), event("reversal", "vessel", 4, FORTH), *carry(1.6, 5.7)]
    found = locate_anchors(anchors.kinds, anchors.roles, anchors.mean_times, other, 7.5)
    np.testing.assert_allclose(found, [0, 1.5, 1.6, 2.5, 5.5, 5.7, 6.2, 7.5])
    without_tilt = [item for item in other if item.kind != "tilt"]
    found = locate_anchors(anchors.kinds, anchors.roles, anchors.mean_times, without_tilt, 7.5)
    np.testing.assert_allclose(found, [0, 1.5, 1.6, 1.6 + 4.1 / 4, 1.6 + 3 * 4.1 / 4, 5.7, 6.2, 7.5])
    found = locate_anchors(anchors.kinds, anchors.roles, anchors.mean_times, [], 4.0)
    np.testing.assert_allclose(found, anchors.mean_times / 2)


def role_events(demonstration):
    """Events with roles named by the kind of object."""
    roles = {"cup": "cup", "juice": "vessel", "milk": "vessel", "pin": "pin", "bottle": "vessel"}
    return [
        replace(event, object=next(role for part, role in roles.items() if part in event.object))
        for event in find_events(demonstration)
    ]


def align(demonstrations):
    return align_events([role_events(item) for item in demonstrations], [item.duration for item in demonstrations])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_built_in_pouring(seed):
    demonstrations = built_in_demonstrations("pouring", seed)
    anchors = align(demonstrations)
    found = Counter(labels(anchors))
    for role, kind in (("cup", "lift"), ("cup", "place"), ("vessel", "lift"), ("vessel", "place")):
        assert found[kind, role] == 1
    assert found["tilt", "vessel"] == 2
    assert len(anchors.kinds) == 2 + 6
    assert np.all(np.diff(anchors.times, axis=1) > 0)
    assert np.all(np.diff(anchors.mean_times) >= LEAST_DISTANCE)
    np.testing.assert_allclose(anchors.times[:, -1], [item.duration for item in demonstrations])

    for demonstration, own in zip(demonstrations, anchors.times, strict=True):
        found = locate_anchors(
            anchors.kinds, anchors.roles, anchors.mean_times, role_events(demonstration), demonstration.duration
        )
        np.testing.assert_allclose(found, own, atol=0.02)

    other = align(demonstrations[::-1])
    assert labels(other) == labels(anchors)
    np.testing.assert_allclose(other.times[::-1], anchors.times)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_built_in_rolling(seed):
    anchors = align(built_in_demonstrations("rolling", seed))
    assert anchors.kinds == ("start", "lift", *["reversal"] * 9, "place", "end")


@pytest.mark.parametrize("task", ["pouring", "rolling"])
def test_noise_of_a_millimetre_changes_no_anchor(task):
    random = np.random.default_rng(3)

    def shaken(demonstration):
        return replace(
            demonstration,
            T_world_object={
                name: RigidTransform.from_components(
                    poses.translation + 0.001 * random.standard_normal((len(poses), 3)), poses.rotation
                )
                for name, poses in demonstration.T_world_object.items()
            },
        )

    demonstrations = built_in_demonstrations(task, 0)[:6]
    clean, noisy = align(demonstrations), align([shaken(item) for item in demonstrations])
    assert Counter(labels(noisy)) == Counter(labels(clean))
    np.testing.assert_allclose(noisy.mean_times, clean.mean_times, atol=0.05)


def test_real_pours_together(recordings_folder):
    paths = sorted((recordings_folder / "mmlfd_pouring").glob("*.csv"))
    anchors = align([read_demonstration(path) for path in paths])
    assert labels(anchors) == [("start", None), ("tilt", "vessel"), ("tilt", "vessel"), ("end", None)]
    assert anchors.times.shape == (5, 4)


def test_the_real_rolling_has_the_anchors_of_the_built_in_ones(recordings_folder):
    real = read_demonstration(next((recordings_folder / "kit_bimanual").glob("RollOut_*.xml")))
    anchors = align([*built_in_demonstrations("rolling", 0), real])
    assert anchors.kinds == ("start", "lift", *["reversal"] * 9, "place", "end")
