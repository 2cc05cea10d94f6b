"""What the hands do while they hold objects, before their ways to and from them are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from scipy.interpolate import pchip_interpolate
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import RigidTransform

from sbam.planning.grasping.candidates import Grasp
from sbam.planning.motion.demonstrated_shape import DemonstratedShape
from sbam.planning.motion.object_path import EASING, SMOOTHING, ObjectPath, object_path
from sbam.planning.motion.timeline import STEP, Phase, Timeline
from sbam.planning.task import MovedObject, RoleHand, Task
from sbam.robots import Robot
from sbam.robots.follow import follow

MARGIN = 25  # ticks
CLOSING_TIME = 0.3  # s in which the fingers close before the lift and open after the place


@dataclass(frozen=True)
class Holding:
    """Every hand from its grasp to its release.

    Attributes:
        grasps: (role, hand) -> grasp.
        keypoint_times: on the model's time axis, s.
        torso: the torso's joints at the keypoints.
        paths: role -> path of its object at every tick from before the lift to after the place.
        configurations: (role, hand) -> those from lift to place.
        timeline: all of them together; before its grasp and after its release a hand stays there.
    """

    grasps: Mapping[RoleHand, Grasp]
    keypoint_times: Float[np.ndarray, " keypoints"]
    torso: Float[np.ndarray, "keypoints torso_joints"]
    paths: Mapping[str, ObjectPath]
    configurations: Mapping[RoleHand, Float[np.ndarray, "_ticks joints"]]
    timeline: Timeline


def hold_objects(
    task: Task,
    robot: Robot,
    grasps: Mapping[RoleHand, Grasp],
    keypoint_times: Float[np.ndarray, " keypoints"],
    configurations: Float[np.ndarray, "keypoints joints"],
    object_poses: Mapping[str, RigidTransform],
    joints_between: Literal["lines", "splines"] | None = None,
    shapes: Mapping[str, DemonstratedShape] | None = None,
) -> Holding:
    """Bring the hands from lift to place along the optimised keypoints.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        grasps: (role, hand) -> grasp.
        keypoint_times: on the model's time axis, s.
        configurations: optimised configurations, which settle the redundancy.
        object_poses: role -> poses at the keypoints, agent frame.
        joints_between: interpolate the joints between keypoints instead of what is wanted: by straight lines, as the
            paper does, or by monotone cubic splines.
        shapes: role -> how its object moved in the demonstrations, to be kept between keypoints.

    Raises:
        UnreachableError: names hand, object, time and joint where the dense motion cannot be followed.
    """
    shapes = shapes or {}
    configurations = _with_steady_torso(task, robot, keypoint_times, configurations)
    paths: dict[str, ObjectPath] = {}
    holds: dict[RoleHand, Float[np.ndarray, "_ticks joints"]] = {}
    for moved in task.moved:
        ticks, poses = _hold_times(moved), object_poses[moved.role]
        path = object_path(task, moved, keypoint_times, poses, _longer(ticks), shapes.get(moved.role))
        paths[moved.role] = path
        for hand in moved.hands:
            hold: Float[np.ndarray, "ticks joints"]
            if joints_between == "splines":
                hold = np.asarray(pchip_interpolate(keypoint_times, configurations, ticks))
            elif joints_between == "lines":
                hold = np.stack([np.interp(ticks, keypoint_times, column) for column in configurations.T], axis=-1)
            else:
                pose = path.pose[MARGIN:-MARGIN]
                hold = _hold(robot, moved, grasps[RoleHand(moved.role, hand)], keypoint_times, configurations, pose)
            holds[RoleHand(moved.role, hand)] = hold
    torso = configurations[:, robot.torso_indices]
    return Holding(grasps, keypoint_times, torso, paths, holds, _timeline(task, robot, holds))


def _with_steady_torso(
    task: Task,
    robot: Robot,
    keypoint_times: Float[np.ndarray, " keypoints"],
    configurations: Float[np.ndarray, "keypoints joints"],
) -> Float[np.ndarray, "keypoints joints"]:
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


def references(
    keypoint_times: Float[np.ndarray, " keypoints"],
    values: Float[np.ndarray, "keypoints columns"],
    time: Float[np.ndarray, " ticks"],
) -> Float[np.ndarray, "ticks columns"]:
    """Keypoint values between keypoints, at even times and without corners."""
    between = np.empty((len(time), values.shape[1]))
    for index, column in enumerate(values.T):
        between[:, index] = np.interp(time, keypoint_times, column)
    return gaussian_filter1d(between, SMOOTHING / STEP, axis=0, mode="nearest")


def _hold_times(moved: MovedObject) -> Float[np.ndarray, " ticks"]:
    """Model times of the ticks from just before the lift to just after the place, s."""
    return STEP * np.arange(np.floor(moved.lift / STEP), np.ceil(moved.place / STEP) + 1.0, dtype=np.float64)


def _longer(times: Float[np.ndarray, " ticks"]) -> Float[np.ndarray, " more_ticks"]:
    """A hold's times with `MARGIN` more ticks at both ends.

    What is smoothed over them equals, on the hold, what is smoothed over the whole action.
    """
    more = STEP * np.arange(1, MARGIN + 1)
    return np.concatenate([times[0] - more[::-1], times, times[-1] + more])


def _hold(
    robot: Robot,
    moved: MovedObject,
    grasp: Grasp,
    keypoint_times: Float[np.ndarray, " keypoints"],
    configurations: Float[np.ndarray, "keypoints joints"],
    pose: RigidTransform,
) -> Float[np.ndarray, "ticks joints"]:
    """Configurations of one arm that keep its grasp of the object on every tick of `_hold_times`."""
    times = _hold_times(moved)
    tcp = pose * grasp.T_object_tcp
    clipped = np.clip(_longer(times), moved.lift, moved.place)
    reference = references(keypoint_times, configurations, clipped)[MARGIN:-MARGIN]
    torso = references(keypoint_times, configurations[:, robot.torso_indices], _longer(times))
    reference[:, robot.torso_indices] = torso[MARGIN:-MARGIN]
    solved = follow(robot, grasp.hand, tcp, reference, f"holding {moved.name!r}", times)
    return solved


def _timeline(task: Task, robot: Robot, holds: Mapping[RoleHand, Float[np.ndarray, "_ticks joints"]]) -> Timeline:
    """Every hand from grasp to release; before and after it stays there."""
    closing = round(CLOSING_TIME / STEP)
    lifts = {moved.role: round(_hold_times(moved)[0] / STEP) for moved in task.moved}
    places = {moved.role: round(_hold_times(moved)[-1] / STEP) for moved in task.moved}
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
