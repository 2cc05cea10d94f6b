"""t_d: objects should not move without reason."""

import numpy as np
import pytest

from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import Damping, Smoothing


@pytest.fixture
def term(state: State) -> Damping:
    generator = np.random.default_rng(2)
    weight = generator.uniform(1.0, 20.0, (len(state.configurations), 2))
    return Damping(("a", "b"), weight, generator.normal(size=(2, 3)))


def test_jacobians_are_those_of_differences(term, state, agrees_with_differences):
    agrees_with_differences(term, state)


def test_each_keypoint_is_a_row_of_the_whole(term, state, is_the_row_of_the_whole):
    is_the_row_of_the_whole(term, state)


def test_cost_is_the_weighted_way_of_the_origins(term, state):
    position = state.object_position
    ways = np.linalg.norm(np.diff(position, axis=0, prepend=term.start[None]), axis=-1)
    np.testing.assert_allclose(term.cost(state), term.weight * ways)


def test_only_its_own_smoothing_counts(term, state):
    np.testing.assert_array_equal(term.cost(state, Smoothing(similarity=5.0)), term.cost(state))
    still = Damping(("a", "b"), term.weight[:1], state.object_position[0])
    first = state.workspace.state(state.configurations[:1])
    np.testing.assert_allclose(still.cost(first), 0.0, atol=1e-12)
    np.testing.assert_allclose(still.cost(first, Smoothing(damping=0.25)), 0.25)
