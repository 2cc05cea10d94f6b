"""The way of one arm from home to its grasp; reversed, the way back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import RigidTransform

from sbam.planning.follow import follow
from sbam.planning.grasps import Grasp
from sbam.planning.inverse_kinematics import solve_poses
from sbam.planning.object_path import ease
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

Array = NDArray[np.float64]

STANDOFF = 0.08  # m from which a grasp is approached in a straight line, and to which the hand retreats
LINE_TIME = 0.8  # s of the straight part
TRANSFER_SPEED = 1.0  # rad/s: mean speed of the fastest joint between home and the standoff
COMFORTABLE = 0.02  # m of clearance with which the search for a transfer ends
SAMPLES = 25  # configurations of a transfer whose clearance is measured
# Way points of the hand tried between home and the standoff: (up, back along the approach), m; None goes straight.
DETOURS = (None, (0.10, 0.0), (0.0, 0.10), (0.15, 0.10), (0.25, 0.0))


@dataclass(frozen=True)
class Way:
    """Configurations from home to the grasp at equal steps of the clock.

    Attributes:
        transfer: (T, n) from home to the standoff.
        line: (L, n) from the standoff straight to the grasp.
    """

    transfer: Array
    line: Array

    @property
    def joined(self) -> Array:
        """(T + L - 1, n) the whole way."""
        return np.concatenate([self.transfer, self.line[1:]])


def way_to_grasp(
    robot: Robot,
    collision: CollisionModel,
    T_agent_object: Mapping[str, RigidTransform],
    pose: RigidTransform,
    grasp: Grasp,
    at_grasp: Array,
    step: float,
) -> Way:
    """Find a way from home to a grasp that keeps clear of what stands around.

    Args:
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        T_agent_object: object name -> pose while the arm is on its way.
        pose: pose of the object that is grasped.
        grasp: the grasp.
        at_grasp: (n,) configuration that holds it.
        step: time between configurations, s.

    Raises:
        UnreachableError: if the straight line to the grasp cannot be followed.
    """
    T_agent_tcp = pose * grasp.T_object_tcp
    direction = T_agent_tcp.rotation.apply(np.array(robot.arms[grasp.hand].hand.approach))
    count = round(LINE_TIME / step) + 1
    distance = STANDOFF * (1.0 - ease(np.linspace(0.0, 1.0, count)))
    line_poses = RigidTransform.from_components(
        T_agent_tcp.translation - distance[:, None] * direction, T_agent_tcp.rotation
    )
    line = follow(robot, grasp.hand, line_poses, np.tile(at_grasp, (count, 1)), f"to its grasp of {grasp.role!r}")
    line += at_grasp - line[-1]  # the last one is the grasp's own, down to the solver's tolerance
    joints = robot.frame_joints(robot.arms[grasp.hand].tcp_frame)
    home = np.where(joints, robot.clip(robot.home), line[0])
    best, best_clearance = None, -np.inf
    for detour in DETOURS:
        curve = _curve(robot, grasp, line_poses[0], direction, home, line[0], detour)
        if curve is None:
            continue
        sampled = np.where(joints, curve(np.linspace(0.0, 1.0, SAMPLES)), robot.home)
        clearance = float(collision.clearances(sampled, T_agent_object, distance_max=2 * COMFORTABLE).distance.min())
        if clearance > best_clearance:
            best, best_clearance = curve, clearance
        if clearance >= COMFORTABLE:
            break
    assert best is not None  # going straight is always possible
    fine = best(np.linspace(0.0, 1.0, 200))
    travel = float(np.abs(np.diff(fine, axis=0)).sum(axis=0).max())
    steps = max(int(np.ceil(max(travel / TRANSFER_SPEED, 0.5) / step)), 1)
    return Way(best(ease(np.linspace(0.0, 1.0, steps + 1))), line)


def _curve(
    robot: Robot,
    grasp: Grasp,
    standoff: RigidTransform,
    direction: Array,
    home: Array,
    at_standoff: Array,
    detour: tuple[float, float] | None,
) -> BSpline | None:
    """Smooth joint path over [0, 1] from home to the standoff through a way point, or None if that is out of reach."""
    if detour is None:
        return make_interp_spline([0.0, 1.0], np.stack([home, at_standoff]), k=1)
    up, back = detour
    point = standoff.translation + np.array([0.0, 0.0, up]) - back * direction
    solution = solve_poses(
        robot,
        [grasp.hand],
        point[None, None],
        standoff.rotation.as_matrix()[None, None],
        at_standoff,
        pull=(1e-2, 1e-3),
    )
    if not solution.reached()[0]:
        return None
    points = np.stack([home, solution.configurations[0], at_standoff])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    middle = np.clip(lengths[0] / lengths.sum(), 0.1, 0.9)
    curve = make_interp_spline([0.0, middle, 1.0], points, k=2)
    inside = curve(np.linspace(0.0, 1.0, SAMPLES))
    return curve if (inside >= robot.lower).all() and (inside <= robot.upper).all() else None
