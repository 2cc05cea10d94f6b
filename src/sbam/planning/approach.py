"""The way of one arm from home to its grasp; reversed, the way back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import UnreachableError
from sbam.planning.follow import follow
from sbam.planning.grasps import Grasp
from sbam.planning.inverse_kinematics import solve_poses
from sbam.planning.object_path import ease
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

Array = NDArray[np.float64]

STANDOFF = 0.08  # m from which a grasp is approached in a straight line, and to which the hand retreats
STANDOFFS = (STANDOFF, 0.05, 0.03)  # m: shorter ones where that is out of reach
SAME_POSTURE = 5e-3  # rad: a line that ends farther from the grasp's posture than this ends in another one
LINE_TIME = 0.8  # s of the straight part
TRANSFER_SPEED = 1.0  # rad/s: mean speed of the fastest joint between home and the standoff
COMFORTABLE = 0.02  # m of clearance with which the search for a transfer ends
SAMPLES = 25  # configurations of a transfer whose clearance is measured
# Way points of the hand tried between home and the standoff: (up, back along the approach), m.
DETOURS = ((0.10, 0.0), (0.0, 0.10), (0.15, 0.10), (0.25, 0.0))
SPREADS = (0.3, 0.6, 0.9)  # rad: how far random way points are from the middle of the way, where detours do not help
RANDOM = 12  # random way points of each spread


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
    grasp: Grasp,
    at_grasp: Array,
    step: float,
) -> Way:
    """Find a way from home to a grasp that keeps clear of what stands around.

    Tried in turn: straight in the joints, over way points of the hand, over random way points near the middle.

    Args:
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        T_agent_object: object name -> pose while the arm is on its way.
        grasp: the grasp.
        at_grasp: (n,) configuration that holds it.
        step: time between configurations, s.

    Raises:
        UnreachableError: if the straight line to the grasp cannot be followed.
    """
    line, standoff, direction = _straight_line(robot, grasp, at_grasp, step)
    joints = robot.frame_joints(robot.arms[grasp.hand].tcp_frame)
    home = np.where(joints, robot.clip(robot.home), line[0])

    def clearance(configurations: Array) -> Array:
        sampled = np.where(joints, configurations, robot.home)
        count = len(sampled)
        distance = collision.clearances(
            sampled.reshape(-1, sampled.shape[-1]), T_agent_object, distance_max=2 * COMFORTABLE
        ).distance
        return distance.reshape(count, -1).min(axis=1)

    # More than at its ends no way can have.
    enough = min(COMFORTABLE, float(clearance(np.stack([home, line[0]])[:, None]).min()) - 1e-4)
    best, best_clearance = None, -np.inf
    for curves in _curves(robot, grasp, standoff, direction, home, line[0]):
        found = clearance(np.array([curve(np.linspace(0.0, 1.0, SAMPLES)) for curve in curves]))
        # Of those that keep clear, the shortest.
        travels = np.array([_travel(curve) for curve in curves])
        choice = int(np.lexsort((travels, -np.minimum(found, enough)))[0])
        if found[choice] > best_clearance:
            best, best_clearance = curves[choice], float(found[choice])
        if best_clearance >= enough:
            break
    assert best is not None  # going straight is always possible
    steps = max(int(np.ceil(max(_travel(best) / TRANSFER_SPEED, 0.5) / step)), 1)
    return Way(best(ease(np.linspace(0.0, 1.0, steps + 1))), line)


def _straight_line(robot: Robot, grasp: Grasp, at_grasp: Array, step: float) -> tuple[Array, RigidTransform, Array]:
    """Configurations from the standoff to the grasp, the TCP's pose at the standoff and the direction of approach."""
    frame = robot.kinematics(at_grasp[None], [robot.arms[grasp.hand].tcp_frame])
    T_agent_tcp = RigidTransform.from_components(frame.position[0, 0], Rotation.from_matrix(frame.rotation[0, 0]))
    direction = T_agent_tcp.rotation.apply(np.array(robot.arms[grasp.hand].hand.approach))
    count = round(LINE_TIME / step) + 1
    trouble = None
    for standoff in STANDOFFS:
        distance = standoff * (1.0 - ease(np.linspace(0.0, 1.0, count)))
        poses = RigidTransform.from_components(
            T_agent_tcp.translation - distance[:, None] * direction, T_agent_tcp.rotation
        )
        try:
            line = follow(robot, grasp.hand, poses, np.tile(at_grasp, (count, 1)), f"to its grasp of {grasp.role!r}")
        except UnreachableError as error:
            trouble = trouble or error
            continue
        gap = at_grasp - line[-1]
        if np.abs(gap).max() < SAME_POSTURE:
            return line + gap, poses[0], direction
    raise trouble or UnreachableError(
        f"{robot.name}'s {grasp.hand} hand cannot reach its grasp of {grasp.role!r} in a straight line without another "
        "posture of the arm"
    )


def _travel(curve: BSpline) -> float:
    """How far the joint that travels most travels, rad or m."""
    return float(np.abs(np.diff(curve(np.linspace(0.0, 1.0, 200)), axis=0)).sum(axis=0).max())


def _curves(
    robot: Robot, grasp: Grasp, standoff: RigidTransform, direction: Array, home: Array, at_standoff: Array
) -> Iterator[list[BSpline]]:
    """Smooth joint paths over [0, 1] from home to the standoff, in the order in which they are to be tried."""
    yield [make_interp_spline([0.0, 1.0], np.stack([home, at_standoff]), k=1)]
    for detour in DETOURS:
        curve = _detour(robot, grasp, standoff, direction, home, at_standoff, detour)
        if curve is not None:
            yield [curve]
    generator = np.random.default_rng(0)
    joints = robot.frame_joints(robot.arms[grasp.hand].tcp_frame)
    for spread in SPREADS:
        middle = 0.5 * (home + at_standoff)
        points = robot.clip(middle + spread * joints * generator.standard_normal((RANDOM, len(home))))
        curves = [_through(robot, home, point, at_standoff) for point in points]
        if found := [curve for curve in curves if curve is not None]:
            yield found


def _detour(
    robot: Robot,
    grasp: Grasp,
    standoff: RigidTransform,
    direction: Array,
    home: Array,
    at_standoff: Array,
    detour: tuple[float, float],
) -> BSpline | None:
    """Path through a way point of the hand, or None if that is out of reach."""
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
    return _through(robot, home, solution.configurations[0], at_standoff) if solution.reached()[0] else None


def _through(robot: Robot, home: Array, way_point: Array, at_standoff: Array) -> BSpline | None:
    """Path through a configuration, or None if it leaves the joint limits."""
    points = np.stack([home, way_point, at_standoff])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    middle = np.clip(lengths[0] / lengths.sum(), 0.1, 0.9)
    curve = make_interp_spline([0.0, middle, 1.0], points, k=2)
    inside = curve(np.linspace(0.0, 1.0, SAMPLES))
    return curve if (inside >= robot.lower).all() and (inside <= robot.upper).all() else None
