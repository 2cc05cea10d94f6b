"""What is kept of a demonstration: when it is looked at, and what is measured against what."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference
from sbam.learning import LearningSettings, learn
from sbam.learning.sketch import DemonstrationSketch, SketchedRole, constraint_values


@pytest.fixture(scope="module")
def sketch(pouring) -> DemonstrationSketch:
    return learn(pouring[:1]).demonstrations[0]


def test_demonstrations_are_thinned_and_events_stay(sketch):
    """12.5 Hz in mode ``default``, of 100; a candidate is at one of these times or at an event."""
    rate = LearningSettings.default().segmentation_rate
    assert rate == 12.5
    grid = np.linspace(0.0, sketch.duration, round(rate * sketch.duration) + 1)
    events = np.array([event.time for event in sketch.events])
    seen = set()
    for pair in sketch.candidates:
        for channel in pair.channels:
            assert (channel.time[0], channel.time[-1]) == (0.0, pytest.approx(sketch.duration))
            known = np.concatenate([grid, events])
            assert np.abs(channel.time[:, None] - known).min(axis=1).max() < 1e-9
            assert (
                np.abs(channel.time[:, None] - events[(events > 0) & (events < sketch.duration)]).min(axis=0).max() == 0
            )
            seen |= set(channel.time.tolist())
    assert 5 < len(seen) < len(grid) + len(events)


def test_what_is_measured_against_its_own_start_begins_at_zero(sketch):
    own = [pair for pair in sketch.candidates if pair.pair.is_own_start]
    assert own
    for pair in own:
        assert [channel.value[0] for channel in pair.channels] == [0.0, 0.0, 0.0]
        assert max(np.ptp(channel.value) for channel in pair.channels) > 0.05


def test_the_own_start_is_that_of_the_first_frame(pouring):
    """Of an object that is on its way from the beginning, 2 cm/s to the right."""
    recording = pouring[0]
    drift = 0.02 * (recording.time - recording.time[0])[:, None] * (recording.T_world_agent.rotation.apply([1.0, 0, 0]))
    moving = {
        name: RigidTransform.from_components(pose.translation + drift, pose.rotation)
        for name, pose in recording.T_world_object.items()
    }
    sketch = learn([replace(recording, T_world_object=moving)]).demonstrations[0]
    x = [pair.channels[0] for pair in sketch.candidates if pair.pair.is_own_start]
    assert x
    for channel in x:
        assert channel.value[0] == 0.0
        assert np.interp(0.2, channel.time, channel.value) == pytest.approx(0.004, abs=1e-3)


def test_values_are_those_of_the_recording(sketch, pouring):
    """At the start, by the objects' poses, which both pairs and places at the start are made of."""
    for pair in sketch.candidates:
        first = sketch.region_at_start(pair.pair.first)
        second = None if pair.pair.second is None else sketch.region_at_start(pair.pair.second)
        if second is None or pair.from_agent:
            continue
        np.testing.assert_allclose([c.value[0] for c in pair.channels], first - second, atol=1e-9)


def test_mode_paper_keeps_no_candidates_of_demonstrations(pouring):
    model = learn(pouring[:2], mode="paper")
    assert [one.candidates for one in model.demonstrations] == [(), ()]
    assert all(one.events and one.roles for one in model.demonstrations)


def test_the_first_event_of_a_kind_counts():
    from sbam.demonstrations.events import Event

    events = tuple(
        Event(kind, role, time, np.ones(1), 1.0)
        for kind, role, time in (
            ("lift", "jug", 1.0),
            ("lift", "cup", 2.0),
            ("lift", "cup", 5.0),
            ("place", "cup", 6.0),
        )
    )
    start = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    roles = (SketchedRole("jug", "a", ("place",), True), SketchedRole("cup", "b", ("fill", "place"), True, start))
    one = DemonstrationSketch("one", 8.0, False, roles, events, (), ())
    assert one.event_time("lift", "cup") == 2.0
    assert one.event_time("place", "cup") == 6.0
    assert one.event_time("place", "jug") is None
    assert one.region_at_start(RegionReference("cup", "place")).tolist() == [0.4, 0.5, 0.6]
    assert one.region_at_start(RegionReference("cup", "fill")).tolist() == [0.1, 0.2, 0.3]
    assert one.region_at_start(RegionReference("cup", "pour")) is None
    assert one.region_at_start(RegionReference("jug", "place")) is None
    assert one.region_at_start(RegionReference("pan", "place")) is None


def test_azimuths_go_on_beyond_half_a_turn():
    angle = np.linspace(0.0, 3.0 * np.pi, 60)
    d = np.stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), np.full(60, 0.1)], axis=1)
    values = constraint_values("cylindrical", d)
    np.testing.assert_allclose(values, np.stack([np.full(60, 0.2), angle, np.full(60, 0.1)], axis=1), atol=1e-9)
