"""Cylindrical affordance constraint, CyAC (paper, section III-A2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from sbam.constraints.base import ConstraintType, Unit, smooth_radius, wrap


@dataclass(frozen=True)
class Cylindrical(ConstraintType):
    r"""Channels :math:`\rho` (m), :math:`\varphi` (rad), :math:`z` (m).

    Similarity in mode ``paper``, the paper's formula with the wrapped difference, which makes it continuous and
    independent of where the azimuth is measured from, with
    :math:`\alpha = w_\varphi \operatorname{wrap}(\varphi - \varphi^*)`:

    .. math::

        s &= w_\rho^2 (\rho^2 + {\rho^*}^2 - 2 \rho \rho^* \cos\alpha) + w_z^2 (z - z^*)^2 \\
          &= \left\lVert \left( w_\rho (\rho \cos\alpha - \rho^*),\;
             w_\rho \rho \sin\alpha,\; w_z (z - z^*) \right) \right\rVert^2

    In mode ``default``, where the three weights are independent, with the azimuth's unit vectors :math:`u` and
    :math:`u^*`:

    .. math::

        s &= w_\rho^2 (\rho - \rho^*)^2 + w_\varphi^2 \left(2 \sin\tfrac{\varphi - \varphi^*}{2}\right)^2
             + w_z^2 (z - z^*)^2 \\
          &= \left\lVert \left( w_\rho (\rho - \rho^*),\; w_\varphi (u - u^*),\; w_z (z - z^*) \right) \right\rVert^2
    """

    name: ClassVar[str] = "cylindrical"
    channel_names: ClassVar[tuple[str, ...]] = ("rho", "phi", "z")
    channel_units: ClassVar[tuple[Unit, ...]] = ("m", "rad", "m")

    def channels(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """Radius, azimuth in [-pi, pi] and elevation."""
        return np.stack([np.hypot(d[..., 0], d[..., 1]), np.arctan2(d[..., 1], d[..., 0]), d[..., 2]], axis=-1)

    def vector(self, channels: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """From polar to Cartesian coordinates."""
        rho, phi, z = channels[..., 0], channels[..., 1], channels[..., 2]
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=-1)

    def jacobian(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
        """Derivatives of the channels."""
        _, slope, rho = smooth_radius(d, 0.0)
        jacobian = np.zeros((*np.shape(d), 3))
        jacobian[..., 0, :2] = slope
        # Twice by rho: its square underflows before rho does.
        jacobian[..., 1, 0] = -d[..., 1] / rho / rho
        jacobian[..., 1, 1] = d[..., 0] / rho / rho
        jacobian[..., 2, 2] = 1.0
        return jacobian

    def residual(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 3"],
        weight: Float[np.ndarray, "*#batch 3"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals"]:
        """Three in mode ``paper``, four in mode ``default``; see the class and `ConstraintType.residual`."""
        radius, _, denominator = smooth_radius(d, delta_rho)
        elevation = weight[..., 2] * (d[..., 2] - target[..., 2])
        if self.mode == "paper":
            angle = weight[..., 1] * wrap(np.arctan2(d[..., 1], d[..., 0]) - target[..., 1])
            along = weight[..., 0] * (radius * np.cos(angle) - target[..., 0])
            return np.stack([along, weight[..., 0] * radius * np.sin(angle), elevation], axis=-1)
        right = weight[..., 1] * (d[..., 0] / denominator - np.cos(target[..., 1]))
        forward = weight[..., 1] * (d[..., 1] / denominator - np.sin(target[..., 1]))
        return np.stack([weight[..., 0] * (radius - target[..., 0]), right, forward, elevation], axis=-1)

    def residual_jacobian(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 3"],
        weight: Float[np.ndarray, "*#batch 3"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals 3"]:
        """Derivative of `residual`."""
        _, slope, denominator = smooth_radius(d, delta_rho)
        unit = d[..., :2] / denominator[..., None]
        jacobian = np.zeros((*np.shape(denominator), 3 if self.mode == "paper" else 4, 3))
        jacobian[..., -1, 2] = weight[..., 2]
        w_rho, w_phi = weight[..., 0, None], weight[..., 1, None]
        if self.mode == "paper":
            angle = w_phi * wrap(np.arctan2(d[..., 1], d[..., 0]) - target[..., 1])[..., None]
            cosine, sine = np.cos(angle), np.sin(angle)
            turn = w_phi * np.stack([-unit[..., 1], unit[..., 0]], axis=-1)  # radius times the angle's derivative
            jacobian[..., 0, :2] = w_rho * (cosine * slope - sine * turn)
            jacobian[..., 1, :2] = w_rho * (sine * slope + cosine * turn)
            return jacobian
        jacobian[..., 0, :2] = w_rho * slope
        scale = w_phi[..., 0] / denominator
        cross = -scale * unit[..., 0] * unit[..., 1]
        jacobian[..., 1, 0] = scale * (1.0 - unit[..., 0] ** 2)
        jacobian[..., 1, 1] = cross
        jacobian[..., 2, 0] = cross
        jacobian[..., 2, 1] = scale * (1.0 - unit[..., 1] ** 2)
        return jacobian

    def weights(
        self, std: Float[np.ndarray, "*#batch 3"], target: Float[np.ndarray, "*#batch 3"]
    ) -> Float[np.ndarray, "*#batch 3"]:
        """Weights of rho, phi and z; the floor of the azimuth is ``length_floor / rho*``, see `ConstraintType`."""
        std = np.asarray(std, dtype=np.float64)
        weight = self._length_weight(std)
        if self.mode == "paper":
            weight[..., 1] = 1.0 / (1.0 + std[..., 1])
        else:
            rho = np.abs(target[..., 0])
            weight[..., 1] = rho / np.hypot(rho * std[..., 1], self.length_floor)
        return weight
