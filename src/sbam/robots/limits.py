"""Joint limits to plan with: the robot's own, less a margin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.robots.robot import Robot

Array = NDArray[np.float64]

LIMIT_MARGIN = 0.005  # rad (or m) kept from every limit, so that splines between configurations do not exceed it


def planning_limits(robot: Robot) -> tuple[Array, Array]:
    """Lower and upper joint limits (n,) to plan with, rad or m; infinite for continuous joints."""
    return robot.lower + LIMIT_MARGIN, robot.upper - LIMIT_MARGIN
