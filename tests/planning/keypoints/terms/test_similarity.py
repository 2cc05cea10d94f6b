"""t_s: sum of norms of what the constraint types say of the pairs."""

import numpy as np
import pytest

from sbam.constraints import CONSTRAINT_TYPES
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import EXACT, Similarity, Smoothing

FIRST = np.array([0, 1, 0, 3, 5])
SECOND = np.array([1, 2, -1, 1, 0])
PAIRS = tuple(f"pair {index}" for index in range(len(FIRST)))


def random_term(state: State, constraint: str, mode: str) -> Similarity:
    generator = np.random.default_rng(8)
    constraint_type = CONSTRAINT_TYPES[constraint].in_mode(mode)
    count, pairs, channels = len(state.configurations), len(FIRST), len(constraint_type.channel_names)
    target = generator.normal(size=(count, pairs, channels))
    return Similarity(
        constraint=constraint_type,
        pairs=PAIRS,
        first=FIRST,
        second=SECOND,
        origin=generator.normal(size=(pairs, 3)),
        shift=0.1 * generator.normal(size=(pairs, 3)),
        target=target,
        weight=constraint_type.weights(generator.uniform(0.01, 0.2, target.shape), target),
    )


@pytest.mark.parametrize("mode", ["default", "paper"])
@pytest.mark.parametrize("constraint", CONSTRAINT_TYPES)
def test_jacobian_is_that_of_differences(state, constraint, mode, agrees_with_differences):
    term = random_term(state, constraint, mode)
    agrees_with_differences(term, state)
    agrees_with_differences(term, state, Smoothing(0.3, 3e-2, 3e-3))


@pytest.mark.parametrize("constraint", CONSTRAINT_TYPES)
def test_each_keypoint_is_a_row_of_the_whole(state, constraint, is_the_row_of_the_whole):
    is_the_row_of_the_whole(random_term(state, constraint, "default"), state)


def test_vectors_are_differences_of_regions_or_from_the_own_start(state):
    term = random_term(state, "cartesian", "default")
    position, vector = state.region_position, term.vector(state)
    np.testing.assert_allclose(vector[:, 0], position[:, 0] - position[:, 1] + term.shift[0])
    np.testing.assert_allclose(vector[:, 2], position[:, 0] - term.origin[2] + term.shift[2])


def test_cost_is_the_sum_of_norms(state):
    """Two pairs 3-4-5 and 5-12-13 off, with weights 2 and 3 per millimetre, worked by hand."""
    positions = state.region_position
    term = Similarity(
        constraint=CONSTRAINT_TYPES["cartesian"],
        pairs=("a", "b"),
        first=np.array([0, 1]),
        second=np.array([2, -1]),
        origin=np.zeros((2, 3)),
        shift=np.zeros((2, 3)),
        target=np.stack(
            [positions[:, 0] - positions[:, 2] - [0.003, 0.0, 0.004], positions[:, 1] - [0.005, 0.012, 0.0]], axis=1
        ),
        weight=np.broadcast_to(np.array([2e3, 3e3])[:, None], (len(positions), 2, 3)),
    )
    np.testing.assert_allclose(term.cost(state, EXACT), np.tile([10.0, 39.0], (len(positions), 1)), rtol=1e-9)
    smooth = term.cost(state, Smoothing(similarity=24.0, damping=7.0))
    np.testing.assert_allclose(smooth[:, 0], 26.0, rtol=1e-9)
    assert term.groups() == ("a", "b")
