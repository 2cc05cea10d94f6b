"""A timed joint trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class JointTrajectory:
    """Positions, velocities and accelerations of named joints over time.

    Attributes:
        joint_names: names, in the order of the columns.
        time: s, strictly increasing, starts at 0.
        position: rad (m for prismatic joints).
        velocity: rad/s.
        acceleration: rad/s^2.
    """

    joint_names: tuple[str, ...]
    time: Float[np.ndarray, " samples"]
    position: Float[np.ndarray, "samples joints"]
    velocity: Float[np.ndarray, "samples joints"]
    acceleration: Float[np.ndarray, "samples joints"]

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(self.time[-1])
