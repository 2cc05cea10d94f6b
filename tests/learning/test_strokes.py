from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sbam.robots
from sbam.demonstrations.events import Event
from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import generate_rolling
from sbam.learning import LearningSettings, add_demonstration, learn
from sbam.learning.strokes import cut_sketch, equalize_sketches, strokes
from sbam.planning.plan import plan
from sbam.tasks import measure_rolling

FLYING_HANDS = Path(sbam.robots.__file__).parent / "models" / "flying_hands.yaml"
SETTINGS = LearningSettings.default()


@pytest.fixture(scope="module")
def unequal():
    return [generate_rolling(seed, strokes=count) for seed, count in enumerate((5, 5, 6, 5, 3))]


def reversals(sketch):
    return len(strokes(sketch.events, "handle_left"))


def test_longer_ones_are_cut_and_shorter_ones_left_out(unequal):
    sketches = learn(unequal).demonstrations
    counts = [reversals(sketch) for sketch in sketches]
    assert counts[2] >= counts[0] + 2 > counts[4] + 2
    kept, notes = equalize_sketches(sketches, SETTINGS)
    assert [sketch.name for sketch in kept] == [sketch.name for sketch in sketches[:4]]
    assert max(map(reversals, kept)) - min(map(reversals, kept)) <= 1
    assert any("left out" in note and sketches[4].name in note for note in notes)
    assert any("cut" in note and sketches[2].name in note for note in notes)
    assert kept[0] is sketches[0]
    cut = kept[2]
    assert cut.duration < sketches[2].duration
    for pair in cut.candidates:
        for channel in pair.channels:
            assert np.all(np.diff(channel.time) > 0)
            assert channel.time[-1] == pytest.approx(cut.duration)


def test_the_model_has_the_strokes_of_most_demonstrations(unequal):
    model, equal = learn(unequal), learn([unequal[i] for i in (0, 1, 3)])
    count = sum(anchor.kind == "reversal" for anchor in equal.anchors)
    assert count >= 8
    assert sum(anchor.kind == "reversal" for anchor in model.anchors) == pytest.approx(count, abs=1)
    assert any("left out" in note for note in model.notes)
    assert len(model.demonstrations) == 5
    amplitudes = []
    for one in (model, equal):
        change = next(c for c in one.changes if c.pair.is_own_start)
        mean, _ = change.at(one.keypoint_times)
        amplitudes.append(np.abs(np.diff(mean[:, 1])).sum())
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=0.15)


def test_adding_is_learning_at_once(unequal):
    model = learn(unequal[:3])
    for demonstration in unequal[3:]:
        model = add_demonstration(model, demonstration)
    again = learn(unequal)
    np.testing.assert_array_equal(model.keypoint_times, again.keypoint_times)
    for one, other in zip(model.changes, again.changes, strict=True):
        for channel, copy in zip(one.channels, other.channels, strict=True):
            np.testing.assert_array_equal(channel.mean, copy.mean)
            np.testing.assert_array_equal(channel.std, copy.std)


def test_a_cut_removes_what_is_between(unequal):
    sketch = learn(unequal[:1]).demonstrations[0]
    turning = [event.time for event in strokes(sketch.events, "handle_left")]
    cut = cut_sketch(sketch, turning[1], turning[3])
    length = turning[3] - turning[1]
    assert cut.duration == pytest.approx(sketch.duration - length)
    assert reversals(cut) == reversals(sketch) - 2
    for hold, before in zip(cut.holds, sketch.holds, strict=True):
        assert hold.grasp == before.grasp and hold.release == pytest.approx(before.release - length)


def test_a_cut_changes_no_more_than_the_channels_of_a_pair(unequal):
    sketch = learn(unequal[:1]).demonstrations[0]
    before = [replace(pair, channels=()) for pair in sketch.candidates]
    assert any(pair.from_agent for pair in before)
    assert [replace(pair, channels=()) for pair in cut_sketch(sketch, 3.0, 4.0).candidates] == before


@pytest.mark.parametrize(("learned", "added"), [((5, 5, 5, 7), ()), ((7, 5, 5, 5), ()), ((5, 5, 5), (6,))])
def test_all_strokes_are_planned_whichever_demonstration_was_cut(learned, added):
    counts = (*learned, *added)
    demonstrations = [generate_rolling(seed, strokes=count) for seed, count in enumerate(counts)]
    model = learn(demonstrations[: len(learned)])
    for demonstration in demonstrations[len(learned) :]:
        model = add_demonstration(model, demonstration)
    assert any("cut to match" in note for note in model.notes)
    planned = plan(model, starting_scene("built-in:rolling"), FLYING_HANDS)
    assert planned.ok, planned.problems
    measure = measure_rolling(planned)
    assert measure.ok, measure.problems
    assert measure.values["half-strokes"] == 8


def test_without_strokes_nothing_changes(pouring):
    sketches = learn(pouring[:2]).demonstrations
    kept, notes = equalize_sketches(sketches, SETTINGS)
    assert kept == sketches and notes == ()


def reversal(time, along, name="pin"):
    """A reversal in which the direction changes along y."""
    return Event("reversal", name, time, np.array([0.0, along, 0.0]), 1.0)


def test_strokes_are_the_longest_series_of_alternating_reversals():
    to_and_fro = [reversal(time, (-1.0) ** time) for time in range(6)]
    assert strokes(to_and_fro, "pin") == tuple(to_and_fro)
    assert strokes(to_and_fro[::-1], "pin") == tuple(to_and_fro)
    assert strokes(to_and_fro, "cup") == ()
    twice_alike = [*to_and_fro[:4], reversal(3.5, (-1.0) ** 3), *to_and_fro[4:]]
    assert strokes(twice_alike, "pin") == tuple(to_and_fro[:4])
    others = [reversal(0.5, -1.0, "cup"), Event("tilt", "pin", 2.5, np.array([1.0]), 1.0)]
    assert strokes([*to_and_fro, *others], "pin") == tuple(to_and_fro)
