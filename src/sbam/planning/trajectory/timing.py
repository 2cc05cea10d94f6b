"""Time a joint path so that the robot's limits hold: slower where needed, never faster than demonstrated."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.interpolate import BSpline, make_interp_spline
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from sbam.errors import TrajectoryError
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.robots import Robot

WINDOW = 0.15  # s on the path's clock over which the speed changes
MARGIN = 0.97  # share of a limit that is used, so that sampling in between does not exceed it
MAX_ROUNDS = 60


def time_path(
    robot: Robot,
    clock: Float[np.ndarray, " ticks"],
    path: Float[np.ndarray, "ticks joints"],
    speed: float,
    sample_rate: float,
) -> tuple[JointTrajectory, Float[np.ndarray, " samples"]]:
    """Time a path that carries the demonstrated timing as its clock.

    The clock's rate s = d clock/d time is 1 where the limits allow it and smoothly less elsewhere. With Q the quintic
    spline through the path: velocity Q' s, acceleration Q'' s^2 + Q' s' s. The rate is lowered until all limits hold.

    Args:
        robot: its velocity, acceleration and jerk limits.
        clock: uniform, s.
        path: configurations at rest at both ends.
        speed: share of the velocity limits that may be used; accelerations scale with its square, jerks with its cube.
        sample_rate: samples of the result per second, Hz.

    Returns:
        The trajectory, and for each of its samples the time on the clock, s.

    Raises:
        TrajectoryError: if no rate is found that keeps the limits.
    """
    rest = [(order, np.zeros(path.shape[1])) for order in (1, 2)]
    spline = make_interp_spline(clock, path, k=5, bc_type=(rest, rest))
    fine = np.linspace(clock[0], clock[-1], 5 * (len(clock) - 1) + 1)
    derivatives = [spline(fine, order) for order in (1, 2, 3)]
    velocity_limit = MARGIN * speed * robot.velocity_limit
    acceleration_limit = MARGIN * speed**2 * robot.acceleration_limit
    jerk_limit = MARGIN * speed**3 * robot.jerk_limit
    step = float(fine[1] - fine[0])
    width = WINDOW / step
    allowed = np.ones(len(fine))
    excess = np.ones(len(fine))
    for _ in range(MAX_ROUNDS):
        rate = _smooth(allowed, width)
        slope = np.gradient(rate, step)
        bend = np.gradient(slope, step)
        velocity = derivatives[0] * rate[:, None]
        acceleration = derivatives[1] * rate[:, None] ** 2 + derivatives[0] * (rate * slope)[:, None]
        jerk = (
            derivatives[2] * rate[:, None] ** 3
            + 3.0 * derivatives[1] * (rate**2 * slope)[:, None]
            + derivatives[0] * (rate * slope**2 + rate**2 * bend)[:, None]
        )
        excess = np.maximum.reduce(
            [
                (np.abs(velocity) / velocity_limit).max(axis=1),
                np.sqrt((np.abs(acceleration) / acceleration_limit).max(axis=1)),
                np.cbrt((np.abs(jerk) / jerk_limit).max(axis=1)),
            ]
        )
        if excess.max() <= 1.0:
            return _sample(robot, spline, fine, rate, sample_rate)
        allowed = np.minimum(allowed, np.where(excess > 1.0, rate / (1.02 * excess), allowed))
    raise TrajectoryError(
        f"no timing keeps the limits of {robot.name}: {excess.max():.1f} times too fast at "
        f"{fine[int(excess.argmax())]:.2f} s of the path even when slowed down"
    )


def _smooth(allowed: Float[np.ndarray, " fine"], width: float) -> Float[np.ndarray, " fine"]:
    """A smooth lower envelope: never above what is allowed, with bounded slope."""
    reach = int(np.ceil(3.0 * width))
    lowest = minimum_filter1d(allowed, 2 * reach + 1, mode="nearest")
    return gaussian_filter1d(lowest, width, mode="nearest", truncate=3.0)


def _sample(
    robot: Robot,
    spline: BSpline,
    fine: Float[np.ndarray, " fine"],
    rate: Float[np.ndarray, " fine"],
    sample_rate: float,
) -> tuple[JointTrajectory, Float[np.ndarray, " samples"]]:
    """Integrate dt = d clock / s and sample uniformly in time."""
    slowness = make_interp_spline(fine, 1.0 / rate, k=3)
    elapsed = slowness.antiderivative()
    at_fine = elapsed(fine) - elapsed(fine[0])
    duration = float(at_fine[-1])
    count = int(np.ceil(duration * sample_rate)) + 1
    time = np.arange(count) / sample_rate
    clock = np.interp(np.minimum(time, duration), at_fine, fine)
    for _ in range(3):  # Newton: elapsed(clock) = time
        error = elapsed(clock) - elapsed(fine[0]) - np.minimum(time, duration)
        clock = np.clip(clock - error / slowness(clock), fine[0], fine[-1])
    s = 1.0 / slowness(clock)
    slope = -slowness(clock, 1) * s**2
    first, second = spline(clock, 1), spline(clock, 2)
    velocity = first * s[:, None]
    acceleration = second * s[:, None] ** 2 + first * (s * slope)[:, None]
    ended = time >= duration
    velocity[ended] = 0.0
    acceleration[ended] = 0.0
    velocity[0] = 0.0
    acceleration[0] = 0.0
    return JointTrajectory(robot.joint_names, time, spline(clock), velocity, acceleration), clock
