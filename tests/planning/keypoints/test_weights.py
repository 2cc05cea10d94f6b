"""What counts when there is but one demonstration, and how that fades."""

import numpy as np
import pytest

from sbam.constraints import constraint_type
from sbam.planning.keypoints.weights import pair_weights


@pytest.fixture(scope="module")
def single(model_of):
    """Learned from one demonstration: all deviations are zero."""
    from sbam.demonstrations.synthetic import built_in_demonstrations
    from sbam.learning.learn import learn

    return learn(built_in_demonstrations("pouring")[:1])


def change_of(model, first, second):
    return next(
        c
        for c in model.changes
        if c.pair.first.affordance == first
        and ((second is None and c.pair.is_own_start) or (c.pair.second and c.pair.second.affordance == second))
        and (second is not None or c.pair.first.role == "pour_from")
    )


def test_with_one_demonstration_the_nearer_pair_counts_more(single):
    middle = np.array([0.5 * single.duration])
    relation = change_of(single, "pour from", "pour into")
    own_start = change_of(single, "pour from", None)
    near, far = (np.linalg.norm(change.at(middle)[0]) for change in (relation, own_start))
    assert near < far
    for change, distance in ((relation, near), (own_start, far)):
        weight = pair_weights(single, change, middle, 0.2)
        np.testing.assert_allclose(weight, 1.0 / np.hypot(0.2 * distance, 0.005), rtol=1e-9)


def test_without_the_prior_all_count_alike(single):
    middle = np.array([0.5 * single.duration])
    for change in single.changes:
        if change.constraint == "cartesian":
            np.testing.assert_allclose(pair_weights(single, change, middle, 0.0), 200.0)


def test_the_prior_counts_as_one_demonstration(model_of):
    model = model_of("pouring")
    count, times = len(model.demonstrations), model.keypoint_times
    change = change_of(model, "pour from", None)
    mean, std = change.at(times)
    prior = 0.2 * np.linalg.norm(mean, axis=1, keepdims=True)
    expected = 1.0 / np.sqrt(((count - 1) * std**2 + prior**2) / count + 0.005**2)
    np.testing.assert_allclose(pair_weights(model, change, times, 0.2), expected, rtol=1e-9)


def test_pairs_within_one_object_have_none(model_of):
    model = model_of("pouring")
    for change in model.changes:
        if change.pair.is_same_object:
            weights = pair_weights(model, change, model.keypoint_times, 0.2)
            expected = constraint_type(change.constraint).weights(change.at(model.keypoint_times)[1], np.zeros(3))
            count = len(model.demonstrations)
            assert count > 1
            np.testing.assert_allclose(weights, expected)


def test_mode_paper_has_the_papers_weights(model_of):
    model = model_of("pouring", mode="paper")
    change = model.changes[0]
    std = change.at(model.keypoint_times)[1]
    found = pair_weights(model, change, model.keypoint_times, 0.2)
    np.testing.assert_allclose(found, 1000.0 / (1.0 + 1000.0 * std))


def test_a_longer_reach_of_the_prior_never_raises_a_weight(single):
    times = single.keypoint_times
    for change in single.changes:
        loose, tight = (pair_weights(single, change, times, proximity) for proximity in (0.3, 0.1))
        assert (loose <= tight + 1e-12).all()
