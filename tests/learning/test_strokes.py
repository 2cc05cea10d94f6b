"""Strokes are counted and whole cycles cut."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration, Label
from sbam.demonstrations.events import find_events
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.anchors import align_events
from sbam.learning.strokes import cut, equalize_strokes, strokes


def rolling(count, seed=0, rate=100.0):
    """A pin that rolls forward and back ``count`` times, after a way to the dough and before a way back."""
    random = np.random.default_rng(seed)
    halves = 0.5 + 0.04 * random.uniform(-1, 1, 2 * count)
    times = np.concatenate([[0.0, 1.0, 2.0], 2.0 + np.cumsum(halves)])
    places = np.zeros((len(times) + 2, 3))
    places[2 : len(times), 1] = (
        0.3 + 0.14 * (np.arange(2 * count + 1) % 2) + 0.01 * random.uniform(-1, 1, 2 * count + 1)
    )
    places[2 : len(times), 0] = 0.1
    times = np.concatenate([times, times[-1] + [1.0, 2.0]])
    time = np.arange(0, times[-1], 1 / rate)
    piece = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2)
    phase = (time - times[piece]) / (times[piece + 1] - times[piece])
    blend = (phase**3 * (10 - 15 * phase + 6 * phase**2))[:, None]
    position = places[piece] + blend * (places[piece + 1] - places[piece])
    pin = RigidTransform.from_components(position, Rotation.identity(len(time)))
    return Demonstration(
        name=f"rolling_{count}_{seed}",
        time=time,
        T_world_object={"rolling_pin": pin},
        T_world_hand={"left": pin},
        T_world_agent=RigidTransform.identity(),
        labels=(Label("left", 0.0, 2.0, "lift"), Label("left", 2.0, float(time[-1]), "roll out")),
    )


def counted(demonstration):
    return len(strokes(find_events(demonstration), "rolling_pin"))


def equalize(demonstrations):
    return equalize_strokes(demonstrations, [find_events(item) for item in demonstrations])


@pytest.mark.parametrize("rate", [100.0, 30.0])
def test_longer_ones_are_cut_and_shorter_ones_left_out(rate):
    counts = (5, 4, 6, 5, 7, 5)
    given = [rolling(count, seed, rate) for seed, count in enumerate(counts)]
    result = equalize(given)
    assert result.kept == (0, 2, 3, 4, 5)
    reference = counted(given[0])
    assert [counted(item) for item in result.demonstrations] == [reference] * 5
    assert [item is given[index] for item, index in zip(result.demonstrations, result.kept, strict=True)] == [
        True,
        False,
        True,
        False,
        True,
    ]
    assert any("rolling_4_1 is left out" in note for note in result.notes)
    assert any("rolling_6_2: 1 of" in note for note in result.notes)
    assert any("rolling_7_4: 2 of" in note for note in result.notes)
    assert len(result.notes) == 3
    for item in result.demonstrations:
        assert np.all(np.diff(item.time) > 0)
        assert item.time[0] == 0
        step = np.linalg.norm(np.diff(item.T_world_object["rolling_pin"].translation, axis=0), axis=1)
        # 0.55 m/s is the top speed of a stroke; a cut may add a jump of a few millimetres.
        assert step.max() < 0.55 / rate + 0.008
    anchors = align_events(
        [find_events(item) for item in result.demonstrations], [i.duration for i in result.demonstrations]
    )
    assert Counter(anchors.kinds)["reversal"] == reference


def test_equal_numbers_and_tasks_without_strokes_are_left_alone():
    for given in (
        [rolling(4, seed) for seed in range(3)],
        list(built_in_demonstrations("rolling", 0)),
        list(built_in_demonstrations("pouring", 0)),
    ):
        result = equalize(given)
        assert all(item is other for item, other in zip(result.demonstrations, given, strict=True))
        assert result.kept == tuple(range(len(given)))
        assert result.notes == ()


def test_roles_bind_objects_of_different_names():
    given = [rolling(4, 0), rolling(5, 1), rolling(4, 2)]
    given[1] = replace(given[1], T_world_object={"other_pin": given[1].T_world_object["rolling_pin"]})
    roles = [{"rolling_pin": "pin"}, {"other_pin": "pin"}, {"rolling_pin": "pin"}]
    result = equalize_strokes(given, [find_events(item) for item in given], roles)
    assert len(result.notes) == 1
    assert len(strokes(find_events(result.demonstrations[1]), "other_pin")) == counted(given[0])


def test_only_alternating_reversals_are_strokes():
    events = find_events(rolling(4))
    found = strokes(events, "rolling_pin")
    broken = [replace(event, descriptor=found[2].descriptor) if event is found[3] else event for event in events]
    assert len(strokes(broken, "rolling_pin")) < len(found)
    assert strokes(events, "cup_small") == ()


def test_a_cut_shortens_everything_alike():
    given = rolling(4)
    first, second = 250, 350
    result = cut(given, first, second)
    assert result.duration == pytest.approx(given.duration - 1.0)
    np.testing.assert_allclose(np.diff(result.time), 0.01, atol=1e-9)
    for poses, before in (
        (result.T_world_object["rolling_pin"], given.T_world_object["rolling_pin"]),
        (result.T_world_hand["left"], given.T_world_hand["left"]),
    ):
        np.testing.assert_array_equal(poses.translation[: first + 1], before.translation[: first + 1])
        np.testing.assert_array_equal(poses.translation[first + 1 :], before.translation[second + 1 :])
    assert [(label.start, label.end) for label in result.labels] == [(0.0, 2.0), (2.0, pytest.approx(result.duration))]
    assert "2.50 to 3.50 s cut" in result.notes
    within = replace(given, labels=(Label("left", 2.6, 3.4, "roll out"),))
    assert cut(within, first, second).labels == ()
