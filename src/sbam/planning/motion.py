"""Joint motion of the whole action: approach, grasp, manipulate, place and retreat of every hand on one clock.

The clock is the model's time axis, extended where the robot needs longer to approach than the person did.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import pchip_interpolate
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.planning.approach import LINE_TIME, Way, way_to_grasp
from sbam.planning.demonstrated_shape import DemonstratedShape
from sbam.planning.follow import follow
from sbam.planning.grasps import Grasp
from sbam.planning.object_path import EASING, SMOOTHING, ObjectPath, ease, object_path
from sbam.planning.task import MovedObject, Task
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

Array = NDArray[np.float64]

MARGIN = 25  # ticks
STEP = 0.02  # s between the configurations that are solved for
CLOSING_TIME = 0.3  # s in which the fingers close before the lift and open after the place


@dataclass(frozen=True)
class Phase:
    """A named stretch of one hand's motion on the clock, s."""

    hand: Hand
    name: str
    start: float
    end: float
    role: str = ""


@dataclass(frozen=True)
class Motion:
    """The dense motion before it is timed.

    Attributes:
        clock: (N,) uniform, model's time axis, s; starts before 0 where approaches take longer than the person's.
        configurations: (N, n) rad or m.
        objects: dense path of each moved object, on the clock.
        phases: what each hand does when.
    """

    clock: Array
    configurations: Array
    objects: tuple[ObjectPath, ...]
    phases: tuple[Phase, ...]


def make_motion(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    grasps: Mapping[tuple[str, Hand], Grasp],
    keypoint_times: Array,
    configurations: Array,
    object_poses: Mapping[str, RigidTransform],
    joints_between: Literal["lines", "splines"] | None = None,
    shapes: Mapping[str, DemonstratedShape] | None = None,
) -> Motion:
    """Make the dense motion from the optimised keypoints.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        grasps: (role, hand) -> grasp.
        keypoint_times: (K,) s.
        configurations: (K, n) optimised configurations, which settle the redundancy.
        object_poses: role -> K poses at the keypoints, agent frame.
        joints_between: interpolate the joints between keypoints instead of what is wanted: by straight lines, as the
            paper does, or by monotone cubic splines.
        shapes: role -> how its object moved in the demonstrations, to be kept between keypoints.

    Raises:
        UnreachableError: names hand, object, time and joint where the dense motion cannot be followed.
    """
    shapes = shapes or {}
    configurations = _with_steady_torso(task, robot, keypoint_times, configurations)
    home = robot.clip(robot.home)
    before = task.T_agent_object
    after = {**before, **{moved.name: moved.put_down for moved in task.moved}}
    held, reaches, begins, ends = {}, {}, [], []
    for moved in task.moved:
        for hand in moved.hands:
            grasp = grasps[moved.role, hand]
            if joints_between == "splines":
                hold = pchip_interpolate(keypoint_times, configurations, _hold_clock(moved))
            elif joints_between == "lines":
                ticks = _hold_clock(moved)
                hold = np.stack([np.interp(ticks, keypoint_times, column) for column in configurations.T], axis=-1)
            else:
                pose = _held_pose(task, moved, keypoint_times, object_poses[moved.role], shapes.get(moved.role))
                hold = _hold(robot, moved, grasp, keypoint_times, configurations, pose)
            approach = way_to_grasp(robot, collision, before, grasp, hold[0], STEP)
            retreat = way_to_grasp(robot, collision, after, grasp, hold[-1], STEP)
            held[moved.role, hand], reaches[moved.role, hand] = hold, (approach, retreat)
            begins.append(moved.lift - CLOSING_TIME - STEP * (len(approach.joined) - 1))
            ends.append(moved.place + CLOSING_TIME + STEP * (len(retreat.joined) - 1))
    first = int(np.floor(min([*begins, keypoint_times[0]]) / STEP)) - 2
    last = int(np.ceil(max([*ends, keypoint_times[-1]]) / STEP)) + 2
    clock: Array = STEP * np.arange(first, last + 1, dtype=np.float64)
    path = np.tile(home, (len(clock), 1))
    phases: list[Phase] = []
    for moved in task.moved:
        for hand in moved.hands:
            joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
            phases += _place_on_clock(
                clock, path, joints, moved, hand, held[moved.role, hand], *reaches[moved.role, hand]
            )
    torso = _references(keypoint_times, configurations[:, robot.torso_indices], clock)
    _move_torso(robot, clock, path, phases, home, torso)
    objects = tuple(
        object_path(task, moved, keypoint_times, object_poses[moved.role], clock, shapes.get(moved.role))
        for moved in task.moved
    )
    return Motion(clock, path, objects, tuple(sorted(phases, key=lambda phase: (phase.hand, phase.start))))


