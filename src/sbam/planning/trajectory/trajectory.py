"""A timed joint trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointTrajectory:
    """Positions, velocities and accelerations of named joints over time.

    Attributes:
        joint_names: (n,) names, in the order of the columns.
        time: (N,) s, strictly increasing, starts at 0.
        position: (N, n) rad (m for prismatic joints).
        velocity: (N, n) rad/s.
        acceleration: (N, n) rad/s^2.
    """

    joint_names: tuple[str, ...]
    time: Array
    position: Array
    velocity: Array
    acceleration: Array

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(self.time[-1])
