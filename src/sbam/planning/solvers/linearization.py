"""Quadratic model of a problem: block-tridiagonal, because only neighbours are coupled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.planning.problem import Problem
from sbam.planning.state import State
from sbam.planning.terms import Smoothing

Array = NDArray[np.float64]

SMALLEST_NORM = 1e-9  # keeps what is divided by a norm finite


@dataclass(frozen=True)
class Evaluation:
    """A state with its residuals: the merit needs them, and so does the linearisation.

    Attributes:
        state: the configurations and what follows from them.
        residuals: of each term, (K, G, m).
        norms: of each term with norms, sqrt(r.r + epsilon^2), (K, G); None for the others.
        merit: the smoothed objective plus requirements.
    """

    state: State
    residuals: tuple[Array, ...]
    norms: tuple[Array | None, ...]
    merit: float


@dataclass(frozen=True)
class Rows:
    """The linearised residuals of one term.

    Attributes:
        residual: (K, G, m).
        norm: (K, G) smoothed norms; None for a term with squares.
        jacobian: (K, G m, n) by the keypoint's own configuration.
        previous: (K - 1, G m, n) by the previous keypoint's, from the second keypoint on; None if not coupled.
    """

    residual: Array
    norm: Array | None
    jacobian: Array
    previous: Array | None

    def change(self, step: Array) -> Array:
        """(K, G, m) change of the residual with a step (K, n)."""
        change = np.matvec(self.jacobian, step)
        if self.previous is not None:
            change[1:] += np.matvec(self.previous, step[:-1])
        return change.reshape(self.residual.shape)

    def pull(self, residual: Array) -> Array:
        """(K, n) gradient of a residual (K, G, m) with these derivatives."""
        rows = residual.reshape(len(residual), -1)
        gradient = np.vecmat(rows, self.jacobian)
        if self.previous is not None:
            gradient[:-1] += np.vecmat(rows[1:], self.previous)
        return gradient


@dataclass(frozen=True)
class Linearization:
    """Gradient and normal matrix.

    Attributes:
        diagonal: (K, n, n) blocks on the diagonal.
        coupling: (K, n, n) blocks (k, k - 1); the first is zero.
        gradient: (K, n).
        rows: the linearised terms, in the problem's order.
    """

    diagonal: Array
    coupling: Array
    gradient: Array
    rows: tuple[Rows, ...] = ()

    def predicted_gain(self, step: Array) -> float:
        """How much a step (K, n) lowers the merit, by this model."""
        curved = 0.5 * np.matvec(self.diagonal, step)
        curved[1:] += np.matvec(self.coupling[1:], step[:-1])
        return -float((step * (self.gradient + curved)).sum())

    def bending(self, step: Array, after: Evaluation) -> Array:
        """Gradient (K, n) of what the residuals after a step differ from the linear ones: the way curves.

        With it a second step leads back onto the curved way of stiff residuals (second-order correction; Nocedal and
        Wright 2006, section 15.6).
        """
        gradient = np.zeros_like(self.gradient)
        for rows, residual in zip(self.rows, after.residuals, strict=True):
            bend = residual - rows.residual - rows.change(step)
            gradient += rows.pull(bend if rows.norm is None else bend / rows.norm[..., None])
        return gradient


def evaluate(problem: Problem, state: State, smoothing: Smoothing) -> Evaluation:
    """Residuals and merit of a state."""
    residuals, norms, merit = [], [], 0.0
    for term in problem.terms:
        residual = term.residual(state, smoothing)
        squared = np.square(residual).sum(axis=-1)
        norm = None
        if term.loss == "norm":
            norm = np.sqrt(squared + max(term.epsilon(smoothing), SMALLEST_NORM) ** 2)
        merit += float(0.5 * squared.sum() if norm is None else norm.sum())
        residuals.append(residual)
        norms.append(norm)
    return Evaluation(state, tuple(residuals), tuple(norms), merit)


def linearize(
    problem: Problem,
    at: Evaluation,
    smoothing: Smoothing,
    duals: Sequence[Array | None] | None = None,
    curvature: float = 1.0,
) -> Linearization:
    """Model of the merit around a state.

    A norm v = sqrt(r.r + epsilon^2) with u = r / v contributes the gradient J^T u and the matrix

        J^T (I - c (z u^T + u z^T) / 2) J / v

    With c = 0 this is iteratively re-weighted least squares. The norm's own curvature (z = u, c = 1) would be Newton's
    method, which overshoots at the kinks where the optima sit. In between is the primal-dual method: the dual z is an
    estimate of u at the optimum, inside the unit ball where the optimum is on a kink (Chan, Golub and Mulet 1999;
    Andersen, Christiansen, Conn and Overton 2000). The matrix is positive semidefinite as long as |z| <= 1.

    Args:
        problem: what to minimise.
        at: where, from `evaluate` with the same smoothing.
        smoothing: how the kinks are rounded.
        duals: z of each term with norms, (K, G, m), None for the others; default all zero.
        curvature: c, between 0 and 1.
    """
    count, joints = at.state.configurations.shape
    gradient = np.zeros((count, joints))
    linearized: list[Rows] = []
    own_rows, previous_rows = _Product(), _Product()
    coupled: list[Array] = []
    for index, (term, residual, norm) in enumerate(zip(problem.terms, at.residuals, at.norms, strict=True)):
        own = term.jacobian(at.state, smoothing).reshape(count, -1, joints)
        previous = None
        if term.couples_neighbours and count > 1:
            previous = term.previous_jacobian(at.state)[1:].reshape(count - 1, -1, joints)
        rows = Rows(residual, norm, own, previous)
        linearized.append(rows)
        unit = residual if norm is None else residual / norm[..., None]
        gradient += rows.pull(unit)
        dual = duals[index] if duals is not None and curvature > 0.0 else None
        own_rows.add(own, norm, unit, dual, curvature)
        if previous is not None:
            coupled += own_rows.left[-1 if dual is None else -2 :]
            later = (None if norm is None else norm[1:], unit[1:], None if dual is None else dual[1:])
            previous_rows.add(previous, *later, curvature)
    diagonal = _stacked(own_rows.left).swapaxes(1, 2) @ _stacked(own_rows.right)
    coupling = np.zeros((count, joints, joints))
    if coupled:
        before = _stacked(previous_rows.right)
        diagonal[:-1] += _stacked(previous_rows.left).swapaxes(1, 2) @ before
        coupling[1:] = _stacked([rows[1:] for rows in coupled]).swapaxes(1, 2) @ before
    return Linearization(diagonal, coupling, gradient, tuple(linearized))


class _Product:
    """J^T W J of several terms as left^T right, rows one below the other."""

    def __init__(self) -> None:
        self.left: list[Array] = []
        self.right: list[Array] = []

    def add(self, jacobian: Array, norm: Array | None, unit: Array, dual: Array | None, c: float) -> None:
        """Add a term with W = (I - c (z u^T + u z^T) / 2) / v, or I: rows J, and with z also z^T J and u^T J."""
        self.left.append(jacobian)
        if norm is None:
            self.right.append(jacobian)
            return
        count, groups, size = unit.shape
        self.right.append(jacobian / np.repeat(norm, size, axis=1)[..., None])
        if dual is not None:
            along = np.stack([dual, unit], axis=-2) @ jacobian.reshape(count, groups, size, -1)
            opposite = along[..., ::-1, :] * (-0.5 * c / norm)[..., None, None]
            self.left.append(along.reshape(count, 2 * groups, -1))
            self.right.append(opposite.reshape(count, 2 * groups, -1))


def _stacked(rows: Sequence[Array]) -> Array:
    """(K, M, n) of rows (K, m, n) one below the other."""
    return np.concatenate(rows, axis=1)


def updated_duals(model: Linearization, step: Array, duals: Sequence[Array | None] | None) -> list[Array | None]:
    """The duals after a step: Newton's method on v z = r, brought back into the unit ball.

    Args:
        model: linearisation before the step.
        step: (K, n).
        duals: before the step, as given to `linearize`.

    Returns:
        z + dz = u + (dr - z (u . dr)) / v of each term with norms, (K, G, m).
    """
    result: list[Array | None] = []
    for index, rows in enumerate(model.rows):
        if rows.norm is None:
            result.append(None)
            continue
        norm = rows.norm[..., None]
        change, unit = rows.change(step), rows.residual / norm
        dual = None if duals is None else duals[index]
        if dual is not None:
            change = change - dual * np.vecdot(unit, change)[..., None]
        moved = unit + change / norm
        result.append(moved / np.maximum(np.linalg.norm(moved, axis=-1, keepdims=True), 1.0))
    return result
