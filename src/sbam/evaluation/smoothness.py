"""How smoothly objects and arms move: log dimensionless jerk (Balasubramanian et al. 2012), speed and travel."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from sbam.demonstrations.signals import even_times, smooth_positions
from sbam.planning.trajectory.trajectory import JointTrajectory

OBJECT_MOVES = 0.01  # m/s: a slower object rests
ARMS_MOVE = 0.01  # rad/s: the norm over all joints of arms that move
WAITS = 0.5  # of the median pace of the model's clock, below which one arm waits for the other


def path_smoothness(
    prefix: str, time: Float[np.ndarray, " samples"], path: Float[np.ndarray, "samples 3"]
) -> dict[str, float]:
    """Largest speed and log dimensionless jerk of an object's path, below 5 Hz."""
    grid = even_times(time)
    step = float(grid[1] - grid[0])
    smooth = smooth_positions(path, time, grid)
    velocity = np.gradient(smooth, step, axis=0)
    values = {f"{prefix}largest speed [mm/s]": 1e3 * float(np.linalg.norm(velocity, axis=1).max())}
    jerk = np.diff(smooth, n=3, axis=0) / step**3
    return values | _log_jerk(prefix, grid, velocity, jerk, OBJECT_MOVES)


def joint_smoothness(trajectory: JointTrajectory, clock: Float[np.ndarray, " samples"]) -> dict[str, float]:
    """How far the arms move in joint space, how fast at the pace of the demonstrations, and how jerkily.

    That speed is not defined while the action waits for one arm to pass, and leaves it out.

    Args:
        trajectory: of all joints; its limits have stretched time.
        clock: time on the model's axis of its samples, s.
    """
    time, velocity = trajectory.time, trajectory.velocity
    pace = np.gradient(clock, time)
    moving = pace > WAITS * np.median(pace)
    jerk = np.gradient(trajectory.acceleration, time, axis=0)
    values = {
        "joints: travel [rad]": float(np.linalg.norm(np.diff(trajectory.position, axis=0), axis=1).sum()),
        "joints: largest speed at the demonstrations' pace [rad/s]": float(
            (np.abs(velocity[moving]) / pace[moving, None]).max(initial=0.0)
        ),
    }
    return values | _log_jerk("joints: ", time, velocity, jerk, ARMS_MOVE)


def _log_jerk(
    prefix: str,
    time: Float[np.ndarray, " samples"],
    velocity: Float[np.ndarray, "samples channels"],
    jerk: Float[np.ndarray, "samples channels"],
    least: float,
) -> dict[str, float]:
    """ln(integral of |jerk|^2 * duration^3 / peak speed^2) of what moves faster than ``least``; {} if nothing does."""
    speed = np.linalg.norm(velocity, axis=1)
    moving = speed > least
    if not moving.any():
        return {}
    step = float(time[1] - time[0])
    dimensionless = np.square(jerk).sum() * step * float(np.ptp(time[moving])) ** 3 / speed.max() ** 2
    return {f"{prefix}log dimensionless jerk": float(np.log(max(dimensionless, 1e-12)))}
