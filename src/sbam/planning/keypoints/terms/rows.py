"""Linearised residuals of a term: how they change with a step, what they pull at, and their normal matrix."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class NormalEquations:
    """Gradient and block-tridiagonal matrix J^T W J, added up over terms.

    Attributes:
        gradient: (K, n).
        diagonal: (K, n, n) blocks on the diagonal.
        coupling: (K, n, n) blocks (k, k - 1); the first is zero.
    """

    def __init__(self, count: int, joints: int) -> None:
        self.gradient = np.zeros((count, joints))
        self.diagonal = np.zeros((count, joints, joints))
        self.coupling = np.zeros((count, joints, joints))
        self._left: list[Array] = []
        self._right: list[Array] = []

    def add_rows(self, left: Array, right: Array) -> None:
        """Add left^T right of rows (K, m, n) to the diagonal."""
        self._left.append(left)
        self._right.append(right)

    def total(self) -> NormalEquations:
        """The same with all rows in the diagonal."""
        if self._left:
            self.diagonal += np.concatenate(self._left, axis=1).mT @ np.concatenate(self._right, axis=1)
        return self


@dataclass(frozen=True)
class Rows(ABC):
    """The linearised residuals of one term.

    Attributes:
        residual: (K, G, m).
        norm: (K, G) smoothed norms; None for a term with squares.
    """

    residual: Array
    norm: Array | None

    @cached_property
    def unit(self) -> Array:
        """(K, G, m) derivative of the term by its residual: the residual, divided by the norm if there is one."""
        return self.residual if self.norm is None else self.residual / self.norm[..., None]

    @abstractmethod
    def change(self, step: Array) -> Array:
        """(K, G, m) change of the residual with a step (K, n)."""

    @abstractmethod
    def pull(self, residual: Array) -> Array:
        """(K, n) gradient J^T r of a residual r (K, G, m)."""

    @abstractmethod
    def add_to(self, normal: NormalEquations, dual: Array | None, curvature: float) -> None:
        """Add J^T u and J^T W J with W = (I - c (z u^T + u z^T) / 2) / v for norms v, else W = I.

        Args:
            normal: what to add to.
            dual: z, (K, G, m), or None for 0.
            curvature: c.
        """


@dataclass(frozen=True)
class JointRows(Rows):
    """Residuals with any derivatives by the joints.

    Attributes:
        jacobian: (K, G m, n) by the keypoint's own configuration.
        previous: (K - 1, G m, n) by the previous keypoint's, from the second keypoint on; None if not coupled.
    """

    jacobian: Array
    previous: Array | None

    def change(self, step: Array) -> Array:
        """See `Rows`."""
        change = np.matvec(self.jacobian, step)
        if self.previous is not None:
            change[1:] += np.matvec(self.previous, step[:-1])
        return change.reshape(self.residual.shape)

    def pull(self, residual: Array) -> Array:
        """See `Rows`."""
        rows = residual.reshape(len(residual), -1)
        gradient = np.vecmat(rows, self.jacobian)
        if self.previous is not None:
            gradient[:-1] += np.vecmat(rows[1:], self.previous)
        return gradient

    def add_to(self, normal: NormalEquations, dual: Array | None, curvature: float) -> None:
        """See `Rows`."""
        unit = self.unit
        normal.gradient += self.pull(unit)
        weighted = self._weighted(self.jacobian, slice(None), unit, dual, curvature)
        normal.add_rows(self.jacobian, weighted)
        if self.previous is not None:
            before = self._weighted(self.previous, slice(1, None), unit, dual, curvature)
            normal.diagonal[:-1] += self.previous.mT @ before
            normal.coupling[1:] += self.jacobian[1:].mT @ before

    def _weighted(self, jacobian: Array, of: slice, unit: Array, dual: Array | None, curvature: float) -> Array:
        """W J of the keypoints ``of``."""
        if self.norm is None:
            return jacobian
        unit, norm = unit[of], self.norm[of, :, None, None]
        rows = jacobian.reshape(*unit.shape, -1)
        weighted = rows / norm
        if dual is not None:
            dual = dual[of]
            by_unit, by_dual = np.vecmat(unit, rows)[..., None, :], np.vecmat(dual, rows)[..., None, :]
            weighted -= (0.5 * curvature / norm) * (dual[..., None] * by_unit + unit[..., None] * by_dual)
        return weighted.reshape(jacobian.shape)


@dataclass(frozen=True)
class VectorRows(Rows):
    """Norms of residuals that depend on the joints through one vector a group.

    Weights are made for the vectors' three coordinates, which are fewer than the residual's.

    Attributes:
        slope: (K, G, m, 3) derivative of the residual by the group's vector.
        vectors: (K, G, 3, n) derivative of the vectors by the joints.
        coupled: whether the residual depends on the vector's difference from the previous keypoint's.
    """

    slope: Array
    vectors: Array
    coupled: bool = False

    @cached_property
    def _flat(self) -> Array:
        """(K, 3 G, n) derivative of the vectors."""
        count, groups, _, joints = self.vectors.shape
        return self.vectors.reshape(count, 3 * groups, joints)

    def change(self, step: Array) -> Array:
        """See `Rows`."""
        vectors = np.matvec(self.vectors, step[:, None])
        if self.coupled:
            vectors = np.concatenate([vectors[:1], vectors[1:] - vectors[:-1]])
        return np.matvec(self.slope, vectors)

    def pull(self, residual: Array) -> Array:
        """See `Rows`."""
        return self._pull(np.vecmat(residual, self.slope))

    def _pull(self, vectors: Array) -> Array:
        if self.coupled:
            vectors = np.concatenate([vectors[:-1] - vectors[1:], vectors[-1:]])
        return np.vecmat(vectors.reshape(len(vectors), -1), self._flat)

    def add_to(self, normal: NormalEquations, dual: Array | None, curvature: float) -> None:
        """See `Rows`."""
        assert self.norm is not None
        by_unit = np.vecmat(self.unit, self.slope)
        normal.gradient += self._pull(by_unit)
        weight = np.ascontiguousarray(self.slope.mT) @ self.slope
        if dual is not None:
            by_dual = (0.5 * curvature) * np.vecmat(dual, self.slope)
            product = by_unit[..., :, None] * by_dual[..., None, :]
            weight -= product
            weight -= product.mT
        weight /= self.norm[..., None, None]
        if self.coupled:
            before = weight[1:] @ self.vectors[:-1]
            normal.coupling[1:] -= self._flat[1:].mT @ before.reshape(self._flat[1:].shape)
            weight[:-1] += weight[1:]
        normal.add_rows(self._flat, (weight @ self.vectors).reshape(self._flat.shape))


@dataclass(frozen=True)
class StepRows(Rows):
    """Squares of scaled steps of the joints from keypoint to keypoint, (K, 1, n).

    Attributes:
        scale: factor from the step to the residual.
        first: whether the first keypoint has a step too.
    """

    scale: float
    first: bool

    def change(self, step: Array) -> Array:
        """See `Rows`."""
        change = self.scale * step
        change[1:] -= self.scale * step[:-1]
        if not self.first:
            change[0] = 0.0
        return change[:, None]

    def pull(self, residual: Array) -> Array:
        """See `Rows`."""
        gradient = self.scale * residual[:, 0]
        if not self.first:
            gradient[0] = 0.0
        gradient[:-1] -= self.scale * residual[1:, 0]
        return gradient

    def add_to(self, normal: NormalEquations, dual: Array | None, curvature: float) -> None:
        """See `Rows`."""
        normal.gradient += self.pull(self.residual)
        square = self.scale**2
        steps = np.full(len(self.residual), 2.0)
        steps[-1] -= 1.0
        steps[0] -= not self.first
        np.einsum("kii->ki", normal.diagonal)[:] += square * steps[:, None]
        np.einsum("kii->ki", normal.coupling)[1:] -= square
