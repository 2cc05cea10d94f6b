"""Joint motion of the whole action: approach, grasp, manipulate, place and retreat of every hand on one clock.

The clock is the model's time axis, extended where the robot needs longer to approach than the person did.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.demonstration import Hand
from sbam.planning.approach import Way, way_to_grasp
from sbam.planning.follow import follow
from sbam.planning.grasps import Grasp
from sbam.planning.object_path import SMOOTHING, ObjectPath, object_path
from sbam.planning.task import MovedObject, Task
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

Array = NDArray[np.float64]

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
    interpolate_joints: bool = False,
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
        interpolate_joints: interpolate the joints linearly between keypoints, as the paper does, instead of what is
            wanted.

    Raises:
        UnreachableError: names hand, object, time and joint where the dense motion cannot be followed.
    """
    home = robot.clip(robot.home)
    before = task.T_agent_object
    after = {**before, **{moved.name: moved.put_down for moved in task.moved}}
    held, reaches, begins, ends = {}, {}, [], []
    for moved in task.moved:
        for hand in moved.hands:
            grasp = grasps[moved.role, hand]
            if interpolate_joints:
                ticks = _hold_clock(moved)
                hold = np.stack([np.interp(ticks, keypoint_times, column) for column in configurations.T], axis=-1)
            else:
                hold = _hold(task, robot, moved, grasp, keypoint_times, configurations, object_poses[moved.role])
            approach = way_to_grasp(robot, collision, before, moved.start, grasp, hold[0], STEP)
            retreat = way_to_grasp(robot, collision, after, moved.put_down, grasp, hold[-1], STEP)
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
    objects = tuple(object_path(task, moved, keypoint_times, object_poses[moved.role], clock) for moved in task.moved)
    return Motion(clock, path, objects, tuple(sorted(phases, key=lambda phase: (phase.hand, phase.start))))


def _hold_clock(moved: MovedObject) -> Array:
    """The clock's ticks from just before the lift to just after the place."""
    return STEP * np.arange(np.floor(moved.lift / STEP), np.ceil(moved.place / STEP) + 1.0, dtype=np.float64)


def _hold(
    task: Task,
    robot: Robot,
    moved: MovedObject,
    grasp: Grasp,
    keypoint_times: Array,
    configurations: Array,
    poses: RigidTransform,
) -> Array:
    """Configurations (M, n) of one arm that keep its grasp of the object on every tick of `_hold_clock`."""
    clock = _hold_clock(moved)
    # Smooth over a longer stretch than the hold, so that the path equals the one on the whole clock.
    margin = STEP * np.arange(1, 26)
    extended = np.concatenate([clock[0] - margin[::-1], clock, clock[-1] + margin])
    pose = object_path(task, moved, keypoint_times, poses, extended).pose[25:-25]
    tcp = pose * grasp.T_object_tcp
    clipped = np.clip(extended, moved.lift, moved.place)
    reference = np.stack([np.interp(clipped, keypoint_times, column) for column in configurations.T], axis=-1)
    reference = gaussian_filter1d(reference, SMOOTHING / STEP, axis=0, mode="nearest")[25:-25]
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
