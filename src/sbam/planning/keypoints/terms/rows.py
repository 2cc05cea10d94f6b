"""Linearised residuals of a term: how they change with a step, what they pull at, and their normal matrix."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float


class NormalEquations:
    """Gradient and block-tridiagonal matrix J^T W J, added up over terms.

    Attributes:
        gradient: of the sum.
        diagonal: blocks on the diagonal.
        coupling: blocks (k, k - 1); the first is zero.
    """

    def __init__(self, count: int, joints: int) -> None:
        self.gradient = np.zeros((count, joints))
        self.diagonal = np.zeros((count, joints, joints))
        self.coupling = np.zeros((count, joints, joints))
        self._left: list[Float[np.ndarray, "keypoints _rows joints"]] = []
        self._right: list[Float[np.ndarray, "keypoints _rows joints"]] = []

    def add_rows(
        self, left: Float[np.ndarray, "keypoints rows joints"], right: Float[np.ndarray, "keypoints rows joints"]
    ) -> None:
        """Add left^T right of rows to the diagonal."""
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
        residual: in the term's scales.
        norm: smoothed norms; None for a term with squares.
    """

    residual: Float[np.ndarray, "keypoints groups rows"]
    norm: Float[np.ndarray, "keypoints groups"] | None

    @cached_property
    def unit(self) -> Float[np.ndarray, "keypoints groups rows"]:
        """Derivative of the term by its residual: the residual, divided by the norm if there is one."""
        return self.residual if self.norm is None else self.residual / self.norm[..., None]

    @abstractmethod
    def change(self, step: Float[np.ndarray, "keypoints joints"]) -> Float[np.ndarray, "keypoints groups rows"]:
        """Change of the residual with a step."""

    @abstractmethod
    def pull(self, residual: Float[np.ndarray, "keypoints groups rows"]) -> Float[np.ndarray, "keypoints joints"]:
        """Gradient J^T r of a residual r."""

    @abstractmethod
    def add_to(
        self, normal: NormalEquations, dual: Float[np.ndarray, "keypoints groups rows"] | None, curvature: float
    ) -> None:
        """Add J^T u and J^T W J with W = (I - c (z u^T + u z^T) / 2) / v for norms v, else W = I.

        Args:
            normal: what to add to.
            dual: z, or None for 0.
            curvature: c.
        """


@dataclass(frozen=True)
class JointRows(Rows):
    """Residuals with any derivatives by the joints.

    Attributes:
        jacobian: of the rows of all groups by the keypoint's own configuration.
        previous: by the previous keypoint's, from the second keypoint on; None if not coupled.
    """

    jacobian: Float[np.ndarray, "keypoints all_rows joints"]
    previous: Float[np.ndarray, "later_keypoints all_rows joints"] | None

    def change(self, step: Float[np.ndarray, "keypoints joints"]) -> Float[np.ndarray, "keypoints groups rows"]:
        """See `Rows`."""
        change = np.matvec(self.jacobian, step)
        if self.previous is not None:
            change[1:] += np.matvec(self.previous, step[:-1])
        return change.reshape(self.residual.shape)

    def pull(self, residual: Float[np.ndarray, "keypoints groups rows"]) -> Float[np.ndarray, "keypoints joints"]:
        """See `Rows`."""
        rows = residual.reshape(len(residual), -1)
        gradient = np.vecmat(rows, self.jacobian)
        if self.previous is not None:
            gradient[:-1] += np.vecmat(rows[1:], self.previous)
        return gradient

    def add_to(
        self, normal: NormalEquations, dual: Float[np.ndarray, "keypoints groups rows"] | None, curvature: float
    ) -> None:
        """See `Rows`."""
        unit = self.unit
        normal.gradient += self.pull(unit)
        weighted = self._weighted(self.jacobian, slice(None), unit, dual, curvature)
        normal.add_rows(self.jacobian, weighted)
        if self.previous is not None:
            before = self._weighted(self.previous, slice(1, None), unit, dual, curvature)
            normal.diagonal[:-1] += self.previous.mT @ before
            normal.coupling[1:] += self.jacobian[1:].mT @ before

    def _weighted(
        self,
        jacobian: Float[np.ndarray, "some_keypoints all_rows joints"],
        of: slice,
        unit: Float[np.ndarray, "keypoints groups rows"],
        dual: Float[np.ndarray, "keypoints groups rows"] | None,
        curvature: float,
    ) -> Float[np.ndarray, "some_keypoints all_rows joints"]:
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
        slope: derivative of the residual by the group's vector.
        vectors: derivative of the vectors by the joints.
        coupled: whether the residual depends on the vector's difference from the previous keypoint's.
    """

    slope: Float[np.ndarray, "keypoints groups rows 3"]
    vectors: Float[np.ndarray, "keypoints groups 3 joints"]
    coupled: bool = False

    @cached_property
    def _flat(self) -> Float[np.ndarray, "keypoints vectors joints"]:
        """Derivative of the vectors of all groups."""
        count, groups, _, joints = self.vectors.shape
        return self.vectors.reshape(count, 3 * groups, joints)

    def change(self, step: Float[np.ndarray, "keypoints joints"]) -> Float[np.ndarray, "keypoints groups rows"]:
        """See `Rows`."""
        vectors = np.matvec(self.vectors, step[:, None])
        if self.coupled:
            vectors = np.concatenate([vectors[:1], vectors[1:] - vectors[:-1]])
        return np.matvec(self.slope, vectors)

    def pull(self, residual: Float[np.ndarray, "keypoints groups rows"]) -> Float[np.ndarray, "keypoints joints"]:
        """See `Rows`."""
        return self._pull(np.vecmat(residual, self.slope))

    def _pull(self, vectors: Float[np.ndarray, "keypoints groups 3"]) -> Float[np.ndarray, "keypoints joints"]:
        if self.coupled:
            vectors = np.concatenate([vectors[:-1] - vectors[1:], vectors[-1:]])
        return np.vecmat(vectors.reshape(len(vectors), -1), self._flat)

    def add_to(
        self, normal: NormalEquations, dual: Float[np.ndarray, "keypoints groups rows"] | None, curvature: float
    ) -> None:
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
    """Squares of scaled steps of the joints from keypoint to keypoint, as one group.

    Attributes:
        scale: factor from the step to the residual.
        first: whether the first keypoint has a step too.
    """

    scale: float
    first: bool

    def change(self, step: Float[np.ndarray, "keypoints joints"]) -> Float[np.ndarray, "keypoints 1 joints"]:
        """See `Rows`."""
        change = self.scale * step
        change[1:] -= self.scale * step[:-1]
        if not self.first:
            change[0] = 0.0
        return change[:, None]

    def pull(self, residual: Float[np.ndarray, "keypoints 1 joints"]) -> Float[np.ndarray, "keypoints joints"]:
        """See `Rows`."""
        gradient = self.scale * residual[:, 0]
        if not self.first:
            gradient[0] = 0.0
        gradient[:-1] -= self.scale * residual[1:, 0]
        return gradient

    def add_to(
        self, normal: NormalEquations, dual: Float[np.ndarray, "keypoints 1 joints"] | None, curvature: float
    ) -> None:
        """See `Rows`."""
        normal.gradient += self.pull(self.residual)
        square = self.scale**2
        steps = np.full(len(self.residual), 2.0)
        steps[-1] -= 1.0
        steps[0] -= not self.first
        np.einsum("kii->ki", normal.diagonal)[:] += square * steps[:, None]
        np.einsum("kii->ki", normal.coupling)[1:] -= square
