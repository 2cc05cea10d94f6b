"""What comes too near on the dense motion, as a term for the keypoints: the swept motion is cleared, not only them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int

from sbam.errors import UnreachableError
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.result import Solution, describe
from sbam.planning.keypoints.solvers.whole_trajectory import WARM, descend
from sbam.planning.keypoints.terms import Clearance
from sbam.planning.motion.allowed_contacts import touching_hands
from sbam.planning.motion.carrying import Holding
from sbam.planning.motion.motion import Motion, while_holding
from sbam.planning.motion.timeline import STEP
from sbam.planning.settings import PlanSettings
from sbam.planning.task import Task
from sbam.robots import Robot, point_jacobian
from sbam.robots.collision import CollisionModel

ROUNDS = 6  # linearisations of the distances
RADIUS = 0.25  # rad (or m) that a joint may move per linearisation
TOO_DEEP = -0.08  # m: arms that cross each other need other grasps, not other keypoints
EVERY = 3  # ticks of the dense motion between two that are looked at
LOOK_AHEAD = 0.05  # m beyond the margin from which pairs are kept in view, so that steps do not run into new ones
EFFECT = 0.02  # m/rad: pairs whose distance the joints change by less (a palm and what it holds) are left out


def keep_clear(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    problem: Problem,
    solution: Solution,
    holding: Holding,
    hold: Callable[[Solution], Holding],
    settings: PlanSettings,
) -> tuple[Solution, Holding, float]:
    """Optimise the keypoints again, with what came too near as a further term, until what holds objects keeps clear.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        problem: the problem without clearances.
        solution: its solution.
        holding: the dense motion made of it, from lift to place.
        hold: makes that of a solution; may raise `UnreachableError`.
        settings: says which distance is wanted.

    Returns:
        Solution and motion with the largest least distance that was found, and that, m; the first ones if they keep
        clear.
    """
    wanted = settings.clearance + settings.margin

    def near(solution: Solution, holding: Holding) -> tuple[Clearance, float]:
        motion = while_holding(task, robot, holding)
        term = clearance_term(task, robot, collision, motion, holding.keypoint_times, solution.configurations, wanted)
        return term, float(term.distance.min(initial=np.inf))

    term, least = near(solution, holding)
    radius = RADIUS
    for _ in range(ROUNDS):
        if not TOO_DEEP <= least < settings.clearance:
            break
        begin, q = time.perf_counter(), solution.configurations
        nearby = replace(problem, terms=(*problem.terms, term), center=q, radius=radius)
        state, used = descend(nearby, q, WARM)
        seconds = solution.seconds + time.perf_counter() - begin
        moved = describe(problem, state, "default", solution.starts, solution.iterations + used, seconds)
        radius /= 2.0
        try:
            moved_holding = hold(moved)
        except UnreachableError:
            continue
        moved_term, moved_least = near(moved, moved_holding)
        if moved_least > least:
            solution, holding, term, least, radius = moved, moved_holding, moved_term, moved_least, 2.0 * radius
    return solution, holding, least


def clearance_term(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    motion: Motion,
    times: Float[np.ndarray, " keypoints"],
    configurations: Float[np.ndarray, "keypoints joints"],
    margin: float,
) -> Clearance:
    """Find what is near while objects are carried, and how the keypoints change its distance.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        motion: the dense motion that was made of the keypoints.
        times: keypoints on the model's time axis, s.
        configurations: at the keypoints.
        margin: distance wanted, m.

    Returns:
        The term; its distances are those of the dense motion.
    """
    carrying = [phase for phase in motion.phases if phase.name == "manipulate"]
    begin, end = min(p.start for p in carrying), max(p.end for p in carrying)
    ticks = np.flatnonzero((motion.clock >= begin) & (motion.clock <= end))[::EVERY]
    clock, q = motion.clock[ticks], motion.configurations[ticks]
    poses = {**task.T_agent_object, **{name: path[ticks] for name, path in motion.T_agent_object.items()}}
    near = collision.near(q, poses, touching_hands(task, motion.phases, clock), margin + LOOK_AHEAD)
    # Only the joints of arms that carry something follow the keypoints.
    steered = np.zeros(q.shape, dtype=bool)
    for phase in carrying:
        during = (clock >= phase.start - STEP) & (clock <= phase.end + STEP)
        steered |= during[:, None] & robot.frame_joints(robot.arms[phase.hand].tcp_frame)
    relative = _point_jacobian(task, robot, near.point_first, near.first, q[near.sample], steered[near.sample])
    relative -= _point_jacobian(task, robot, near.point_second, near.second, q[near.sample], steered[near.sample])
    gradient = np.matvec(np.swapaxes(relative, -1, -2), near.normal)
    counts = np.linalg.norm(gradient, axis=1) > EFFECT
    moment = motion.model_time[ticks][near.sample][counts]
    interval = np.clip(np.searchsorted(times, moment), 1, len(times) - 1)
    fraction = np.clip((moment - times[interval - 1]) / (times[interval] - times[interval - 1]), 0.0, 1.0)
    return _by_interval(configurations, margin, interval, near.distance[counts], fraction, gradient[counts])


def _point_jacobian(
    task: Task,
    robot: Robot,
    points: Float[np.ndarray, "points 3"],
    owners: tuple[str, ...],
    q: Float[np.ndarray, "points joints"],
    steered: Bool[np.ndarray, "points joints"],
) -> Float[np.ndarray, "points 3 joints"]:
    """Jacobians of points on a robot's bodies or on objects, which move while they are carried."""
    carrier = {moved.name: robot.arms[moved.hands[0]].tcp_frame for moved in task.moved}
    still = np.zeros(q.shape[1], dtype=bool)
    frames = [carrier.get(owner, owner) for owner in owners]
    joints = {name: robot.frame_joints(name) if name in robot.frame_names else still for name in set(frames)}
    mask = np.array([joints[name] for name in frames], dtype=bool).reshape(q.shape)
    return point_jacobian(robot.kinematics(q, ()), points, mask & steered)


def _by_interval(
    configurations: Float[np.ndarray, "keypoints joints"],
    margin: float,
    interval: Int[np.ndarray, " pairs"],
    distance: Float[np.ndarray, " pairs"],
    fraction: Float[np.ndarray, " pairs"],
    gradient: Float[np.ndarray, "pairs joints"],
) -> Clearance:
    """Sort near pairs into the intervals between keypoints."""
    count, joints = configurations.shape
    order = np.argsort(interval, kind="stable")
    first = np.searchsorted(interval[order], interval[order])
    place = np.arange(len(order)) - first  # number within the interval
    groups = int(place.max(initial=-1)) + 1
    cell = interval[order], place
    filled = Clearance(
        configurations=configurations,
        distance=np.full((count, groups), np.inf),
        fraction=np.zeros((count, groups)),
        gradient=np.zeros((count, groups, joints)),
        margin=margin,
    )
    filled.distance[cell], filled.fraction[cell], filled.gradient[cell] = (
        distance[order],
        fraction[order],
        gradient[order],
    )
    return filled
