"""What a trajectory must satisfy before it leaves: the rules that real receivers reject by, and our own.

Everything is judged on the emitted samples, once, here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.robots import Robot

START_TOLERANCE = 1e-3  # rad: Franka's interface wants the first point at the current posture
CONTINUITY = 1e-3  # rad/s: what finite differences of the positions may differ from the stated velocities


@dataclass(frozen=True)
class Check:
    """One requirement and the worst value found.

    Attributes:
        name: what is checked.
        ok: whether it holds.
        worst: worst value over all samples, in ``unit``.
        limit: the value that must not be passed (from above, or from below where ``worst`` is a clearance).
        unit: unit of both.
        where: joint, object or pair, and time of the worst value.
    """

    name: str
    ok: bool
    worst: float
    limit: float
    unit: str
    where: str = ""


def check_receivers(
    robot: Robot, trajectory: JointTrajectory, start: Float[np.ndarray, " joints"], speed: float = 1.0
) -> list[Check]:
    """The checks of ros2_control's joint trajectory controller and of Franka's interface.

    Args:
        robot: names and limits.
        trajectory: what would be sent.
        start: the posture the robot is in.
        speed: share of the velocity limits that is granted; accelerations by its square, jerks by its cube.

    Returns:
        The checks; a trajectory with wrong names or shapes gets only those that can still be judged.
    """
    t = trajectory
    count = len(t.time)
    shapes = {len(t.position), len(t.velocity), len(t.acceleration)} == {count}
    widths = {a.shape[-1] for a in (t.position, t.velocity, t.acceleration)} == {len(t.joint_names)}
    names = t.joint_names == robot.joint_names
    checks = [
        _flag("points", count >= 2, f"{count} points"),
        _flag("joint names", names, "" if names else f"{t.joint_names} instead of {robot.joint_names}"),
        _flag("array lengths", shapes and widths, ""),
    ]
    if not all(check.ok for check in checks):
        return checks
    finite = all(np.isfinite(a).all() for a in (t.time, t.position, t.velocity, t.acceleration))
    checks.append(_flag("finite values", bool(finite), ""))
    steps = np.diff(t.time)
    checks.append(_flag("times strictly increasing", bool((steps > 0).all()), ""))
    if not all(check.ok for check in checks):
        return checks

    def worst_joint(
        name: str, excess: Float[np.ndarray, "samples joints"], limit: float, unit: str, first_sample: int = 0
    ) -> Check:
        sample, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
        where = f"{t.joint_names[joint]} at {t.time[first_sample + sample]:.3f} s"
        worst = float(excess[sample, joint])
        return Check(name, worst <= limit, worst, limit, unit, where)

    outside = np.maximum(robot.lower - t.position, t.position - robot.upper)
    velocity_limit = speed * robot.velocity_limit
    acceleration_limit = speed**2 * robot.acceleration_limit
    jerk_limit = speed**3 * robot.jerk_limit
    jerk = np.diff(t.acceleration, axis=0) / steps[:, None]
    # Between samples the mean of the stated derivative must account for the change of the value, up to what the rule
    # itself may be off where the jerk is as large as allowed: step^2 / 12 of it.
    velocity_gap = np.diff(t.position, axis=0) / steps[:, None] - 0.5 * (t.velocity[1:] + t.velocity[:-1])
    acceleration_gap = np.diff(t.velocity, axis=0) / steps[:, None] - 0.5 * (t.acceleration[1:] + t.acceleration[:-1])
    velocity_slack = CONTINUITY + jerk_limit * steps.max() ** 2 / 12.0
    acceleration_slack = jerk_limit * steps.max()
    checks += [
        worst_joint("start at the current posture", np.abs(t.position[:1] - start), START_TOLERANCE, "rad"),
        worst_joint("position limits", outside, 1e-9, "rad outside"),
        worst_joint("velocity limits", np.abs(t.velocity) / velocity_limit, 1.0, "of the limit"),
        worst_joint("acceleration limits", np.abs(t.acceleration) / acceleration_limit, 1.0, "of the limit"),
        worst_joint("jerk limits", np.abs(jerk) / jerk_limit, 1.0, "of the limit"),
        worst_joint("velocity continuity", np.abs(velocity_gap) / velocity_slack, 1.0, "of what rounding allows"),
        worst_joint("acceleration continuity", np.abs(acceleration_gap) / acceleration_slack, 1.0, "of a jerk step"),
        worst_joint("start at rest", np.abs(t.velocity[:1]), 1e-9, "rad/s"),
        worst_joint("end at rest", np.abs(t.velocity[-1:]), 1e-9, "rad/s", count - 1),
    ]
    return checks


def _flag(name: str, ok: bool, where: str) -> Check:
    return Check(name, ok, 0.0 if ok else 1.0, 0.0, "violations", where)


def failed(checks: Sequence[Check]) -> list[str]:
    """A sentence for each check that does not hold."""
    return [
        f"{check.name}: {check.worst:.4g} {check.unit} (limit {check.limit:.4g})"
        + (f", {check.where}" if check.where else "")
        for check in checks
        if not check.ok
    ]
