"""Gauss-Newton model of a problem: block-tridiagonal, because only neighbours are coupled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.planning.problem import Problem
from sbam.planning.state import State
from sbam.planning.terms import Smoothing

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Linearization:
    """Gradient and normal matrix.

    Attributes:
        diagonal: (K, n, n) blocks on the diagonal.
        coupling: (K, n, n) blocks (k, k - 1); the first is zero.
        gradient: (K, n).
    """

    diagonal: Array
    coupling: Array
    gradient: Array


def linearize(problem: Problem, state: State, smoothing: Smoothing) -> Linearization:
    """Iteratively re-weighted Gauss-Newton model: a norm sqrt(r.r + eps^2) = v contributes J^T J / v and J^T r / v.

    The norm's own curvature is left out: it makes the model indefinite at the kinks where the optima sit.
    """
    count, joints = state.configurations.shape
    diagonal = np.zeros((count, joints, joints))
    coupling = np.zeros((count, joints, joints))
    gradient = np.zeros((count, joints))
    for term in problem.terms:
        residual = term.residual(state, smoothing)
        jacobian = term.jacobian(state, smoothing)
        scale = np.ones(residual.shape[:2])
        if term.loss == "norm":
            squared = np.square(residual).sum(axis=-1)
            scale = (squared + max(term.epsilon(smoothing), 1e-9) ** 2) ** -0.25
            residual = residual * scale[..., None]
            jacobian = jacobian * scale[..., None, None]
        rows = residual.reshape(count, -1)
        own = jacobian.reshape(count, -1, joints)
        own_t = np.swapaxes(own, 1, 2)
        diagonal += own_t @ own
        gradient += np.matvec(own_t, rows)
        if term.couples_neighbours and count > 1:
            before = term.previous_jacobian(state)[1:] * scale[1:, :, None, None]
            before = before.reshape(count - 1, -1, joints)
            before_t = np.swapaxes(before, 1, 2)
            diagonal[:-1] += before_t @ before
            coupling[1:] += own_t[1:] @ before
            gradient[:-1] += np.matvec(before_t, rows[1:])
    return Linearization(diagonal, coupling, gradient)


def _band_index(count: int, joints: int) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
    """Rows of the lower band form for the entries of a diagonal block and of a coupling block, and the columns."""
    i, j = np.meshgrid(np.arange(joints), np.arange(joints), indexing="ij")
    return i - j, i - j + joints, j


def solve_damped(model: Linearization, damping: float, free: NDArray[np.bool_]) -> Array:
    """Levenberg step: solve (H + damping diag(H)) step = -gradient for the free variables.

    Args:
        model: the Gauss-Newton model.
        damping: Levenberg-Marquardt parameter, relative to the diagonal.
        free: (K, n) False for joints held at a limit, whose step is 0.

    Returns:
        (K, n) step.
    """
    from scipy.linalg import solveh_banded

    count, joints, _ = model.diagonal.shape
    keep = free[:, :, None] & free[:, None, :]
    diagonal = np.where(keep, model.diagonal, 0.0)
    index = np.arange(joints)
    entries = diagonal[:, index, index]
    scale = np.maximum(entries, 1e-3 * entries.max(axis=1, initial=1e-12, keepdims=True))
    diagonal[:, index, index] = np.where(free, entries + damping * scale + 1e-9, 1.0)
    right = np.where(free, -model.gradient, 0.0)
    if count == 1:
        return np.linalg.solve(diagonal, right[..., None])[..., 0]
    same, next_block, column = _band_index(count, joints)
    band = np.zeros((2 * joints, count, joints))
    lower = same >= 0
    band[same[lower], :, column[lower]] = diagonal[:, lower].T
    coupled = np.where(free[1:, :, None] & free[:-1, None, :], model.coupling[1:], 0.0)
    band[next_block, :-1, column] = np.moveaxis(coupled, 0, -1)
    return solveh_banded(
        band.reshape(2 * joints, count * joints), right.ravel(), lower=True, check_finite=False
    ).reshape(count, joints)
