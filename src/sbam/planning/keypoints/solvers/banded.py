"""The linear algebra of a step: a block-tridiagonal system as one banded Cholesky factorisation."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from numpy.lib.stride_tricks import as_strided

from sbam.planning.keypoints.solvers.linearization import Linearization


class DampedSystem:
    """(H + damping diag(H)) x = -g for the free variables, factorised once for several right-hand sides."""

    def __init__(self, model: Linearization, damping: float, free: Bool[np.ndarray, "keypoints joints"]) -> None:
        """Factorise.

        Args:
            model: the quadratic model, with H.
            damping: Levenberg-Marquardt parameter, relative to the diagonal.
            free: False for joints held at a limit, whose step is 0.

        Raises:
            numpy.linalg.LinAlgError: if the matrix is not positive definite.
        """
        from scipy.linalg import get_lapack_funcs

        factorize, self._solve = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float64)
        self._free = free
        count, joints, _ = model.diagonal.shape
        diagonal, coupling = model.diagonal * np.tri(joints), model.coupling
        entries = np.einsum("kii->ki", diagonal)  # a view
        entries += damping * np.maximum(entries, 1e-3 * entries.max(axis=1, initial=1e-12, keepdims=True)) + 1e-9
        if not free.all():
            diagonal[~(free[:, :, None] & free[:, None, :])] = 0.0
            entries[~free] = 1.0
            coupling = coupling.copy()
            coupling[1:][~(free[1:, :, None] & free[:-1, None, :])] = 0.0
        # LAPACK's lower band form, column after column: entry (i, j) is at i + j (2 n - 1). In that memory each block
        # is a matrix with the strides (1, 2 n - 1); the zeros above a diagonal block fall where the band has zeros, but
        # for its first row, which the coupling block overwrites.
        size = 2 * joints * joints
        band = np.zeros(size * (count + 1))
        strides = tuple(band.itemsize * entry for entry in (size, joints, 1, 2 * joints - 1))
        blocks = as_strided(band, (count, 2, joints, joints), strides)
        blocks[:, 0] = diagonal
        blocks[:-1, 1] = coupling[1:]
        columns = band[: size * count].reshape(joints * count, 2 * joints)
        self._factor, failed = factorize(columns.T, lower=1, overwrite_ab=1)
        if failed:
            raise np.linalg.LinAlgError(f"not positive definite in row {failed}")

    def step(self, gradient: Float[np.ndarray, "keypoints joints"]) -> Float[np.ndarray, "keypoints joints"]:
        """Solution for a gradient g."""
        right = np.where(self._free, -gradient, 0.0)
        solution, _ = self._solve(self._factor, right.ravel(), lower=1, overwrite_b=1)
        return solution.reshape(gradient.shape)
