"""Configurations that follow a dense path of one hand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.errors import UnreachableError
from sbam.robots.description import ArmName
from sbam.robots.inverse_kinematics import solve_poses
from sbam.robots.limits import LIMIT_MARGIN
from sbam.robots.robot import Robot

Array = NDArray[np.float64]

POSITION_TOLERANCE = 2e-4  # m: what a solved configuration may be off its target
ROTATION_TOLERANCE = np.deg2rad(0.05)  # rad


def follow(
    robot: Robot, hand: ArmName, tcp: RigidTransform, reference: Array, what: str, time: Array | None = None
) -> Array:
    """Bring one hand's tool centre point (TCP) through a sequence of poses.

    Each pose is solved for by itself, near a smooth reference: that keeps the result smooth and the redundancy settled
    without coupling the samples. Where the reference is too far off, solved neighbours are the start.

    Args:
        robot: robot standing in the agent frame.
        hand: the hand.
        tcp: N poses of its TCP, agent frame.
        reference: (N, n) configurations to stay near.
        what: what it does, for the error.
        time: (N,) s, for the error.

    Returns:
        (N, n) configurations.

    Raises:
        UnreachableError: names hand, time, error and the joints at their limits.
    """
    position, rotation = tcp.translation[:, None], tcp.rotation.as_matrix()[:, None]
    solution = solve_poses(robot, [hand], position, rotation, reference, pull=(1e-3,))
    q, missed = solution.configurations, ~solution.reached(POSITION_TOLERANCE, ROTATION_TOLERANCE)
    if not missed.any():
        return q
    for order in (range(1, len(q)), range(len(q) - 2, -1, -1)):
        for i in order:
            if missed[i]:
                near = q[i - order.step]
                again = solve_poses(robot, [hand], position[[i]], rotation[[i]], near, reference[[i]], pull=(1e-3,))
                if again.reached(POSITION_TOLERANCE, ROTATION_TOLERANCE)[0]:
                    q[i], missed[i] = again.configurations[0], False
    if missed.any():
        worst = int(np.argmax(np.where(missed, solution.position_error, -1.0)))
        room = np.minimum(q[worst] - robot.lower, robot.upper - q[worst])
        joints = np.flatnonzero((room < LIMIT_MARGIN + 1e-3) & robot.frame_joints(robot.arms[hand].tcp_frame))
        names = ", ".join(robot.joint_names[j] for j in joints)
        raise UnreachableError(
            f"{robot.name}'s {hand} hand cannot follow its path {what}"
            + (f" at {time[worst]:.2f} s" if time is not None else "")
            + f": {1e3 * solution.position_error[worst]:.1f} mm and "
            f"{np.rad2deg(solution.rotation_error[worst]):.1f} degrees off; "
            + (f"joints at their limits: {names}" if names else "the arm is too short")
        )
    return q
