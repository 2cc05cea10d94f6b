"""Cartesian affordance constraint, CaAC (paper, section III-A1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float

from sbam.constraints.base import ConstraintType, Unit


@dataclass(frozen=True)
class Cartesian(ConstraintType):
    r"""Channels :math:`x, y, z` (m).

    .. math:: s = \sum_{c \in \{x, y, z\}} w_c^2 (c - c^*)^2
    """

    name: ClassVar[str] = "cartesian"
    channel_names: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    channel_units: ClassVar[tuple[Unit, ...]] = ("m", "m", "m")

    def channels(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """The vector itself."""
        return np.array(d, dtype=np.float64)

    def vector(self, channels: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """The channels themselves."""
        return np.asarray(channels, dtype=np.float64)

    def jacobian(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
        """The identity."""
        return np.broadcast_to(np.eye(3), (*np.shape(d), 3)).copy()

    def residual(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 3"],
        weight: Float[np.ndarray, "*#batch 3"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals"]:
        """``w (d - d*)``; see `ConstraintType.residual`."""
        return weight * (d - target)

    def residual_jacobian(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch 3"],
        weight: Float[np.ndarray, "*#batch 3"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals 3"]:
        """``diag(w)``."""
        return np.broadcast_to(weight, np.broadcast_shapes(np.shape(d), np.shape(weight)))[..., None] * np.eye(3)

    def weights(
        self, std: Float[np.ndarray, "*#batch 3"], target: Float[np.ndarray, "*#batch 3"]
    ) -> Float[np.ndarray, "*#batch 3"]:
        """Weights of x, y and z; see `ConstraintType`."""
        return self._length_weight(np.asarray(std, dtype=np.float64))
