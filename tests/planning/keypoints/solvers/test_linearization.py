"""The block-tridiagonal model against finite differences and a Newton model of its own."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.keypoints.solvers.linearization import evaluate, linearize, updated_duals
from sbam.planning.keypoints.terms import Smoothing

SMOOTHING = Smoothing(0.3, 3e-2, 3e-3)


def columns_of(function, q: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Central differences of a flat function of (K, n) configurations, one column a joint."""
    columns = []
    for index in range(q.size):
        offset = np.zeros(q.size)
        offset[index] = step
        offset = offset.reshape(q.shape)
        columns.append((function(q + offset) - function(q - offset)) / (2.0 * step))
    return np.stack(columns, axis=-1)


def assert_is(model, dense: np.ndarray, accuracy: float) -> None:
    """The model's blocks are those of the dense (K, n, K, n) matrix, and beyond them it is zero."""
    scale = float(np.abs(dense).max())
    for k in range(len(dense)):
        np.testing.assert_allclose(model.diagonal[k], dense[k, :, k], atol=accuracy * scale)
        if k:
            np.testing.assert_allclose(model.coupling[k], dense[k, :, k - 1], atol=accuracy * scale)
        for other in range(k + 2, len(dense)):
            np.testing.assert_allclose(dense[k, :, other], 0.0, atol=accuracy * scale)


@pytest.fixture
def three(small_plan, problem_of):
    """Three keypoints of pouring, beside the solution."""
    indices = [4, 8, 12]
    problem = problem_of(small_plan, small_plan.task.model.keypoint_times[indices])
    return problem, small_plan.solution.configurations[indices] + 0.02


def test_merit_is_that_of_the_problem(three):
    problem, q = three
    state = problem.state(q)
    assert evaluate(problem, state, SMOOTHING).merit == pytest.approx(problem.merit(state, SMOOTHING), rel=1e-12)


@pytest.mark.parametrize("which", ["pouring", "rolling"])
def test_gradient_is_that_of_the_merit(which, small_plan, rolling_plan, problem_of):
    """Along random directions, away from the solution, with all terms that pouring and rolling have."""
    plan = small_plan if which == "pouring" else rolling_plan
    times = plan.task.model.keypoint_times[::6]
    problem = problem_of(plan, times)
    generator = np.random.default_rng(14)
    q = problem.project(plan.solution.configurations[::6] + generator.normal(0, 0.05, (len(times), 14)))
    model = linearize(problem, evaluate(problem, problem.state(q), SMOOTHING), SMOOTHING)
    step = 1e-6
    for _ in range(5):
        direction = generator.normal(size=q.shape)
        ahead, behind = (problem.merit(problem.state(q + s * step * direction), SMOOTHING) for s in (1.0, -1.0))
        slope = (ahead - behind) / (2.0 * step)
        assert float((model.gradient * direction).sum()) == pytest.approx(slope, rel=1e-5)


def test_without_duals_the_matrix_is_that_of_the_weighted_residuals(three):
    """J^T J / norm, with J from differences of all residuals over all joints of three keypoints."""
    problem, q = three
    state = problem.state(q)
    scales = [t.cost(state, SMOOTHING) ** -0.5 if t.loss == "norm" else np.ones((1, 1)) for t in problem.terms]

    def rows(configurations: np.ndarray) -> np.ndarray:
        at = problem.state(configurations)
        weighted = [s[..., None] * t.residual(at, SMOOTHING) for t, s in zip(problem.terms, scales, strict=True)]
        return np.concatenate([residual.ravel() for residual in weighted])

    jacobian = columns_of(rows, q)
    model = linearize(problem, evaluate(problem, state, SMOOTHING), SMOOTHING)
    assert_is(model, (jacobian.T @ jacobian).reshape(3, 14, 3, 14), 1e-6)


def test_with_duals_at_the_units_it_is_newtons_for_linear_residuals(three):
    """Full curvature and z = u: the second derivative of the norms of the linearised residuals."""
    problem, q = three
    problem = replace(problem, terms=tuple(term for term in problem.terms if term.loss == "norm"))
    at = evaluate(problem, problem.state(q), SMOOTHING)
    plain = linearize(problem, at, SMOOTHING)
    units = [rows.residual / rows.norm[..., None] for rows in plain.rows]

    def gradient(step: np.ndarray) -> np.ndarray:
        total = np.zeros_like(step)
        for term, rows in zip(problem.terms, plain.rows, strict=True):
            moved = rows.residual + rows.change(step)
            norm = np.sqrt(np.square(moved).sum(-1, keepdims=True) + term.epsilon(SMOOTHING) ** 2)
            total += rows.pull(moved / norm)
        return total.ravel()

    second = columns_of(gradient, np.zeros_like(q)).reshape(3, 14, 3, 14)
    assert_is(linearize(problem, at, SMOOTHING, units), second, 1e-6)


