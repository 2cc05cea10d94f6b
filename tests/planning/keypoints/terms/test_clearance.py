"""Distances that must be kept, linearised between keypoints."""

import numpy as np
import pytest

from sbam.planning.keypoints.terms import Clearance
from sbam.planning.keypoints.terms.clearance import SCALE


@pytest.fixture
def term(state):
    """Three pairs per interval with distances on both sides of the margin; the last ones are filled up."""
    count, joints = state.configurations.shape
    generator = np.random.default_rng(3)
    distance = generator.uniform(-0.02, 0.03, (count, 3))
    distance[::2, 2] = np.inf
    return Clearance(
        configurations=state.configurations + 0.01 * generator.standard_normal((count, joints)),
        distance=distance,
        fraction=generator.uniform(0.0, 1.0, (count, 3)),
        gradient=generator.standard_normal((count, 3, joints)),
        margin=0.005,
    )


def test_jacobians_are_those_of_differences(state, term, agrees_with_differences, is_the_row_of_the_whole):
    agrees_with_differences(term, state)
    is_the_row_of_the_whole(term, state)


def test_only_what_is_missing_of_the_margin_costs(state, term):
    at_linearisation = Clearance(state.configurations, term.distance, term.fraction, term.gradient, term.margin)
    residual = at_linearisation.residual(state)[..., 0]
    np.testing.assert_allclose(residual, np.maximum(0.005 - term.distance, 0.0) / SCALE)
    assert (residual > 0).any()
    assert (residual[np.isinf(term.distance)] == 0).all()
