"""Events found in motions whose events are known by construction, in built-in and in real recordings."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import Event, find_events, object_axis, objects_that_move
from sbam.demonstrations.readers import read_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.scene.object_library import ObjectLibrary

UPRIGHT = Rotation.from_euler("x", 90, degrees=True)
"""The library's cups and bottles have their +y up."""


def minimum_jerk(time, knot_times, knots):
    """Through the knots (K, C), at rest at each."""
    knot_times, knots = np.asarray(knot_times, dtype=float), np.asarray(knots, dtype=float)
    piece = np.clip(np.searchsorted(knot_times, time, side="right") - 1, 0, len(knot_times) - 2)
    start, end = knot_times[piece], knot_times[piece + 1]
    phase = np.clip((time - start) / (end - start), 0, 1)
    blend = phase**3 * (10 - 15 * phase + 6 * phase**2)
    return knots[piece] + blend[:, None] * (knots[piece + 1] - knots[piece])


def demonstration(time, position, rotation=None, name="milk_small", T_world_agent=None):
    time = np.asarray(time, dtype=float)
    rotation = Rotation.concatenate([UPRIGHT] * len(time)) if rotation is None else rotation
    return Demonstration(
        name="made",
        time=time,
        T_world_object={name: RigidTransform.from_components(position, rotation)},
        T_world_hand={},
        T_world_agent=RigidTransform.identity() if T_world_agent is None else T_world_agent,
    )


def pour(rate=100.0, idle=1.0, stretch=1.0, noise=0.0, time=None):
    """Lift at ``idle``, tilt about x by 80 degrees and back, place 5 s (times ``stretch``) later."""
    duration = idle + 6.0 * stretch
    time = np.arange(0, duration + 0.5 / rate, 1 / rate) if time is None else time
    knots = idle + stretch * np.array([0.0, 1.5, 3.5, 5.0])
    position = minimum_jerk(
        time, [-1, *knots, 99], [[0, 0, 0], [0, 0, 0], [0.2, 0, 0.2], [0.2, 0, 0.2], [0, 0, 0], [0, 0, 0]]
    )
    tilts = idle + stretch * np.array([1.5, 2.3, 2.7, 3.5])
    angle = minimum_jerk(time, [-1, *tilts, 99], [[0], [0], [80], [80], [0], [0]])
    random = np.random.default_rng(1)
    position = position + noise * random.standard_normal(position.shape)
    return demonstration(time, position, Rotation.from_euler("x", angle, degrees=True) * UPRIGHT)


def zigzag(strokes, rate=100.0, half_period=0.5, time=None):
    """Forward and back along y, ``strokes`` times, from 1 s on."""
    turns = 1.0 + half_period * np.arange(2 * strokes + 1)
    places = np.where(np.arange(2 * strokes + 1)[:, None] % 2, [[0, 0.14, 0]], [[0, 0, 0]])
    time = np.arange(0, turns[-1] + 1 + 0.5 / rate, 1 / rate) if time is None else time
    position = minimum_jerk(time, [-1, *turns, 99], [places[0], *places, places[-1]])
    return demonstration(time, position), turns


def summary(events):
    return [(event.kind, round(event.time, 1)) for event in events]


def kinds(events):
    return [event.kind for event in events]


def test_a_pour_is_lift_two_tilts_and_place():
    events = find_events(pour())
    assert kinds(events) == ["lift", "tilt", "tilt", "place"]
    assert [event.time for event in events] == pytest.approx([1.0, 2.9, 4.1, 6.0], abs=0.2)
    assert [event.time for event in events[1:3]] == pytest.approx([2.9, 4.1], abs=0.02)
    assert [event.descriptor.tolist() for event in events[1:3]] == [[1.0], [-1.0]]
    assert all(0 < event.strength <= 1 for event in events)
    assert objects_that_move(pour()) == ("milk_small",)


def test_strokes_are_reversals_where_the_direction_turns():
    recording, turns = zigzag(5)
    events = find_events(recording)
    assert kinds(events) == ["lift", *["reversal"] * 9, "place"]
    assert [event.time for event in events[1:-1]] == pytest.approx(turns[1:-1], abs=0.01)
    for index, event in enumerate(events[1:-1]):
        np.testing.assert_allclose(event.descriptor, [0, (-1) ** (index + 1), 0], atol=0.05)


