"""Demonstrations in different orders are not averaged; the scene's layout chooses."""

from dataclasses import replace

import numpy as np
import pytest

import sbam
from sbam.constraints import RegionReference
from sbam.demonstrations.events import Event, EventKind
from sbam.learning.learn import variant_for
from sbam.learning.sketch import DemonstrationSketch
from sbam.learning.variants import CLEAR, nearest_layout, order_groups
from sbam.planning.task import bind

DEMONSTRATIONS = sbam.built_in_demonstrations("pouring")
LEFT = {demonstration.name for demonstration in DEMONSTRATIONS if "left" in demonstration.name}


def sketch(lag: float | None, place_lag: float = 0.0) -> DemonstrationSketch:
    """Two objects, the second lifted ``lag`` after the first, placed ``place_lag`` after it; None: never."""
    times: list[tuple[EventKind, str, float]] = [("lift", "a", 2.0), ("place", "a", 8.0)]
    if lag is not None:
        times.append(("lift", "b", 2.0 + lag))
        times.append(("place", "b", 8.0 + place_lag))
    events = tuple(Event(kind, role, time, np.array([1.0, 0.0, 0.0]), 1.0) for kind, role, time in times)
    return DemonstrationSketch("x", 10.0, True, (), events, (), ())


@pytest.fixture(scope="module")
def model():
    return sbam.learn(DEMONSTRATIONS)


def starts(scene, model):
    task = bind(model, scene)
    regions = [RegionReference(role.name, affordance) for role in model.roles for affordance in role.affordances]
    return {region: task.region_at_start(region) for region in regions}


def names(model):
    return {demonstration.name for demonstration in model.demonstrations}


def test_orders_that_are_clearly_swapped_are_groups():
    groups = order_groups([sketch(0.4), sketch(-0.6), sketch(0.1), sketch(-1.0)])
    assert groups[0] == groups[2] != groups[1] == groups[3]


@pytest.mark.parametrize(
    "lags",
    [
        (0.2, 0.4, 0.1, 0.9),  # one order
        (0.2, -0.2, 0.1, -0.1),  # at about the same time, in any order
        (0.4, -1.0, 0.1, 0.3),  # a single exception
        (0.4, None, -1.0, -0.9),  # one demonstration lacks the object
    ],
)
def test_others_are_not(lags):
    assert not order_groups([sketch(lag) for lag in lags]).any()


def test_the_order_of_placing_counts_as_well():
    assert order_groups([sketch(0.1, lag) for lag in (-1.0, 0.2, -0.8, 0.3)]).any()
    assert not order_groups([sketch(0.1, lag) for lag in (-0.5 * CLEAR, 0.2, -0.8, 0.3)]).any()


def test_too_small_groups_are_not_split():
    lags = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]  # each order alone is shown twice, both once
    assert not order_groups([sketch(*both) for both in lags]).any()


def test_the_bottle_beyond_the_cup_is_another_order(model):
    groups = order_groups(model.demonstrations)
    assert {s.name for s, group in zip(model.demonstrations, groups, strict=True) if group == groups[6]} == LEFT


@pytest.mark.parametrize("demonstration", DEMONSTRATIONS, ids=lambda demonstration: demonstration.name)
def test_each_layout_finds_its_own_order(model, demonstration):
    variant = variant_for(model, starts(sbam.scene_from_demonstration(demonstration), model))
    assert bind(model, sbam.scene_from_demonstration(demonstration)).notes == variant.notes[-1:]
    assert (demonstration.name in LEFT) == (names(variant) == LEFT)
    assert demonstration.name in names(variant)
    assert str(len(variant.demonstrations)) in variant.notes[-1]
    assert demonstration.name in variant.notes[-1]


def test_a_variant_is_what_its_demonstrations_alone_would_teach(model):
    scene = sbam.load_scene("built-in:pouring_new_layout")
    variant = variant_for(model, starts(scene, model))
    alone = sbam.learn([d for d in DEMONSTRATIONS if d.name in names(variant)])
    assert len(variant.demonstrations) < len(model.demonstrations)
    np.testing.assert_array_equal(variant.keypoint_times, alone.keypoint_times)
    for one, other in zip(variant.changes, alone.changes, strict=True):
        assert one.pair == other.pair
        for mine, theirs in zip(one.channels, other.channels, strict=True):
            np.testing.assert_array_equal(mine.mean, theirs.mean)


def test_only_the_layout_counts_not_where_it_stands(model):
    scene = sbam.load_scene("built-in:pouring_new_layout")
    moved = {role: at + np.array([0.4, -0.2, 0.1]) for role, at in starts(scene, model).items()}
    assert names(variant_for(model, moved)) == names(variant_for(model, starts(scene, model)))


def test_it_can_be_switched_off_and_needs_what_it_compares(model):
    scene = sbam.load_scene("built-in:pouring_new_layout")
    off = replace(model, settings=replace(model.settings, variants=False))
    assert variant_for(off, starts(scene, model)) is off
    assert variant_for(model, {}) is model
    kept = tuple(replace(s, roles=tuple(replace(role, start=None) for role in s.roles)) for s in model.demonstrations)
    earlier = replace(model, demonstrations=kept)  # a model that an earlier version wrote
    assert variant_for(earlier, starts(scene, model)) is earlier


def test_one_object_has_no_layout():
    rolling = sbam.learn(sbam.built_in_demonstrations("rolling"))
    where = starts(sbam.load_scene("built-in:rolling"), rolling)
    assert nearest_layout(rolling.demonstrations, where) is None
    assert variant_for(rolling, where) is rolling


def test_a_file_keeps_where_things_stood(model, tmp_path):
    sbam.save_model(model, tmp_path / "model.json")
    scene = sbam.load_scene("built-in:pouring_new_layout")
    read = sbam.load_model(tmp_path / "model.json")
    assert names(variant_for(read, starts(scene, model))) == names(variant_for(model, starts(scene, model)))
    for sketched, demonstration in zip(read.demonstrations, DEMONSTRATIONS, strict=True):
        for role in sketched.roles:
            pose = demonstration.T_world_agent.inv() * demonstration.T_world_object[role.object][0]
            object_model = sbam.ObjectLibrary.built_in()[role.object]
            centers = np.array([object_model.region(affordance).center for affordance in role.affordances])
            assert role.start is not None
            np.testing.assert_allclose(role.start, pose.apply(centers))
