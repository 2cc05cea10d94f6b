"""Symbolic spatial affordance constraint, SSAC (paper, section III-A3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from scipy.special import i0e

from sbam.constraints.base import MILLIMETRES_PER_METRE, ConstraintType, Unit, smooth_radius


@dataclass(frozen=True)
class SpatialRelation:
    """One row of the paper's table of spatial relations.

    The paper heads the spreads "sigma^2"; read as standard deviations they reproduce its log-densities.

    Attributes:
        name: name of the relation.
        mean_rho: mean of the radius's normal distribution, m.
        std_rho: its standard deviation, m.
        mean_phi: mean of the azimuth's von Mises distribution, rad.
        kappa_phi: its concentration.
        mean_z: mean of the elevation's normal distribution, m.
        std_z: its standard deviation, m.
    """

    name: str
    mean_rho: float
    std_rho: float
    mean_phi: float
    kappa_phi: float
    mean_z: float
    std_z: float


SPATIAL_RELATIONS = (
    SpatialRelation("above", 0.0, 0.25, 0.0, 1e-5, 0.25, 0.1),
    SpatialRelation("below", 0.0, 0.25, 0.0, 1e-5, -0.25, 0.1),
    SpatialRelation("close", 0.0, 0.1, 0.0, 1e-5, 0.0, 0.25),
    SpatialRelation("far_away", 0.5, 0.1, 0.0, 1e-5, 0.0, 0.25),
    SpatialRelation("in_front", 0.0, 0.25, 1.5 * np.pi, 5.0, 0.0, 0.25),
    SpatialRelation("behind", 0.0, 0.25, 0.5 * np.pi, 5.0, 0.0, 0.25),
    SpatialRelation("left", 0.0, 0.25, np.pi, 5.0, 0.0, 0.25),
    SpatialRelation("right", 0.0, 0.25, 0.0, 5.0, 0.0, 0.25),
)


def _linear_form(
    relations: tuple[SpatialRelation, ...],
) -> tuple[Float[np.ndarray, "6 channels"], Float[np.ndarray, " channels"]]:
    """Log-densities as ``features @ A + b`` with features (rho^2, rho, cos phi, sin phi, z^2, z).

    ``b`` makes them densities per mm^2 and rad, as in the paper; another unit would only shift every value alike.
    """
    matrix, offset = np.empty((6, len(relations))), np.empty(len(relations))
    for column, r in enumerate(relations):
        matrix[:, column] = (
            -0.5 / r.std_rho**2,
            r.mean_rho / r.std_rho**2,
            r.kappa_phi * np.cos(r.mean_phi),
            r.kappa_phi * np.sin(r.mean_phi),
            -0.5 / r.std_z**2,
            r.mean_z / r.std_z**2,
        )
        spread = np.log(2.0 * np.pi * r.std_rho * r.std_z * MILLIMETRES_PER_METRE**2)
        von_mises = np.log(2.0 * np.pi * i0e(r.kappa_phi)) + r.kappa_phi
        offset[column] = -0.5 * ((r.mean_rho / r.std_rho) ** 2 + (r.mean_z / r.std_z) ** 2) - spread - von_mises
    return matrix, offset


_MATRIX, _OFFSET = _linear_form(SPATIAL_RELATIONS)
_INVERSE = np.linalg.pinv(_MATRIX)

VERTICAL = 1e-4
"""Vectors that are no further than about this from vertical have no azimuth, m; without it the log-densities of a
vertical vector, which standing objects have, would jump with every rounding."""


@dataclass(frozen=True)
class Symbolic(ConstraintType):
    r"""Channels: the log-density :math:`\log v_c` of each spatial relation.

    .. math:: s = \sum_c \left( w_c (\log v_c - \log v_c^*) \right)^2

    Logarithms are taken analytically; nothing underflows. The azimuth's unit vector is
    :math:`(x, y) / \sqrt{\rho^2 + \epsilon^2}` with :math:`\epsilon` = `VERTICAL`: continuous where the azimuth is not.
    """

    name: ClassVar[str] = "symbolic"
    channel_names: ClassVar[tuple[str, ...]] = tuple(relation.name for relation in SPATIAL_RELATIONS)
    channel_units: ClassVar[tuple[Unit, ...]] = ("log",) * len(SPATIAL_RELATIONS)
    spread_unit: ClassVar[Unit] = "log"
    paper_damping: ClassVar[float] = 1e-4

    @property
    def spread_floor(self) -> float:
        """See `ConstraintType`."""
        return self.log_floor

    def channels(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 8"]:
        """Log-densities."""
        return self._log_densities(d, 0.0)

    def vector(self, channels: Float[np.ndarray, "*batch 8"]) -> Float[np.ndarray, "*batch 3"]:
        """The log-densities are linear in (rho^2, rho, cos phi, sin phi, z^2, z): those by least squares, then d."""
        features = (channels - _OFFSET) @ _INVERSE
        rho, phi = np.maximum(features[..., 1], 0.0), np.arctan2(features[..., 3], features[..., 2])
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), features[..., 5]], axis=-1)

    def jacobian(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 8 3"]:
        """Derivatives of the log-densities."""
        return self._log_density_jacobian(d, 0.0)

    def residual(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 8"],
        weight: Float[np.ndarray, "*#batch 8"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals"]:
        """``w (log v - log v*)``; see `ConstraintType.residual`."""
        return weight * (self._log_densities(d, delta_rho) - target)

    def residual_jacobian(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 8"],
        weight: Float[np.ndarray, "*#batch 8"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals 3"]:
        """Derivative of `residual`."""
        return weight[..., None] * self._log_density_jacobian(d, delta_rho)

    def weights(
        self, std: Float[np.ndarray, "*#batch channels"], target: Float[np.ndarray, "*#batch channels"]
    ) -> Float[np.ndarray, "*#batch channels"]:
        """Weights of the relations; see `ConstraintType`."""
        std = np.asarray(std, dtype=np.float64)
        if self.mode == "paper":
            return 1.0 / (1.0 + std)
        return 1.0 / np.hypot(std, self.log_floor)

    def spread(
        self, std: Float[np.ndarray, "*batch channels"], mean: Float[np.ndarray, "*batch channels"]
    ) -> Float[np.ndarray, "*batch"]:
        """Norm of the standard deviations; the eight channels see one vector from overlapping sides."""
        return np.asarray(np.linalg.norm(std, axis=-1))

    @staticmethod
    def _log_densities(d: Float[np.ndarray, "*batch 3"], delta_rho: float) -> Float[np.ndarray, "*batch 8"]:
        radius, _, _ = smooth_radius(d, delta_rho)
        unit, _ = _azimuth(d, delta_rho)
        features = np.empty((*np.shape(radius), 6))
        features[..., 0] = d[..., 0] ** 2 + d[..., 1] ** 2
        features[..., 1] = radius
        features[..., 2:4] = unit
        features[..., 4] = d[..., 2] ** 2
        features[..., 5] = d[..., 2]
        return features @ _MATRIX + _OFFSET

    @staticmethod
    def _log_density_jacobian(d: Float[np.ndarray, "*batch 3"], delta_rho: float) -> Float[np.ndarray, "*batch 8 3"]:
        _, slope, _ = smooth_radius(d, delta_rho)
        unit, denominator = _azimuth(d, delta_rho)
        features = np.zeros((*np.shape(denominator), 6, 3))
        features[..., 0, :2] = 2.0 * d[..., :2]
        features[..., 1, :2] = slope
        cross = -unit[..., 0] * unit[..., 1]
        features[..., 2, 0] = (1.0 - unit[..., 0] ** 2) / denominator
        features[..., 2, 1] = features[..., 3, 0] = cross / denominator
        features[..., 3, 1] = (1.0 - unit[..., 1] ** 2) / denominator
        features[..., 4, 2] = 2.0 * d[..., 2]
        features[..., 5, 2] = 1.0
        return _MATRIX.T @ features


def _azimuth(
    d: Float[np.ndarray, "*batch 3"], delta_rho: float
) -> tuple[Float[np.ndarray, "*batch 2"], Float[np.ndarray, "*batch"]]:
    """The azimuth's unit vector, which fades at rho = 0, and by what (x, y) is divided, m."""
    denominator = np.asarray(np.sqrt(d[..., 0] ** 2 + d[..., 1] ** 2 + (delta_rho**2 + VERTICAL**2)))
    return d[..., :2] / denominator[..., None], denominator
