"""Generalised changes of affordance constraints over time (the paper's GCACOT)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.constraints.region_pair import RegionPair


@dataclass(frozen=True)
class GeneralizedChannel:
    """One channel of a constraint over time: keypoints with mean and standard deviation, linear between them.

    Attributes:
        name: name of the channel, such as ``rho``.
        unit: ``m``, ``rad`` or ``log`` (natural logarithm of a density).
        time: (M,) s on the model's time axis, strictly increasing, first 0, last the model's duration.
        mean: (M,) in ``unit``; an azimuth is unwrapped along time.
        std: (M,) in ``unit``.
        count: (M,) demonstrations that a keypoint has seen.
    """

    name: str
    unit: str
    time: NDArray[np.float64]
    mean: NDArray[np.float64]
    std: NDArray[np.float64]
    count: NDArray[np.int64]


@dataclass(frozen=True)
class GeneralizedChange:
    """How the constraint between one pair of regions changes over time, over all demonstrations.

    Attributes:
        pair: the two regions.
        constraint: name of the constraint type (own-start pairs are Cartesian whatever the model's type).
        channels: one per channel of the type, in its order.
    """

    pair: RegionPair
    constraint: str
    channels: tuple[GeneralizedChannel, ...]

    def at(self, time: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean and standard deviation at the given times.

        Args:
            time: (K,) s on the model's time axis.

        Returns:
            Mean and standard deviation, each (K, C), in the channels' units.
        """
        mean = np.stack([np.interp(time, channel.time, channel.mean) for channel in self.channels], axis=-1)
        std = np.stack([np.interp(time, channel.time, channel.std) for channel in self.channels], axis=-1)
        return mean, std
