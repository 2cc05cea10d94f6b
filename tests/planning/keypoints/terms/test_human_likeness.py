"""t_h as a term of the objective; the posture itself is tested with the robots."""

import numpy as np
import pytest

from sbam.planning.keypoints.state import Workspace
from sbam.planning.keypoints.terms import HumanLikeness
from sbam.robots import NaturalDirections


@pytest.fixture
def state(panda, within_limits):
    posture = NaturalDirections(panda)
    workspace = Workspace(panda, [], [], posture.frames)
    return workspace.state(within_limits(panda, np.random.default_rng(4), 5))


def test_jacobian_is_that_of_differences(panda, state, agrees_with_differences, is_the_row_of_the_whole):
    term = HumanLikeness(3.0, NaturalDirections(panda))
    agrees_with_differences(term, state)
    is_the_row_of_the_whole(term, state)


def test_cost_is_the_weighted_sum_over_the_arms(panda, state):
    """lambda times (1 - cosine of the upper arm's deviation) + (1 - cosine of the forearm's), both arms."""
    posture = NaturalDirections(panda)
    cosines = np.cos(np.deg2rad(posture.deviation(state.kinematics)))
    expected = 3.0 * (1.0 - cosines).sum(axis=(1, 2))
    np.testing.assert_allclose(HumanLikeness(3.0, posture).cost(state)[:, 0], expected, rtol=1e-9)
