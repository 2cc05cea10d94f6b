"""Targets in this scene: supports slide, pairs within one object keep its length."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import constraint_type
from sbam.demonstrations.scenes import starting_scene
from sbam.planning.settings import PlanSettings
from sbam.planning.targets import START_SPREADS, pair_target, start_spread, support_slide
from sbam.planning.task import Task, bind

DEFAULT = PlanSettings()


@pytest.fixture(scope="module", params=["cartesian", "cylindrical", "symbolic"])
def rolling(request, model_of) -> Task:
    return bind(model_of("rolling", request.param), starting_scene("built-in:rolling"))


@pytest.fixture(scope="module")
def pouring(model_of) -> Task:
    return bind(model_of("pouring"), starting_scene("built-in:pouring_new_layout"))


def support_pairs(task):
    return [c for c in task.model.changes if c.pair.second and c.pair.second.affordance == "place onto"]


def test_a_support_slides_until_the_pair_starts_within_the_demonstrated_spread(rolling):
    for change in support_pairs(rolling):
        before = rolling.region_at_start(change.pair.first) - rolling.region_at_start(change.pair.second)
        shift = support_slide(rolling, change, DEFAULT)
        learned = constraint_type(change.constraint).vector(change.at(np.zeros(1))[0])[0]
        allowed = START_SPREADS * start_spread(change)
        off, left = np.linalg.norm((learned - before)[:2]), np.linalg.norm((learned - before - shift)[:2])
        assert left == pytest.approx(min(off, allowed), abs=1e-9)
        assert shift[2] == 0.0


def test_the_spread_of_cartesian_starts_is_their_standard_deviation(model_of):
    for change in model_of("pouring").changes:
        std = change.at(np.zeros(1))[1][0]
        assert start_spread(change) == pytest.approx(np.hypot(std[0], std[1]))


def test_only_supports_slide_and_only_if_wanted(pouring):
    supports = support_pairs(pouring)
    assert supports
    aside = RigidTransform.from_translation([1.0, 0.0, 0.0])
    far = replace(pouring, T_agent_object={name: aside * pose for name, pose in pouring.T_agent_object.items()})
    far.T_agent_object["kitchen_sideboard"] = pouring.T_agent_object["kitchen_sideboard"]
    for change in pouring.model.changes:
        assert np.any(support_slide(far, change, DEFAULT)) == (change in supports)
        assert not np.any(support_slide(far, change, replace(DEFAULT, slide_supports=False)))
        # Between the three demonstrated layouts nothing slides.
        assert not np.any(support_slide(pouring, change, DEFAULT))


def test_pairs_within_one_object_get_its_length_and_keep_their_direction(pouring):
    times = pouring.model.keypoint_times
    for change in pouring.model.changes:
        mean = change.at(times)[0]
        target = pair_target(pouring, change, times, DEFAULT)
        np.testing.assert_array_equal(pair_target(pouring, change, times, replace(DEFAULT, rigid_length=False)), mean)
        if not change.pair.is_same_object:
            np.testing.assert_array_equal(target, mean)
            continue
        length = np.linalg.norm(pouring.region_center(change.pair.first) - pouring.region_center(change.pair.second))
        np.testing.assert_allclose(np.linalg.norm(target, axis=1), length)
        np.testing.assert_allclose(np.cross(target, mean), 0.0, atol=1e-12)
        assert (np.sum(target * mean, axis=1) > 0.0).all()


def test_mode_paper_takes_what_was_learned(model_of):
    task = bind(model_of("pouring", mode="paper"), starting_scene("built-in:pouring_new_layout"))
    for change in task.model.changes:
        times = task.model.keypoint_times
        np.testing.assert_array_equal(pair_target(task, change, times, DEFAULT), change.at(times)[0])
        assert not support_slide(task, change, DEFAULT).any()