def test_any_duals_in_the_unit_ball_leave_it_positive_semidefinite(three):
    problem, q = three
    generator = np.random.default_rng(15)
    at = evaluate(problem, problem.state(q), SMOOTHING)
    for _ in range(5):
        duals = []
        for term, residual in zip(problem.terms, at.residuals, strict=True):
            dual = generator.normal(size=residual.shape)
            duals.append(dual / np.linalg.norm(dual, axis=-1, keepdims=True) if term.loss == "norm" else None)
        model = linearize(problem, at, SMOOTHING, duals)
        dense = np.zeros((3, 14, 3, 14))
        for k in range(3):
            dense[k, :, k] = model.diagonal[k]
            if k:
                dense[k, :, k - 1], dense[k - 1, :, k] = model.coupling[k], model.coupling[k].T
        dense = dense.reshape(42, 42)
        assert np.linalg.eigvalsh(dense).min() > -1e-9 * np.abs(dense).max()


def test_duals_are_newtons_and_stay_in_the_unit_ball(three):
    """A step of length 0 gives the units; a small one follows d(r / v) for z = u; none leaves the ball."""
    problem, q = three
    at = evaluate(problem, problem.state(q), SMOOTHING)
    model = linearize(problem, at, SMOOTHING)
    units = updated_duals(model, np.zeros_like(q), None)
    direction = np.random.default_rng(16).normal(size=q.shape)
    moved = updated_duals(model, 1e-6 * direction, units)
    for term, rows, unit, dual in zip(problem.terms, model.rows, units, moved, strict=True):
        if rows.norm is None:
            assert unit is None and dual is None
            continue
        np.testing.assert_allclose(unit, rows.residual / rows.norm[..., None])
        after = rows.residual + rows.change(1e-6 * direction)
        norm = np.sqrt(np.square(after).sum(-1, keepdims=True) + term.epsilon(SMOOTHING) ** 2)
        np.testing.assert_allclose(dual, after / norm, atol=1e-8)
    far = updated_duals(model, 10.0 * direction, units)
    assert all(np.linalg.norm(dual, axis=-1).max() <= 1.0 + 1e-12 for dual in far if dual is not None)


def test_bending_vanishes_where_residuals_are_linear(three):
    problem, q = three
    step = 1e-2 * np.random.default_rng(17).normal(size=q.shape)
    at = evaluate(problem, problem.state(q), SMOOTHING)
    after = evaluate(problem, problem.state(q + step), SMOOTHING)
    model = linearize(problem, at, SMOOTHING)
    linear = replace(after, residuals=tuple(rows.residual + rows.change(step) for rows in model.rows))
    scale = np.abs(model.gradient).max()
    np.testing.assert_allclose(model.bending(step, linear), 0.0, atol=1e-9 * scale)
    half = evaluate(problem, problem.state(q + 0.5 * step), SMOOTHING)
    ratio = np.linalg.norm(model.bending(step, after)) / np.linalg.norm(model.bending(0.5 * step, half))
    assert ratio == pytest.approx(4.0, rel=0.1)  # it is of second order


def test_one_keypoint_has_no_neighbours(small_plan, problem_of):
    problem = problem_of(small_plan)
    q = small_plan.solution.configurations

    def linearized(problem, q):
        return linearize(problem, evaluate(problem, problem.state(q), SMOOTHING), SMOOTHING)

    alone = problem.at(5, problem.at(4, None).state(q[4:5]))
    whole, single = linearized(problem, q), linearized(alone, q[5:6])
    without_next = tuple(term for term in problem.terms if not term.couples_neighbours)
    uncoupled = linearized(replace(problem, terms=without_next), q)
    assert not single.coupling.any()
    assert np.linalg.norm(whole.coupling[5]) > 0.0
    difference = single.diagonal[0] - uncoupled.diagonal[5]
    assert np.linalg.eigvalsh(difference).min() > -1e-6
