"""Targets in this scene: supports slide, pairs within one object keep its length."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.constraints import constraint_type
from sbam.demonstrations.scenes import starting_scene
from sbam.planning.settings import PlanSettings
from sbam.planning.targets import START_SPREADS, pair_target, start_share, support_slide, vector_std
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


def test_a_support_slides_by_what_the_demonstrations_tell(rolling):
    for change in support_pairs(rolling):
        before = rolling.region_at_start(change.pair.first) - rolling.region_at_start(change.pair.second)
        learned = constraint_type(change.constraint).vector(change.at(np.zeros(1))[0])[0]
        off = (learned - before)[:2]
        seen = START_SPREADS * np.linalg.norm(vector_std(change, np.zeros(1))[0, :2])
        share = max(start_share(rolling, change), 1.0 - seen / np.linalg.norm(off))
        assert share > 0.5  # people roll where the pin lay
        np.testing.assert_allclose(support_slide(rolling, change, DEFAULT), [*(share * off), 0.0], atol=1e-9)


@pytest.mark.parametrize("constraint", ["cartesian", "cylindrical"])
def test_channels_tell_how_much_a_vector_varies(model_of, constraint):
    """By drawing channels and looking at their vectors."""
    generator = np.random.default_rng(0)
    for change in model_of("rolling", constraint).changes:
        if change.pair.second is None or change.pair.second.affordance != "place onto":
            continue
        mean, std = change.at(np.zeros(1))
        drawn = constraint_type(change.constraint).vector(mean + std * generator.normal(size=(20000, std.shape[1])))
        estimated, exact = (np.linalg.norm(one[:2]) for one in (vector_std(change, np.zeros(1))[0], drawn.std(axis=0)))
        assert estimated == pytest.approx(exact, rel=0.1)


def test_pouring_goes_to_its_place_rather_than_where_the_bottle_stood(pouring):
    shares = {c.pair.first.role: start_share(pouring, c) for c in support_pairs(pouring)}
    assert shares["pour_from"] < 0.3 < shares["pour_into"] < 0.9


def test_only_supports_slide_and_only_if_wanted(pouring):
    supports = support_pairs(pouring)
    assert supports
    aside = RigidTransform.from_translation([1.0, 0.0, 0.0])
    far = replace(pouring, T_agent_object={name: aside * pose for name, pose in pouring.T_agent_object.items()})
    far.T_agent_object["kitchen_sideboard"] = pouring.T_agent_object["kitchen_sideboard"]
    for change in pouring.model.changes:
        assert np.any(support_slide(far, change, DEFAULT)) == (change in supports)
        assert not np.any(support_slide(far, change, replace(DEFAULT, slide_supports=False)))


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
