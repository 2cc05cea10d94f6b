"""Joint motion of the whole action: approach, grasp, manipulate, place and retreat of every hand on one clock.

The clock is the model's time axis, extended where the robot needs longer to approach than the person did, and where one
arm has to wait until the other one has passed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline, pchip_interpolate
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import RigidTransform, Slerp

from sbam.demonstrations.demonstration import Hand
from sbam.planning.approach import LINE_TIME
from sbam.planning.demonstrated_shape import DemonstratedShape
from sbam.planning.follow import follow
from sbam.planning.grasps import Grasp
from sbam.planning.object_path import EASING, SMOOTHING, ObjectPath, ease, object_path
from sbam.planning.task import MovedObject, Task
from sbam.planning.timeline import STEP, Phase, Timeline
from sbam.planning.ways import poses_at, with_ways
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel

Array = NDArray[np.float64]

MARGIN = 25  # ticks
CLOSING_TIME = 0.3  # s in which the fingers close before the lift and open after the place


@dataclass(frozen=True)
class Motion:
    """The dense motion before it is timed.

    Attributes:
        clock: (N,) uniform, s; starts before 0 where approaches take longer than the person's.
        model_time: (N,) s on the model's axis at these ticks: the clock, as long as nothing has waited.
        configurations: (N, n) rad or m.
        objects: dense path of each moved object, on the clock.
        phases: what each hand does when.
    """

    clock: Array
    model_time: Array
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
    paths = {
        moved.role: object_path(
            task,
            moved,
            keypoint_times,
            object_poses[moved.role],
            _longer(_hold_clock(moved)),
            shapes.get(moved.role),
        )
        for moved in task.moved
    }
    holds: dict[tuple[str, Hand], Array] = {}
    for moved in task.moved:
        ticks = _hold_clock(moved)
        for hand in moved.hands:
            hold: Array
            if joints_between == "splines":
                hold = np.asarray(pchip_interpolate(keypoint_times, configurations, ticks))
            elif joints_between == "lines":
                hold = np.stack([np.interp(ticks, keypoint_times, column) for column in configurations.T], axis=-1)
            else:
                pose = paths[moved.role].pose[MARGIN:-MARGIN]
                hold = _hold(robot, moved, grasps[moved.role, hand], keypoint_times, configurations, pose)
            holds[moved.role, hand] = hold
    timeline = with_ways(task, robot, collision, grasps, paths, holds, _holding(task, robot, holds))
    early = min(0, int(np.floor((keypoint_times[0] - timeline.model_time[0]) / STEP)))
    late = max(0, int(np.ceil((keypoint_times[-1] - timeline.model_time[-1]) / STEP)))
    timeline = timeline.covering(early - 2, len(timeline.model_time) + late + 1)
    path = timeline.configurations.copy()
    torso = _at(timeline.model_time, keypoint_times, configurations[:, robot.torso_indices])
    _move_torso(robot, timeline.clock, path, timeline.phases, home, torso)
    objects = tuple(_on_clock(paths[moved.role], timeline) for moved in task.moved)
    phases = tuple(sorted(timeline.phases, key=lambda phase: (phase.hand, phase.start)))
    return Motion(timeline.clock, timeline.model_time, path, objects, phases)


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


def _at(model_time: Array, keypoint_times: Array, values: Array) -> Array:
    """Keypoint values (K, m) at increasing model times (N,), without corners, (N, m)."""
    if values.shape[1] == 0:
        return np.empty((len(model_time), 0))
    first, last = np.floor(model_time[0] / STEP), np.ceil(model_time[-1] / STEP)
    even = STEP * np.arange(first, last + 1.0)
    return make_interp_spline(even, _references(keypoint_times, values, even), k=3)(model_time)


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


def _holding(task: Task, robot: Robot, holds: Mapping[tuple[str, Hand], Array]) -> Timeline:
    """Every hand from grasp to release; before and after it stays there."""
    closing = round(CLOSING_TIME / STEP)
    lifts = {moved.role: round(_hold_clock(moved)[0] / STEP) for moved in task.moved}
    places = {moved.role: round(_hold_clock(moved)[-1] / STEP) for moved in task.moved}
    first, last = min(lifts.values()) - closing, max(places.values()) + closing
    ticks = np.arange(first, last + 1)
    path = np.tile(robot.clip(robot.home), (len(ticks), 1))
    phases: list[Phase] = []
    for (role, hand), hold in holds.items():
        joints = np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
        path[:, joints] = hold[np.clip(ticks - lifts[role], 0, len(hold) - 1)][:, joints]
        time = STEP * np.array([lifts[role] - closing, lifts[role], places[role], places[role] + closing])
        names = ("grasp", "manipulate", "place")
        phases += [Phase(hand, name, float(time[i]), float(time[i + 1]), role) for i, name in enumerate(names)]
    return Timeline(first, STEP * ticks.astype(np.float64), path, tuple(phases))


def _on_clock(path: ObjectPath, timeline: Timeline) -> ObjectPath:
    """An object's path on the clock of the motion."""
    if np.allclose(np.diff(timeline.model_time), STEP):
        pose = poses_at(path, timeline.model_time)
    else:
        time = timeline.model_time.clip(path.time[0], path.time[-1])
        position = make_interp_spline(path.time, path.pose.translation, k=3)(time)
        pose = RigidTransform.from_components(position, Slerp(path.time, path.pose.rotation)(time))
    return ObjectPath(path.role, timeline.clock, pose)
