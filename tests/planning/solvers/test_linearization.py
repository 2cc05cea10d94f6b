"""The block-tridiagonal Gauss-Newton model against dense algebra and finite differences."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.solvers.linearization import Linearization, linearize, solve_damped
from sbam.planning.terms import Smoothing

SMOOTHING = Smoothing(0.3, 3e-2, 3e-3)


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


@pytest.mark.parametrize(("count", "joints"), [(1, 4), (2, 3), (7, 5), (30, 14)])
def test_step_equals_that_of_the_dense_matrix(count, joints):
    model, dense = random_model(count, joints, seed=count)
    free = np.ones((count, joints), dtype=bool)
    for damping in (0.0, 1e-3, 10.0):
        damped = dense + damping * np.diag(np.diag(dense))
        expected = -np.linalg.solve(damped, model.gradient.ravel()).reshape(count, joints)
        np.testing.assert_allclose(solve_damped(model, damping, free), expected, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("count", [1, 6])
def test_joints_held_at_a_limit_do_not_move_and_do_not_count(count):
    model, dense = random_model(count, 5, seed=11)
    free = np.random.default_rng(12).random((count, 5)) < 0.6
    step = solve_damped(model, 0.0, free)
    assert not step[~free].any()
    chosen = free.ravel()
    expected = -np.linalg.solve(dense[np.ix_(chosen, chosen)], model.gradient.ravel()[chosen])
    np.testing.assert_allclose(step[free], expected, rtol=1e-5, atol=1e-7)


def test_a_variable_that_nothing_sees_stays():
    model, _ = random_model(4, 3, seed=13)
    diagonal, coupling, gradient = model.diagonal.copy(), model.coupling.copy(), model.gradient.copy()
    diagonal[:, 1], diagonal[:, :, 1], coupling[:, 1], coupling[:, :, 1], gradient[:, 1] = 0, 0, 0, 0, 0
    step = solve_damped(Linearization(diagonal, coupling, gradient), 1e-3, np.ones((4, 3), dtype=bool))
    assert np.isfinite(step).all()
    assert not step[:, 1].any()


@pytest.mark.parametrize("which", ["pouring", "rolling"])
def test_gradient_is_that_of_the_merit(which, small_plan, rolling_plan, problem_of):
    """Along random directions, away from the solution, with all terms that pouring and rolling have."""
    plan = small_plan if which == "pouring" else rolling_plan
    times = plan.task.model.keypoint_times[::6]
    problem = problem_of(plan, times)
    generator = np.random.default_rng(14)
    q = problem.project(plan.solution.configurations[::6] + generator.normal(0, 0.05, (len(times), 14)))
    model = linearize(problem, problem.state(q), SMOOTHING)
    step = 1e-6
    for _ in range(5):
        direction = generator.normal(size=q.shape)
        ahead, behind = (problem.merit(problem.state(q + s * step * direction), SMOOTHING) for s in (1.0, -1.0))
        slope = (ahead - behind) / (2.0 * step)
        assert float((model.gradient * direction).sum()) == pytest.approx(slope, rel=1e-5)


def test_normal_matrix_is_that_of_the_weighted_residuals(small_plan, problem_of):
    """J^T J / norm, with J from differences of all residuals over all joints of three keypoints."""
    times = small_plan.task.model.keypoint_times[[4, 8, 12]]
    problem = problem_of(small_plan, times)
    q = small_plan.solution.configurations[[4, 8, 12]] + 0.02

    state = problem.state(q)
    scales = [t.cost(state, SMOOTHING) ** -0.5 if t.loss == "norm" else np.ones((1, 1)) for t in problem.terms]

    def rows(configurations: np.ndarray) -> np.ndarray:
        at = problem.state(configurations)
        weighted = [s[..., None] * t.residual(at, SMOOTHING) for t, s in zip(problem.terms, scales, strict=True)]
        return np.concatenate([residual.ravel() for residual in weighted])

    step = 1e-6
    columns = []
    for index in range(q.size):
        offset = np.zeros(q.size)
        offset[index] = step
        offset = offset.reshape(q.shape)
        columns.append((rows(q + offset) - rows(q - offset)) / (2.0 * step))
    jacobian = np.stack(columns, axis=-1)
    dense = (jacobian.T @ jacobian).reshape(3, 14, 3, 14)
    model = linearize(problem, state, SMOOTHING)
    scale = float(np.abs(dense).max())
    for k in range(3):
        np.testing.assert_allclose(model.diagonal[k], dense[k, :, k], atol=1e-6 * scale)
        if k:
            np.testing.assert_allclose(model.coupling[k], dense[k, :, k - 1], atol=1e-6 * scale)
    np.testing.assert_allclose(dense[0, :, 2], 0.0, atol=1e-6 * scale)


def test_one_keypoint_has_no_neighbours(small_plan, problem_of):
    problem = problem_of(small_plan)
    q = small_plan.solution.configurations
    alone = problem.at(5, problem.at(4, None).state(q[4:5]))
    whole = linearize(problem, problem.state(q), SMOOTHING)
    single = linearize(alone, alone.state(q[5:6]), SMOOTHING)
    without_next = [term for term in problem.terms if not term.couples_neighbours]
    uncoupled = linearize(replace(problem, terms=tuple(without_next)), problem.state(q), SMOOTHING)
    assert not single.coupling.any()
    assert np.linalg.norm(whole.coupling[5]) > 0.0
    difference = single.diagonal[0] - uncoupled.diagonal[5]
    assert np.linalg.eigvalsh(difference).min() > -1e-6
