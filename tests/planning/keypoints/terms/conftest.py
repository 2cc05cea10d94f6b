"""Finite differences of objective terms."""

from collections.abc import Callable

import numpy as np
import pytest

from sbam.planning.keypoints.state import State, Workspace
from sbam.planning.keypoints.terms import EXACT, Smoothing, Term

STEP = 1e-6


@pytest.fixture
def state(workspace: Workspace, within_limits: Callable[..., np.ndarray]) -> State:
    """Five random configurations."""
    return workspace.state(within_limits(workspace.robot, np.random.default_rng(4), 5))


@pytest.fixture(scope="session")
def agrees_with_differences() -> Callable[..., None]:
    """``agrees_with_differences(term, state, smoothing)``: both Jacobians are those of central differences."""

    def check(term: Term, state: State, smoothing: Smoothing = EXACT) -> None:
        q = state.configurations
        own = term.jacobian(state, smoothing)
        previous = term.previous_jacobian(state) if term.couples_neighbours else np.zeros_like(own)
        expected_own, expected_previous = np.empty_like(own), np.zeros_like(own)
        for joint in range(q.shape[1]):
            for parity in (0, 1):  # only every other keypoint moves, so that own and previous do not mix
                step = np.zeros_like(q)
                step[parity::2, joint] = STEP
                ahead = term.residual(state.workspace.state(q + step), smoothing)
                behind = term.residual(state.workspace.state(q - step), smoothing)
                slope = (ahead - behind) / (2.0 * STEP)
                expected_own[parity::2, ..., joint] = slope[parity::2]
                expected_previous[1 - parity :: 2, ..., joint] = slope[1 - parity :: 2]
        scale = max(1.0, float(np.abs(expected_own).max()))
        np.testing.assert_allclose(own, expected_own, atol=2e-7 * scale)
        np.testing.assert_allclose(previous[1:], expected_previous[1:], atol=2e-7 * scale)

    return check


@pytest.fixture(scope="session")
def is_the_row_of_the_whole() -> Callable[[Term, State], None]:
    """``is_the_row_of_the_whole(term, state)``: each keypoint alone has the residual it has among all."""

    def check(term: Term, state: State) -> None:
        previous = None
        for k, configuration in enumerate(state.configurations):
            alone = state.workspace.state(configuration[None])
            single = term.at(k, previous)
            np.testing.assert_allclose(single.residual(alone), term.residual(state)[k : k + 1], atol=1e-12)
            np.testing.assert_allclose(single.jacobian(alone), term.jacobian(state)[k : k + 1], atol=1e-9)
            np.testing.assert_allclose(single.cost(alone), term.cost(state)[k : k + 1], rtol=1e-12, atol=1e-12)
            assert single.groups() == term.groups()
            previous = alone

    return check
