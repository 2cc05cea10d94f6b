"""What a constraint type is: a way to see the vector between two affordance regions (paper, section III-A)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MILLIMETRES_PER_METRE = 1000.0


@dataclass(frozen=True)
class ConstraintType(ABC):
    """Channels of a vector ``d`` (m, agent frame), their derivatives, and a weighted distance from a target.

    The similarity of the paper (section III-D) is ``s = |residual|^2``. All methods work over any leading axes.

    Two kinds of weights:

    - ``paper``: ``1 / (1 + std)`` with std in mm, rad or log units; the residual is in mm (symbolic: log units). The
      factor from metres to millimetres is part of the weights of length channels.
    - ``default``: ``1 / sqrt(std^2 + floor^2)``; the residual is dimensionless, so that types can be mixed.

    Attributes:
        mode: which weights (and, for the cylindrical type, which similarity).
        length_floor: floor of the standard deviation of lengths in mode ``default``, m.
        log_floor: floor of the standard deviation of log-densities in mode ``default``, log units.
    """

    mode: Literal["default", "paper"] = "default"
    length_floor: float = 0.005
    log_floor: float = 0.05

    name: ClassVar[str]
    channel_names: ClassVar[tuple[str, ...]]
    channel_units: ClassVar[tuple[str, ...]]

    @property
    def circular(self) -> NDArray[np.bool_]:
        """Which channels are angles, (C,)."""
        return np.array([unit == "rad" for unit in self.channel_units])

    def in_mode(self, mode: Literal["default", "paper"]) -> Self:
        """The same type with the weights of another mode."""
        return replace(self, mode=mode)

    @abstractmethod
    def channels(self, d: Array) -> Array:
        """Channels (..., C) of vectors ``d`` (..., 3), m."""

    @abstractmethod
    def vector(self, channels: Array) -> Array:
        """Vectors (..., 3), m, with the given channels (..., C); the nearest sense where channels contradict."""

    @abstractmethod
    def jacobian(self, d: Array) -> Array:
        """Derivatives (..., C, 3) of the channels; 0 where a channel has none (azimuth at rho = 0)."""

    @abstractmethod
    def residual(self, d: Array, target: Array, weight: Array, delta_rho: float = 0.0) -> Array:
        """Weighted deviation whose squared norm is the similarity.

        Args:
            d: (..., 3) current vectors, m.
            target: (..., C) target channels.
            weight: (..., C) from `weights`.
            delta_rho: smooths what has a kink at rho = 0, m; 0 is exact.

        Returns:
            (..., m), with m fixed per type and mode.
        """

    @abstractmethod
    def residual_jacobian(self, d: Array, target: Array, weight: Array, delta_rho: float = 0.0) -> Array:
        """Derivative (..., m, 3) of `residual` by ``d``."""

    @abstractmethod
    def weights(self, std: Array, target: Array) -> Array:
        """Weights (..., C) for standard deviations (..., C) at a target (..., C), both in the channels' units."""

    def _length_weight(self, std: Array) -> Array:
        """Weight of a length with standard deviation ``std``, m."""
        if self.mode == "paper":
            return MILLIMETRES_PER_METRE / (1.0 + MILLIMETRES_PER_METRE * std)
        return 1.0 / np.sqrt(std**2 + self.length_floor**2)


def smooth_radius(d: Array, delta_rho: float) -> tuple[Array, Array, Array]:
    """Radius in the horizontal plane, without a kink at 0.

    With ``D = sqrt(rho^2 + delta^2)`` the smooth radius is ``rho^2 / D``: 0 at 0, and rho for ``delta`` = 0.

    Args:
        d: (..., 3) m.
        delta_rho: delta, m.

    Returns:
        The radius (...), m; its derivative by (dx, dy), (..., 2); and D (...), m, which is never 0.
    """
    squared = d[..., 0] ** 2 + d[..., 1] ** 2
    denominator = np.sqrt(squared + (delta_rho**2 + 1e-24))
    slope = (squared + 2.0 * delta_rho**2) / denominator**3
    return squared / denominator, slope[..., None] * d[..., :2], denominator


def wrap(angle: Array) -> Array:
    """The same angle within [-pi, pi), rad."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
