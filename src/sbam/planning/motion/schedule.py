"""Every hand's way to its grasp and back home, past what stands there and past the others on their ways."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.planning.motion.allowed_contacts import touching_hands
from sbam.planning.motion.carrying import Holding
from sbam.planning.motion.object_path import ObjectPath
from sbam.planning.motion.timeline import STEP, Phase, Timeline
from sbam.planning.motion.transfer import Meets, Surroundings, Way, way_to_grasp
from sbam.planning.task import MovedObject, RoleHand, Task
from sbam.robots import ObjectHand, Robot
from sbam.robots.collision import CollisionModel


def with_ways(
    task: Task, robot: Robot, collision: CollisionModel, holding: Holding, clearance: float = 0.0
) -> tuple[Timeline, float, RoleHand | None]:
    """Bring every hand to its grasp, the first to grasp first, and back home, the last to release first.

    Each keeps clear of the others as they are known by then: those whose way is not planned yet are at home.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        holding: every hand from grasp to release.
        clearance: distance that must be kept, m.

    Returns:
        The whole motion, the least distance beyond ``clearance`` that was found on the ways, m, and whose way it is.

    Raises:
        UnreachableError: if a grasp cannot be approached in a straight line.
    """
    timeline, surplus = holding.timeline, np.inf
    narrowest: RoleHand | None = None
    grasped = {key: timeline.phase(key.hand, key.role, "grasp").start for _, key in task.holds}
    released = {key: timeline.phase(key.hand, key.role, "place").end for _, key in task.holds}
    first_to_grasp = sorted(task.holds, key=lambda hold: grasped[hold[1]])
    last_to_release = sorted(task.holds, key=lambda hold: -released[hold[1]])
    for arriving, order in ((True, first_to_grasp), (False, last_to_release)):
        for moved, key in order:
            hand = key.hand
            meets = _meeting(task, robot, holding.paths, timeline, moved, hand, arriving)
            at_grasp = holding.configurations[key][0 if arriving else -1]
            way = way_to_grasp(robot, collision, holding.grasps[key], at_grasp, meets, clearance)
            timeline = _passed(robot, timeline, moved, hand, way, arriving)
            if way.surplus < surplus:
                surplus, narrowest = way.surplus, key
    return timeline, surplus, narrowest


def _at_object(timeline: Timeline, role: str, hand: Hand, arriving: bool) -> int:
    """The sample at which a hand is at its grasp, or has let go."""
    if arriving:
        return timeline.index(timeline.phase(hand, role, "grasp").start)
    return timeline.index(timeline.phase(hand, role, "place").end)


def _passed(robot: Robot, timeline: Timeline, moved: MovedObject, hand: Hand, way: Way, arriving: bool) -> Timeline:
    """The timeline with one arm's way, for which all else stands still as long as it needs that."""
    role = moved.role
    if way.wait:
        timeline = timeline.with_pause(_at_object(timeline, role, hand, arriving), way.wait, arriving, hand)
        way_there = "on its way to" if arriving else "on its way back from"
        note = f"all else waits {STEP * way.wait:.1f} s for the {hand} hand {way_there} {moved.name}"
        timeline = replace(timeline, notes=(*timeline.notes, note))
    values = way.joined if arriving else way.joined[::-1]
    at, length = _at_object(timeline, role, hand, arriving), len(values) - 1
    begin = timeline.first + (at - length if arriving else at)
    timeline = timeline.covering(begin - timeline.first, begin - timeline.first + length)
    joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
    phase = Phase(hand, "approach" if arriving else "retreat", STEP * begin, STEP * (begin + length), role)
    return timeline.with_way(begin - timeline.first, joints, values, phase)


def _meeting(
    task: Task,
    robot: Robot,
    paths: Mapping[str, ObjectPath],
    timeline: Timeline,
    moved: MovedObject,
    hand: Hand,
    arriving: bool,
) -> Meets:
    """What one hand meets on its way to or from an object."""
    home = robot.clip(robot.home)
    at_object = _at_object(timeline, moved.role, hand, arriving)
    known = {(phase.role, phase.hand, phase.name) for phase in timeline.phases}

    def meets(ticks: Float[np.ndarray, " samples"], on_line: Bool[np.ndarray, " samples"]) -> Surroundings:
        index = (at_object + (-ticks if arriving else ticks)).round().astype(int)
        clock = STEP * (timeline.first + index)
        rows = index.clip(0, len(timeline.model_time) - 1)
        beyond = STEP * (index - rows)
        configurations = timeline.configurations[rows].copy()
        for other in task.moved:
            for side in other.hands:
                away = np.zeros(len(rows), dtype=bool)
                if (other.role, side, "approach") not in known:
                    away |= clock < timeline.phase(side, other.role, "grasp").start
                if (other.role, side, "retreat") not in known:
                    away |= clock > timeline.phase(side, other.role, "place").end
                joints = robot.frame_joints(robot.arms[side].tcp_frame)
                configurations = np.where(away[:, None] & joints, home, configurations)
        poses = dict(task.T_agent_object)
        for other in task.moved:
            poses[other.name] = poses_at(paths[other.role], timeline.model_time[rows] + beyond)
        held = {**touching_hands(task, timeline.phases, clock), ObjectHand(moved.name, hand): on_line}
        return Surroundings(configurations, poses, held)

    return meets


def poses_at(path: ObjectPath, model_time: Float[np.ndarray, " ticks"]) -> RigidTransform:
    """Poses at the ticks nearest to model times; beyond its ends an object rests."""
    index = ((model_time - path.model_time[0]) / STEP).round().astype(int)
    return path.pose[index.clip(0, len(path.model_time) - 1)]
