"""The banded factorisation against dense algebra."""

import numpy as np
import pytest

from sbam.planning.keypoints.solvers.banded import DampedSystem
from sbam.planning.keypoints.solvers.linearization import Linearization


def random_model(count: int, joints: int, seed: int) -> tuple[Linearization, np.ndarray]:
    """A positive definite block-tridiagonal model and its dense matrix."""
    generator = np.random.default_rng(seed)
    own = generator.normal(size=(count, joints + 3, joints))
    before = generator.normal(size=(count, joints + 3, joints))
    before[0] = 0.0
    dense_rows = np.zeros((count, joints + 3, count, joints))
    for k in range(count):
        dense_rows[k, :, k] = own[k]
        if k:
            dense_rows[k, :, k - 1] = before[k]
    rows = dense_rows.reshape(count * (joints + 3), count * joints)
    dense = rows.T @ rows
    diagonal = np.stack([dense[k * joints :, k * joints :][:joints, :joints] for k in range(count)])
    coupling = np.zeros((count, joints, joints))
    for k in range(1, count):
        coupling[k] = dense[k * joints :][:joints, (k - 1) * joints : k * joints]
    return Linearization(diagonal, coupling, generator.normal(size=(count, joints))), dense


@pytest.mark.parametrize(("count", "joints"), [(1, 1), (1, 4), (4, 1), (2, 3), (7, 5), (30, 14)])
def test_step_equals_that_of_the_dense_matrix(count, joints):
    model, dense = random_model(count, joints, seed=count)
    free = np.ones((count, joints), dtype=bool)
    for damping in (0.0, 1e-3, 10.0):
        damped = dense + damping * np.diag(np.diag(dense))
        system = DampedSystem(model, damping, free)
        for gradient in (model.gradient, model.gradient[::-1]):
            expected = -np.linalg.solve(damped, gradient.ravel()).reshape(count, joints)
            np.testing.assert_allclose(system.step(gradient), expected, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("count", [1, 6])
def test_joints_held_at_a_limit_do_not_move_and_do_not_count(count):
    model, dense = random_model(count, 5, seed=11)
    free = np.random.default_rng(12).random((count, 5)) < 0.6
    before = model.coupling.copy()
    step = DampedSystem(model, 0.0, free).step(model.gradient)
    assert not step[~free].any()
    chosen = free.ravel()
    expected = -np.linalg.solve(dense[np.ix_(chosen, chosen)], model.gradient.ravel()[chosen])
    np.testing.assert_allclose(step[free], expected, rtol=1e-5, atol=1e-7)
    assert np.array_equal(model.coupling, before)


def test_a_variable_that_nothing_sees_stays():
    model, _ = random_model(4, 3, seed=13)
    diagonal, coupling, gradient = model.diagonal.copy(), model.coupling.copy(), model.gradient.copy()
    diagonal[:, 1], diagonal[:, :, 1], coupling[:, 1], coupling[:, :, 1], gradient[:, 1] = 0, 0, 0, 0, 0
    model = Linearization(diagonal, coupling, gradient)
    step = DampedSystem(model, 1e-3, np.ones((4, 3), dtype=bool)).step(gradient)
    assert np.isfinite(step).all()
    assert not step[:, 1].any()


def test_an_indefinite_matrix_is_refused():
    model, _ = random_model(3, 4, seed=14)
    indefinite = Linearization(-model.diagonal, model.coupling, model.gradient)
    with pytest.raises(np.linalg.LinAlgError):
        DampedSystem(indefinite, 0.0, np.ones((3, 4), dtype=bool))