@pytest.mark.parametrize("make", [pour, lambda **kw: zigzag(4, **kw)[0]])
def test_the_rate_does_not_matter(make):
    reference = find_events(make())
    uneven = np.sort(np.random.default_rng(0).uniform(0, make().time[-1], 300))
    uneven[0] = 0.0
    for other in (make(rate=10.0), make(rate=240.0), make(time=uneven)):
        events = find_events(other)
        assert kinds(events) == kinds(reference)
        assert [e.time for e in events] == pytest.approx([e.time for e in reference], abs=0.12)


@settings(max_examples=15, deadline=None)
@given(idle=st.floats(0.5, 4.0), stretch=st.floats(0.7, 1.6))
def test_events_move_and_stretch_with_time(idle, stretch):
    reference = find_events(pour())
    events = find_events(pour(idle=idle, stretch=stretch))
    assert kinds(events) == kinds(reference)
    expected = [idle + stretch * (event.time - 1.0) for event in reference]
    assert [event.time for event in events] == pytest.approx(expected, abs=0.1)


@settings(max_examples=15, deadline=None)
@given(yaw=st.floats(-180, 180), x=st.floats(-2, 2), y=st.floats(-2, 2))
def test_events_do_not_depend_on_where_the_world_is(yaw, x, y):
    recording, _ = zigzag(3)
    T = RigidTransform.from_components([x, y, 0.9], Rotation.from_euler("z", yaw, degrees=True))
    moved = replace(
        recording,
        T_world_object={name: T * poses for name, poses in recording.T_world_object.items()},
        T_world_agent=T * recording.T_world_agent,
    )
    for event, other in zip(find_events(recording), find_events(moved), strict=True):
        assert event.kind == other.kind
        assert event.time == pytest.approx(other.time, abs=0.011)
        np.testing.assert_allclose(event.descriptor, other.descriptor, atol=1e-3)


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_noise_of_a_millimetre_changes_nothing(rate):
    clean, noisy = find_events(pour(rate=rate)), find_events(pour(rate=rate, noise=0.001))
    assert kinds(noisy) == kinds(clean)
    assert [event.time for event in noisy] == pytest.approx([event.time for event in clean], abs=0.1)


