from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sbam.learning.keypoint_matching import align

NOTHING = (np.array([], int), np.array([], int))


def total_cost(cost, pairs, gap):
    return sum(cost[i, j] for i, j in pairs) + gap * (sum(cost.shape) - 2 * len(pairs))


def cheapest(cost, gap):
    rows, columns = cost.shape
    best = gap * (rows + columns)
    for size in range(1, min(rows, columns) + 1):
        for chosen in combinations(range(rows), size):
            for partners in combinations(range(columns), size):
                best = min(best, total_cost(cost, list(zip(chosen, partners, strict=True)), gap))
    return best


@settings(max_examples=80, deadline=None)
@given(
    cost=st.tuples(st.integers(1, 5), st.integers(1, 5)).flatmap(lambda s: arrays(float, s, elements=st.floats(0, 1))),
    gap=st.floats(0.01, 0.5),
)
def test_no_monotone_matching_is_cheaper(cost, gap):
    pairs = align(cost, gap, NOTHING)
    assert np.all(np.diff(pairs, axis=0) > 0)
    assert total_cost(cost, pairs, gap) == pytest.approx(cheapest(cost, gap), abs=1e-9)


def test_a_hand_worked_case():
    time, other = np.array([0, 1, 2, 3.0]), np.array([0, 1.9, 3.0])
    cost = np.abs(time[:, None] - other)
    assert align(cost, 0.15, NOTHING).tolist() == [[0, 0], [2, 1], [3, 2]]


def test_given_matches_are_kept_at_any_cost():
    cost = np.full((4, 4), 10.0)
    given = (np.array([0, 2, 3]), np.array([0, 1, 3]))
    assert align(cost, 0.15, given).tolist() == [[0, 0], [2, 1], [3, 3]]


def test_expensive_matches_are_gaps():
    assert len(align(np.full((3, 3), 0.31), 0.15, NOTHING)) == 0
    assert len(align(np.full((3, 3), 0.29), 0.15, NOTHING)) == 3
