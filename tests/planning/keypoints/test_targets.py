"""Targets in this scene: what people did given where things start; pairs within one object keep its length."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionPair, RegionReference
from sbam.demonstrations.scenes import starting_scene
from sbam.learning.generalization import GeneralizedChange, GeneralizedChannel
from sbam.planning.bind import bind
from sbam.planning.keypoints.targets import (
    START_SPREADS,
    Placement,
    compared_changes,
    pair_target,
    placement_of,
    vector_shift,
)
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task

DEFAULT = PlanSettings()
TIMES = np.linspace(0.0, 1.0, 11)


@pytest.fixture(scope="module", params=["cartesian", "cylindrical", "symbolic"])
def rolling(request, model_of) -> Task:
    return bind(model_of("rolling", request.param), starting_scene("built-in:rolling"))


@pytest.fixture(scope="module")
def pouring(model_of) -> Task:
    return bind(model_of("pouring"), starting_scene("built-in:pouring_new_layout"))


def support_pairs(task):
    return [c for c in task.model.changes if c.pair.second and c.pair.second.affordance == "place onto"]


def learned(second: RegionReference | None, vectors: np.ndarray) -> GeneralizedChange:
    """What is learned from D vectors over time, (D, K, 3)."""
    mean, std = vectors.mean(axis=0), vectors.std(axis=0, ddof=1)
    count = np.full(len(TIMES), len(vectors))
    channels = tuple(
        GeneralizedChannel(name, "m", TIMES, mean[:, i], std[:, i], count) for i, name in enumerate(("x", "y", "z"))
    )
    return GeneralizedChange(RegionPair(RegionReference("thing", "place"), second), "cartesian", channels)


def placement(starts: np.ndarray, follow: np.ndarray, start: np.ndarray, noise: np.ndarray) -> Placement:
    """Of D demonstrations that start at (D, 3) and follow their starts by (K,), executed from (3,)."""
    paths = 0.3 + follow[:, None] * starts[:, None] + noise
    paths[:, 0] = starts
    support = learned(RegionReference("table", "place onto"), paths)
    std = support.at(np.zeros(1))[1][0, :2]
    offset = start - starts.mean(axis=0)
    return Placement((support,), (learned(None, paths - starts[:, None]),), float(np.linalg.norm(std)), offset)


def test_the_slope_is_that_of_a_regression():
    generator = np.random.default_rng(0)
    follow = np.linspace(1.0, 0.0, len(TIMES))
    starts = generator.normal(0.0, 0.05, (9, 3)) * (1.0, 1.0, 0.0)
    start = starts.mean(axis=0) + np.array([0.02, 0.01, 0.0])
    exact = placement(starts, follow, start, np.zeros((9, len(TIMES), 3)))
    np.testing.assert_allclose(exact.slope(TIMES), follow, atol=1e-9)
    np.testing.assert_allclose(exact.further(TIMES), follow[:, None] * exact.offset, atol=1e-9)

    noise = generator.normal(0.0, 0.01, (9, len(TIMES), 3)) * (1.0, 1.0, 0.0)
    noisy = placement(starts, follow, start, noise)
    paths = 0.3 + follow[:, None] * starts[:, None] + noise
    paths[:, 0] = starts
    centered, own = paths - paths.mean(axis=0), starts - starts.mean(axis=0)
    expected = np.einsum("dkc,dc->k", centered, own) / np.square(own).sum()
    np.testing.assert_allclose(noisy.slope(TIMES), expected.clip(0.0, 1.0), atol=1e-9)


def test_all_strokes_follow_the_start_alike():
    """Their slope differs from moment to moment by chance alone, as far as few demonstrations tell."""
    generator = np.random.default_rng(2)
    starts = generator.normal(0.0, 0.05, (9, 3)) * (1.0, 1.0, 0.0)
    noise = generator.normal(0.0, 0.02, (9, len(TIMES), 3)) * (1.0, 1.0, 0.0)
    by_moment = placement(starts, np.full(len(TIMES), 0.4), starts[0], noise)
    rolled = replace(by_moment, strokes=(TIMES[3], TIMES[7]))
    assert np.ptp(by_moment.slope(TIMES)[3:8]) > 0.05
    assert np.ptp(rolled.slope(TIMES)[3:8]) == 0.0
    assert rolled.slope(TIMES)[5] == pytest.approx(
        by_moment.slope(np.linspace(TIMES[3], TIMES[7], 1001)).mean(), abs=1e-3
    )
    np.testing.assert_array_equal(
        np.delete(rolled.slope(TIMES), range(3, 8)), np.delete(by_moment.slope(TIMES), range(3, 8))
    )


def test_strokes_are_those_of_the_model(rolling, pouring):
    reversals = [anchor.time for anchor in rolling.model.anchors if anchor.kind == "reversal"]
    found = placement_of(rolling, RegionReference("handle_left", "handle left"))
    assert found is not None and found.strokes == (reversals[0], reversals[-1])
    poured = placement_of(pouring, RegionReference("pour_from", "pour from"))
    assert poured is not None and poured.strokes is None


def test_a_start_beyond_the_demonstrated_ones_is_followed():
    starts = np.random.default_rng(1).normal(0.0, 0.01, (9, 3)) * (1.0, 1.0, 0.0)
    far = starts.mean(axis=0) + np.array([0.5, 0.0, 0.0])
    stays = placement(starts, np.zeros(len(TIMES)), far, np.zeros((9, len(TIMES), 3)))
    seen = START_SPREADS * np.linalg.norm(starts[:, :2].std(axis=0, ddof=1))
    np.testing.assert_allclose(stays.further(TIMES)[1:], [[0.5 - seen, 0.0, 0.0]] * (len(TIMES) - 1), atol=1e-9)


def test_demonstrations_that_start_alike_are_followed():
    starts = np.tile([0.1, 0.2, 0.0], (3, 1))
    alike = placement(starts, np.zeros(len(TIMES)), np.array([0.3, 0.2, 0.0]), np.zeros((3, len(TIMES), 3)))
    np.testing.assert_array_equal(alike.slope(TIMES), 1.0)
    np.testing.assert_allclose(alike.further(TIMES), [[0.2, 0.0, 0.0]] * len(TIMES), atol=1e-12)


def test_own_start_and_support_agree_on_where_an_object_is_to_be(rolling):
    times = rolling.model.keypoint_times
    supports = [change for change in rolling.model.changes if change.from_agent]
    assert len(supports) == 2  # both handles, in models of every type
    for support in supports:
        own = next(c for c in rolling.model.changes if c.pair.is_own_start and c.pair.first == support.pair.first)
        start = rolling.region_at_start(support.pair.first)
        there = pair_target(rolling, own, times, DEFAULT) + start
        np.testing.assert_allclose(there[:, :2], pair_target(rolling, support, times, DEFAULT)[:, :2], atol=5e-3)


def test_what_own_start_and_support_both_say_counts_once(rolling, pouring):
    for task in (rolling, pouring):
        compared = compared_changes(task, DEFAULT)
        for change in task.model.changes:
            twice = change.pair.is_own_start and change.pair.first in {c.pair.first for c in support_pairs(task)}
            assert any(change is one for one in compared) != twice
        assert len(compared_changes(task, replace(DEFAULT, slide_supports=False))) == len(task.model.changes)


def test_people_roll_before_the_body_wherever_the_pin_lay(rolling):
    held = rolling.model.keypoint_times
    held = held[(held > rolling.moved[0].lift + 1.0) & (held < rolling.moved[0].place - 1.0)]
    found = placement_of(rolling, RegionReference("handle_left", "handle left"))
    assert found is not None
    assert found.slope(held).mean() < 0.6


def test_a_bottle_goes_to_the_cup_and_a_cup_halfway_to_its_place(pouring):
    middle = np.array([0.5 * pouring.model.duration])
    slopes = {}
    for role, affordance in (("pour_from", "pour from"), ("pour_into", "pour into")):
        found = placement_of(pouring, RegionReference(role, affordance))  # which has no support of its own
        assert found is not None
        slopes[role] = found.slope(middle)[0]
        assert found.slope(np.array([0.0, pouring.model.duration])) == pytest.approx(1.0, abs=0.2)
    assert slopes["pour_from"] < 0.3 < slopes["pour_into"] < 0.9


def test_the_plane_is_measured_from_the_agent(pouring):
    """Where the table stands changes nothing but heights."""
    supports = support_pairs(pouring)
    assert supports
    assert all(change.from_agent for change in supports)
    aside = RigidTransform.from_translation([0.1, -0.2, 0.03])
    poses = dict(pouring.T_agent_object)
    poses["kitchen_sideboard"] = aside * poses["kitchen_sideboard"]
    moved = replace(pouring, T_agent_object=poses)
    for change in pouring.model.changes:
        first, second = change.pair.first, change.pair.second
        shift = vector_shift(pouring, change)
        if change not in supports:
            assert not shift.any()
            continue
        assert second is not None
        vector = pouring.region_at_start(first) - pouring.region_at_start(second) + shift
        np.testing.assert_allclose(vector[:2], pouring.region_at_start(first)[:2])
        again = moved.region_at_start(first) - moved.region_at_start(second) + vector_shift(moved, change)
        np.testing.assert_allclose(again, vector - [0.0, 0.0, 0.03], atol=1e-12)


def test_learned_means_are_left_alone_on_request(pouring):
    off = replace(DEFAULT, slide_supports=False, rigid_length=False)
    for change in pouring.model.changes:
        times = pouring.model.keypoint_times
        np.testing.assert_array_equal(pair_target(pouring, change, times, off), change.at(times)[0])


def test_pairs_within_one_object_get_its_length_and_keep_their_direction(pouring):
    times = pouring.model.keypoint_times
    for change in pouring.model.changes:
        if not change.pair.is_same_object:
            continue
        mean = change.at(times)[0]
        target = pair_target(pouring, change, times, DEFAULT)
        length = np.linalg.norm(pouring.region_center(change.pair.first) - pouring.region_center(change.pair.second))
        np.testing.assert_allclose(np.linalg.norm(target, axis=1), length)
        np.testing.assert_allclose(np.cross(target, mean), 0.0, atol=1e-12)
        assert (np.sum(target * mean, axis=1) > 0.0).all()


def test_mode_paper_takes_what_was_learned(model_of):
    task = bind(model_of("pouring", mode="paper"), starting_scene("built-in:pouring_new_layout"))
    for change in task.model.changes:
        times = task.model.keypoint_times
        np.testing.assert_array_equal(pair_target(task, change, times, DEFAULT), change.at(times)[0])
        assert not vector_shift(task, change).any()
