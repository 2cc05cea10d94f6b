"""Quadratic model of a problem: block-tridiagonal, because only neighbours are coupled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import NormalEquations, Rows, Smoothing

SMALLEST_NORM = 1e-9  # keeps what is divided by a norm finite


@dataclass(frozen=True)
class Evaluation:
    """A state with its residuals: the merit needs them, and so does the linearisation.

    Attributes:
        state: the configurations and what follows from them.
        residuals: of each term.
        norms: of each term with norms, sqrt(r.r + epsilon^2); None for the others.
        merit: the smoothed objective plus requirements.
    """

    state: State
    residuals: tuple[Float[np.ndarray, "keypoints _groups _rows"], ...]
    norms: tuple[Float[np.ndarray, "keypoints _groups"] | None, ...]
    merit: float


@dataclass(frozen=True)
class Linearization:
    """Gradient and normal matrix.

    Attributes:
        diagonal: blocks on the diagonal.
        coupling: blocks (k, k - 1); the first is zero.
        gradient: of the merit.
        rows: the linearised terms, in the problem's order.
    """

    diagonal: Float[np.ndarray, "keypoints joints joints"]
    coupling: Float[np.ndarray, "keypoints joints joints"]
    gradient: Float[np.ndarray, "keypoints joints"]
    rows: tuple[Rows, ...] = ()

    def predicted_gain(self, step: Float[np.ndarray, "keypoints joints"]) -> float:
        """How much a step lowers the merit, by this model."""
        curved = 0.5 * np.matvec(self.diagonal, step)
        curved[1:] += np.matvec(self.coupling[1:], step[:-1])
        return -float((step * (self.gradient + curved)).sum())

    def bending(
        self, step: Float[np.ndarray, "keypoints joints"], after: Evaluation
    ) -> Float[np.ndarray, "keypoints joints"]:
        """Gradient of what the residuals after a step differ from the linear ones: the way curves.

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
        squared = np.vecdot(residual, residual)
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
    duals: Sequence[Float[np.ndarray, "keypoints _groups _rows"] | None] | None = None,
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
        duals: z of each term with norms, None for the others; default all zero.
        curvature: c, between 0 and 1.
    """
    normal = NormalEquations(*at.state.configurations.shape)
    linearized = []
    for index, (term, residual, norm) in enumerate(zip(problem.terms, at.residuals, at.norms, strict=True)):
        rows = term.rows(at.state, smoothing, residual, norm)
        rows.add_to(normal, duals[index] if duals is not None and curvature > 0.0 else None, curvature)
        linearized.append(rows)
    normal = normal.total()
    return Linearization(normal.diagonal, normal.coupling, normal.gradient, tuple(linearized))


def updated_duals(
    model: Linearization,
    step: Float[np.ndarray, "keypoints joints"],
    duals: Sequence[Float[np.ndarray, "keypoints _groups _rows"] | None] | None,
) -> list[Float[np.ndarray, "keypoints _groups _rows"] | None]:
    """The duals after a step: Newton's method on v z = r, brought back into the unit ball.

    Args:
        model: linearisation before the step.
        step: that was taken.
        duals: before the step, as given to `linearize`.

    Returns:
        z + dz = u + (dr - z (u . dr)) / v of each term with norms.
    """
    result: list[Float[np.ndarray, "keypoints _groups _rows"] | None] = []
    for index, rows in enumerate(model.rows):
        if rows.norm is None:
            result.append(None)
            continue
        norm = rows.norm[..., None]
        change, unit = rows.change(step), rows.unit
        dual = None if duals is None else duals[index]
        if dual is not None:
            change = change - dual * np.vecdot(unit, change)[..., None]
        moved = unit + change / norm
        result.append(moved / np.maximum(np.sqrt(np.vecdot(moved, moved)), 1.0)[..., None])
    return result