def _with_steady_torso(task: Task, robot: Robot, keypoint_times: Array, configurations: Array) -> Array:
    """The keypoints with a torso that moves only while all objects are held: what one hand does to it both feel."""
    if len(robot.torso_indices) == 0 or not task.moved:
        return configurations
    lift, place = max(moved.lift for moved in task.moved), min(moved.place for moved in task.moved)
    inside = keypoint_times[(keypoint_times > lift + EASING) & (keypoint_times < place - EASING)]
    steady = np.clip(keypoint_times, inside[0], inside[-1]) if len(inside) else np.full(len(keypoint_times), lift)
    result = configurations.copy()
    for joint in robot.torso_indices:
        result[:, joint] = np.interp(steady, keypoint_times, configurations[:, joint])
    return result


def _references(keypoint_times: Array, values: Array, time: Array) -> Array:
    """Keypoint values (K, m) between keypoints, at even times (N,) and without corners, (N, m)."""
    between = np.empty((len(time), values.shape[1]))
    for index, column in enumerate(values.T):
        between[:, index] = np.interp(time, keypoint_times, column)
    return gaussian_filter1d(between, SMOOTHING / STEP, axis=0, mode="nearest")


def _move_torso(robot: Robot, clock: Array, path: Array, phases: Sequence[Phase], home: Array, torso: Array) -> None:
    """Bring the torso from home to where it is needed before any hand comes near, and back after all have left."""
    if len(robot.torso_indices) == 0 or not phases:
        return
    first, last = min(phase.start for phase in phases), max(phase.end for phase in phases)
    near = min(phase.end for phase in phases if phase.name == "approach") - LINE_TIME
    away = max(phase.start for phase in phases if phase.name == "retreat") + LINE_TIME
    there = ease((clock - first) / (near - first)) * ease((last - clock) / (last - away))
    resting = home[robot.torso_indices]
    path[:, robot.torso_indices] = resting + there[:, None] * (torso - resting)


def _hold_clock(moved: MovedObject) -> Array:
    """The clock's ticks from just before the lift to just after the place."""
    return STEP * np.arange(np.floor(moved.lift / STEP), np.ceil(moved.place / STEP) + 1.0, dtype=np.float64)


def _longer(clock: Array) -> Array:
    """A hold's clock with `MARGIN` more ticks at both ends.

    What is smoothed over them equals, on the hold, what is smoothed over the whole clock.
    """
    more = STEP * np.arange(1, MARGIN + 1)
    return np.concatenate([clock[0] - more[::-1], clock, clock[-1] + more])


def _held_pose(
    task: Task, moved: MovedObject, keypoint_times: Array, poses: RigidTransform, shape: DemonstratedShape | None
) -> RigidTransform:
    """M poses of an object on every tick of `_hold_clock`."""
    time = _longer(_hold_clock(moved))
    return object_path(task, moved, keypoint_times, poses, time, shape).pose[MARGIN:-MARGIN]


def _hold(
    robot: Robot,
    moved: MovedObject,
    grasp: Grasp,
    keypoint_times: Array,
    configurations: Array,
    pose: RigidTransform,
) -> Array:
    """Configurations (M, n) of one arm that keep its grasp of the object on every tick of `_hold_clock`."""
    clock = _hold_clock(moved)
    tcp = pose * grasp.T_object_tcp
    clipped = np.clip(_longer(clock), moved.lift, moved.place)
    reference = _references(keypoint_times, configurations, clipped)[MARGIN:-MARGIN]
    torso = _references(keypoint_times, configurations[:, robot.torso_indices], _longer(clock))
    reference[:, robot.torso_indices] = torso[MARGIN:-MARGIN]
    solved = follow(robot, grasp.hand, tcp, reference, f"holding {moved.name!r}", clock)
    return solved


def _place_on_clock(
    clock: Array,
    path: Array,
    joints: NDArray[np.int_],
    moved: MovedObject,
    hand: Hand,
    hold: Array,
    approach: Way,
    retreat: Way,
) -> Sequence[Phase]:
    """Write one arm's columns of the path and say which phase is when."""
    ticks = _hold_clock(moved)
    offset = round((ticks[0] - clock[0]) / STEP)
    closing = round(CLOSING_TIME / STEP)
    grasp_tick = offset - closing
    start_tick = grasp_tick - (len(approach.joined) - 1)
    path[start_tick : grasp_tick + 1, joints] = approach.joined[:, joints]
    path[grasp_tick:offset, joints] = hold[0, joints]
    path[offset : offset + len(hold), joints] = hold[:, joints]
    place_tick = offset + len(hold) - 1
    release_tick = place_tick + closing
    path[place_tick : release_tick + 1, joints] = hold[-1, joints]
    back = retreat.joined[::-1]
    path[release_tick : release_tick + len(back), joints] = back[:, joints]
    time = clock[0] + STEP * np.array(
        [start_tick, grasp_tick, offset, place_tick, release_tick, release_tick + len(back) - 1]
    )
    names = ("approach", "grasp", "manipulate", "place", "retreat")
    return [Phase(hand, name, time[i], time[i + 1], moved.role) for i, name in enumerate(names)]
