"""Small steps of the joints between keypoints."""

import numpy as np
import pytest

from sbam.planning.keypoints.terms import Smoothing, Smoothness


@pytest.mark.parametrize("with_start", [False, True])
def test_jacobians_are_those_of_differences(state, with_start, agrees_with_differences, is_the_row_of_the_whole):
    start = np.linspace(-1.0, 1.0, state.configurations.shape[1]) if with_start else None
    term = Smoothness(0.3, start)
    agrees_with_differences(term, state)
    is_the_row_of_the_whole(term, state)


def test_cost_is_the_coefficient_times_squared_steps(state):
    q = state.configurations
    expected = 0.05 * np.square(np.diff(q, axis=0)).sum(axis=1)
    cost = Smoothness(0.05).cost(state)[:, 0]
    np.testing.assert_allclose(cost[1:], expected)
    assert cost[0] == 0.0
    np.testing.assert_array_equal(Smoothness(0.05).cost(state, Smoothing(1.0, 1.0, 1.0))[:, 0], cost)
    from_start = Smoothness(0.05, q[0] - 2.0).cost(state)[:, 0]
    np.testing.assert_allclose(from_start[0], 0.05 * 4.0 * q.shape[1])