@pytest.mark.parametrize(("rate", "jump"), [(100.0, 0.3), (100.0, 0.03), (10.0, 0.1), (10.0, 0.3)])
def test_a_glitch_of_the_tracker_is_no_event(rate, jump):
    time = np.arange(0, 5, 1 / rate)
    position = np.zeros((len(time), 3))
    position[len(time) // 2] = jump
    angle = np.zeros((len(time), 1))
    angle[len(time) // 2] = 60
    rotation = Rotation.from_euler("x", angle, degrees=True) * UPRIGHT
    assert find_events(demonstration(time, position, rotation)) == ()

    recording = pour(rate=rate)
    poses = recording.T_world_object["milk_small"]
    position = poses.translation.copy()
    position[int(0.5 * rate)] += jump
    position[int(3.5 * rate)] += jump
    damaged = replace(
        recording, T_world_object={"milk_small": RigidTransform.from_components(position, poses.rotation)}
    )
    assert summary(find_events(damaged)) == summary(find_events(recording))


def test_an_object_that_is_never_at_rest_moves_from_first_to_last_frame():
    recording = pour()
    middle = (recording.time > 1.4) & (recording.time < 5.6)
    cut = replace(
        recording,
        time=recording.time[middle] - recording.time[middle][0],
        T_world_object={name: poses[middle] for name, poses in recording.T_world_object.items()},
    )
    events = find_events(cut)
    assert kinds(events) == ["lift", "tilt", "tilt", "place"]
    assert events[0].time == 0.0
    assert events[-1].time == pytest.approx(cut.time[-1])


def test_turning_about_the_line_of_the_regions_is_no_tilt():
    time = np.arange(0, 5, 0.01)
    position = minimum_jerk(time, [-1, 1, 3, 99], [[0, 0, 0], [0, 0, 0], [0.3, 0, 0], [0.3, 0, 0]])
    angle = minimum_jerk(time, [-1, 1, 2, 99], [[0], [0], [90], [90]])
    roll, yaw = (Rotation.from_euler(axis, angle, degrees=True) for axis in "xz")
    assert kinds(find_events(demonstration(time, position, roll, "rolling_pin"))) == ["lift", "place"]
    assert kinds(find_events(demonstration(time, position, yaw, "rolling_pin"))) == ["lift", "tilt", "place"]
    assert kinds(find_events(demonstration(time, position, yaw * UPRIGHT, "milk_small"))) == ["lift", "place"]


def test_axes_of_objects():
    library = ObjectLibrary.built_in()
    up = Rotation.from_euler("y", [[90], [0]], degrees=True)
    np.testing.assert_allclose(object_axis(library["milk_small"], up), [0, 1, 0], atol=0.1)
    np.testing.assert_allclose(np.abs(object_axis(library["rolling_pin"], up)), [1, 0, 0], atol=1e-9)
    np.testing.assert_allclose(object_axis(library["kitchen_sideboard"], up), library["kitchen_sideboard"].up)
    np.testing.assert_allclose(object_axis(None, up), [-1, 0, 0], atol=1e-9)


@pytest.mark.parametrize("frames", [2, 3, 7])
def test_very_short_recordings_have_no_events(frames):
    time = np.linspace(0, 0.01 * frames, frames)
    assert find_events(demonstration(time, np.zeros((frames, 3)))) == ()


def test_unknown_objects_have_events_too():
    recording = pour()
    unknown = replace(recording, T_world_object={"thermos": recording.T_world_object["milk_small"]})
    assert kinds(find_events(unknown)) == ["lift", "tilt", "tilt", "place"]


@pytest.mark.parametrize("seed", [0, 1])
def test_built_in_recordings_show_what_they_were_made_from(seed):
    for recording in built_in_demonstrations("pouring", seed):
        moved = Counter((event.kind, event.object) for event in find_events(recording))
        cup, vessel = (
            next(n for n in recording.objects if part in n)
            for part in ("cup", "ju" if "juice" in recording.name else "milk")
        )
        assert [moved["lift", name] + moved["place", name] for name in (cup, vessel)] == [2, 2]
        assert moved["tilt", vessel] == 2
        assert moved["tilt", cup] == 0
    for recording in built_in_demonstrations("rolling", seed):
        assert kinds(find_events(recording)) == ["lift", *["reversal"] * 9, "place"]


def kinds_of(events: tuple[Event, ...], name: str) -> list[str]:
    return [event.kind for event in events if event.object == name]


def test_real_kit_recordings(recordings_folder):
    folder = recordings_folder / "kit_bimanual"
    events = find_events(read_demonstration(next(folder.glob("Pour_*.xml"))))
    assert Counter(kinds_of(events, "milk_small")) == {"lift": 1, "tilt": 2, "place": 1}
    assert Counter(kinds_of(events, "cup_small")) == {"lift": 1, "reversal": 1, "place": 1}
    # Labels of the recording: the carton is held from 1.7 to 5.6 s and poured from at 2.8 to 4.2 s.
    times = [event.time for event in events if event.object == "milk_small"]
    assert times == pytest.approx([1.7, 2.5, 4.5, 5.4], abs=0.2)
    events = find_events(read_demonstration(next(folder.glob("RollOut_*.xml"))))
    assert kinds(events) == ["lift", *["reversal"] * 9, "place"]


def test_real_pours_that_start_and_end_in_the_air(recordings_folder):
    paths = sorted((recordings_folder / "mmlfd_pouring").glob("*.csv"))
    assert len(paths) == 5
    for path in paths:
        recording = read_demonstration(path)
        events = find_events(recording)
        assert {event.object for event in events} == {"bottle"}
        assert events[0].kind == "lift"
        assert events[0].time == 0.0
        assert events[-1].kind == "place"
        assert events[-1].time == pytest.approx(recording.duration)
        assert [event.descriptor.tolist() for event in events if event.kind == "tilt"] == [[1.0], [-1.0]]
