"""Generalised changes of affordance constraints over time (the paper's GCACOT)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from sbam.constraints.region_pair import RegionPair


@dataclass(frozen=True)
class GeneralizedChannel:
    """One channel of a constraint over time: keypoints with mean and standard deviation, linear between them.

    Attributes:
        name: name of the channel, such as ``rho``.
        unit: see `sbam.constraints.base.Unit`.
        time: s on the model's time axis, strictly increasing, first 0, last the model's duration.
        mean: in ``unit``; an azimuth is unwrapped along time.
        std: in ``unit``.
        count: demonstrations that a keypoint has seen.
    """

    name: str
    unit: str
    time: Float[np.ndarray, " keypoints"]
    mean: Float[np.ndarray, " keypoints"]
    std: Float[np.ndarray, " keypoints"]
    count: Int[np.ndarray, " keypoints"]


@dataclass(frozen=True)
class GeneralizedChange:
    """How the constraint between one pair of regions changes over time, over all demonstrations.

    Attributes:
        pair: the two regions.
        constraint: name of the constraint type (own-start pairs are Cartesian whatever the model's type).
        channels: one per channel of the type, in its order.
        from_agent: whether the vector is measured in the plane from the agent's origin instead of from the second
            region; see `pair_vector`.
    """

    pair: RegionPair
    constraint: str
    channels: tuple[GeneralizedChannel, ...]
    from_agent: bool = False

    def at(
        self, time: Float[np.ndarray, " samples"]
    ) -> tuple[Float[np.ndarray, "samples channels"], Float[np.ndarray, "samples channels"]]:
        """Mean and standard deviation at the given times.

        Args:
            time: s on the model's time axis.

        Returns:
            Mean and standard deviation, in the channels' units.
        """
        mean = np.stack([np.interp(time, channel.time, channel.mean) for channel in self.channels], axis=-1)
        std = np.stack([np.interp(time, channel.time, channel.std) for channel in self.channels], axis=-1)
        return mean, std


def pair_vector(
    first: Float[np.ndarray, "*#batch 3"], second: Float[np.ndarray, "*#batch 3"], from_agent: bool
) -> Float[np.ndarray, "*#batch 3"]:
    """The vector between two regions, first - second, m, agent frame.

    Things may be placed anywhere on a support: its ellipse is a tolerance and its centre is arbitrary, while people
    work where their hands reach well. ``from_agent`` measures in the plane from the agent's origin instead, and only
    heights from the second region.
    """
    return first - second * [0.0, 0.0, 1.0] if from_agent else first - second
