"""What a constraint type is: a way to see the vector between two affordance regions (paper, section III-A)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np
from jaxtyping import Bool, Float

MILLIMETRES_PER_METRE = 1000.0

Unit = Literal["m", "rad", "log", "1"]
"""Units of channels: lengths, angles (that wrap), natural logarithms, and other numbers without a dimension."""


@dataclass(frozen=True)
class ConstraintType(ABC):
    r"""Channels of a vector :math:`d` (m, agent frame), their derivatives, and a weighted distance from a target.

    The similarity of the paper (section III-D) is the squared norm of a residual. All methods work over any leading
    axes.

    .. math:: s(d) = \left\lVert r(d, c^*, w) \right\rVert^2

    Two kinds of weights :math:`w_c` of a channel with standard deviation :math:`\sigma_c`:

    - ``paper``: :math:`1 / (1 + \sigma_c)` with the standard deviation in mm, rad or log units; the residual is in mm
      (symbolic: log units). The factor from metres to millimetres is part of the weights of length channels.
    - ``default``: :math:`1 / \sqrt{\sigma_c^2 + \epsilon^2}` with a floor :math:`\epsilon`; the residual is
      dimensionless, so that types can be mixed.

    A type of one's own is a frozen dataclass that derives from this one, says its names and units, and is registered
    in the group ``sbam.constraints``. What the rest of SBAM asks of a type is here: no other part knows a type by name
    or what its channels mean.

    Attributes:
        mode: which weights (and, for some types, which similarity).
        length_floor: floor of the standard deviation of lengths in mode ``default``, m.
        log_floor: floor of the standard deviation of log-densities in mode ``default``, log units.
    """

    mode: Literal["default", "paper"] = "default"
    length_floor: float = 0.005
    log_floor: float = 0.05

    name: ClassVar[str]
    channel_names: ClassVar[tuple[str, ...]]
    channel_units: ClassVar[tuple[Unit, ...]]
    spread_unit: ClassVar[Unit] = "m"
    """Unit of `spread`; spreads are compared among pairs that have the same."""
    paper_damping: ClassVar[float] = 1e-3
    """Mode ``paper``: t_d's weight per time step and mean standard deviation, 1/(mm s) or, of
    logarithms, 1/s. Larger values stop the pour."""

    def __init_subclass__(cls) -> None:
        """Refuse units that nobody knows, before they are learned with."""
        units: tuple[str, ...] = getattr(cls, "channel_units", ())
        if unknown := set(units) - set(get_args(Unit)):
            raise TypeError(f"{cls.__name__}: unknown unit {min(unknown)!r}; known: {', '.join(get_args(Unit))}")
        if len(units) != len(getattr(cls, "channel_names", ())):
            raise TypeError(f"{cls.__name__}: each of the channel_names needs one of the channel_units")

    @property
    def spread_floor(self) -> float:
        """Least `spread` that is told from none, in `spread_unit`."""
        return self.length_floor

    @property
    def circular(self) -> Bool[np.ndarray, " channels"]:
        """Which channels are angles."""
        return np.array([unit == "rad" for unit in self.channel_units])

    def in_mode(self, mode: Literal["default", "paper"]) -> ConstraintType:
        """The same type with the weights of another mode."""
        return replace(self, mode=mode)

    @abstractmethod
    def channels(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch channels"]:
        """Channels of vectors ``d``, m."""

    @abstractmethod
    def vector(self, channels: Float[np.ndarray, "*batch channels"]) -> Float[np.ndarray, "*batch 3"]:
        """Vectors, m, with the given channels; the nearest sense where channels contradict."""

    @abstractmethod
    def jacobian(self, d: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch channels 3"]:
        """Derivatives of the channels; 0 where a channel has none (azimuth at rho = 0)."""

    @abstractmethod
    def residual(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch channels"],
        weight: Float[np.ndarray, "*#batch channels"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals"]:
        """Weighted deviation whose squared norm is the similarity.

        Args:
            d: current vectors, m.
            target: target channels.
            weight: from `weights`.
            delta_rho: smooths what has a kink at rho = 0, m; 0 is exact.

        Returns:
            As many numbers as the type and mode fix.
        """

    @abstractmethod
    def residual_jacobian(
        self,
        d: Float[np.ndarray, "*#batch 3"],
        target: Float[np.ndarray, "*#batch channels"],
        weight: Float[np.ndarray, "*#batch channels"],
        delta_rho: float = 0.0,
    ) -> Float[np.ndarray, "*#batch residuals 3"]:
        """Derivative of `residual` by ``d``."""

    @abstractmethod
    def weights(
        self, std: Float[np.ndarray, "*#batch channels"], target: Float[np.ndarray, "*#batch channels"]
    ) -> Float[np.ndarray, "*#batch channels"]:
        """Weights for standard deviations at a target, both in the channels' units."""

    def spread(
        self, std: Float[np.ndarray, "*batch channels"], mean: Float[np.ndarray, "*batch channels"]
    ) -> Float[np.ndarray, "*batch"]:
        r"""One number for the standard deviations of all channels, by which pairs are compared.

        .. math:: \sqrt{\sum_c \left(\sigma_c / \lVert \nabla c \rVert \right)^2}

        with the channels' derivatives at the mean: how far the vector moves when a channel deviates, so that angles
        count as arcs. For a type whose channels do not point along different directions it is to be overridden.

        Args:
            std: standard deviations, in the channels' units.
            mean: mean channels.

        Returns:
            In `spread_unit`: m.
        """
        slope = np.linalg.norm(self.jacobian(self.vector(mean)), axis=-1)
        # A channel without a derivative there, such as an azimuth at radius 0, moves nothing.
        deviation = np.divide(std, slope, out=np.zeros_like(slope), where=slope > 0.0)
        return np.asarray(np.linalg.norm(deviation, axis=-1))

    def _length_weight(self, std: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """Weight of a length with standard deviation ``std``, m."""
        if self.mode == "paper":
            return MILLIMETRES_PER_METRE / (1.0 + MILLIMETRES_PER_METRE * std)
        return 1.0 / np.sqrt(std**2 + self.length_floor**2)


def smooth_radius(
    d: Float[np.ndarray, "*batch 3"], delta_rho: float
) -> tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch 2"], Float[np.ndarray, "*batch"]]:
    """Radius in the horizontal plane, without a kink at 0.

    With ``D = sqrt(rho^2 + delta^2)`` the smooth radius is ``rho^2 / D``: 0 at 0, and rho for ``delta`` = 0.

    Args:
        d: m.
        delta_rho: delta, m.

    Returns:
        The radius, m; its derivative by (dx, dy); and D, m, which is never 0.
    """
    squared = d[..., 0] ** 2 + d[..., 1] ** 2
    denominator = np.asarray(np.sqrt(squared + (delta_rho**2 + 1e-24)))
    slope = (squared + 2.0 * delta_rho**2) / denominator**3
    return np.asarray(squared / denominator), np.asarray(slope)[..., None] * d[..., :2], denominator


def wrap(angle: Float[np.ndarray | np.float64, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """The same angle within [-pi, pi), rad."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
