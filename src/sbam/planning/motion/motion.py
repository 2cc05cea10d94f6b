"""Joint motion of the whole action: approach, grasp, manipulate, place and retreat of every hand on one clock.

The clock is the model's time axis, extended where the robot needs longer to approach than the person did, and where one
arm has to wait until the other one has passed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import RigidTransform, Slerp

from sbam.planning.motion.carrying import Holding, references
from sbam.planning.motion.object_path import ObjectPath, ease
from sbam.planning.motion.schedule import poses_at, with_ways
from sbam.planning.motion.timeline import STEP, Phase, Timeline
from sbam.planning.motion.transfer import LINE_TIME
from sbam.planning.task import RoleHand, Task
from sbam.robots import Robot
from sbam.robots.collision import CollisionModel


@dataclass(frozen=True)
class Motion:
    """The dense motion before it is timed.

    Attributes:
        clock: uniform, s; starts before 0 where approaches take longer than the person's.
        model_time: on the model's axis, s, at these ticks: the clock, as long as nothing has waited.
        configurations: rad or m.
        T_agent_object: object name -> poses of every moved object at these ticks, agent frame.
        phases: what each hand does when.
        surplus: least distance beyond the one asked for that was found on the ways to and from the objects, m.
        narrowest: (role, hand) whose way that is.
        notes: a sentence for each time that one arm waits for the other.
    """

    clock: Float[np.ndarray, " ticks"]
    model_time: Float[np.ndarray, " ticks"]
    configurations: Float[np.ndarray, "ticks joints"]
    T_agent_object: Mapping[str, RigidTransform]
    phases: tuple[Phase, ...]
    surplus: float
    narrowest: RoleHand | None
    notes: tuple[str, ...]


def with_approaches(
    task: Task, robot: Robot, collision: CollisionModel, holding: Holding, clearance: float = 0.0
) -> Motion:
    """Bring the hands from home to what they hold, and back, at a ``clearance`` in m from what they must not touch.

    Raises:
        UnreachableError: if a grasp cannot be approached in a straight line.
    """
    timeline, surplus, narrowest = with_ways(task, robot, collision, holding, clearance)
    times = holding.keypoint_times
    early = min(0, int(np.floor((times[0] - timeline.model_time[0]) / STEP)))
    late = max(0, int(np.ceil((times[-1] - timeline.model_time[-1]) / STEP)))
    timeline = timeline.covering(early - 2, len(timeline.model_time) + late + 1)
    path = timeline.configurations.copy()
    torso = _at(timeline.model_time, times, holding.torso)
    _move_torso(robot, timeline.clock, path, timeline.phases, robot.clip(robot.home), torso)
    return _motion(task, holding, replace(timeline, configurations=path), surplus, narrowest)


def while_holding(task: Task, robot: Robot, holding: Holding) -> Motion:
    """The motion as if every hand came from home, and went there, in no time."""
    timeline = holding.timeline
    path, clock = timeline.configurations.copy(), timeline.clock
    for moved in task.moved:
        for hand in moved.hands:
            away = clock < timeline.phase(hand, moved.role, "grasp").start
            away |= clock > timeline.phase(hand, moved.role, "place").end
            joints = robot.arms[hand].joint_indices
            path[np.ix_(away, joints)] = robot.clip(robot.home)[joints]
    return _motion(task, holding, replace(timeline, configurations=path), np.inf, None)


def _motion(task: Task, holding: Holding, timeline: Timeline, surplus: float, narrowest: RoleHand | None) -> Motion:
    return Motion(
        clock=timeline.clock,
        model_time=timeline.model_time,
        configurations=timeline.configurations,
        T_agent_object={moved.name: _on_clock(holding.paths[moved.role], timeline) for moved in task.moved},
        phases=tuple(sorted(timeline.phases, key=lambda phase: (phase.hand, phase.start))),
        surplus=surplus,
        narrowest=narrowest,
        notes=timeline.notes,
    )


def _at(
    model_time: Float[np.ndarray, " ticks"],
    keypoint_times: Float[np.ndarray, " keypoints"],
    values: Float[np.ndarray, "keypoints columns"],
) -> Float[np.ndarray, "ticks columns"]:
    """Keypoint values at increasing model times, without corners."""
    if values.shape[1] == 0:
        return np.empty((len(model_time), 0))
    first, last = np.floor(model_time[0] / STEP), np.ceil(model_time[-1] / STEP)
    even = STEP * np.arange(first, last + 1.0)
    return make_interp_spline(even, references(keypoint_times, values, even), k=3)(model_time)


def _move_torso(
    robot: Robot,
    clock: Float[np.ndarray, " ticks"],
    path: Float[np.ndarray, "ticks joints"],
    phases: Sequence[Phase],
    home: Float[np.ndarray, " joints"],
    torso: Float[np.ndarray, "ticks torso_joints"],
) -> None:
    """Bring the torso from home to where it is needed before any hand comes near, and back after all have left."""
    if len(robot.torso_indices) == 0 or not phases:
        return
    first, last = min(phase.start for phase in phases), max(phase.end for phase in phases)
    near = min(phase.end for phase in phases if phase.name == "approach") - LINE_TIME
    away = max(phase.start for phase in phases if phase.name == "retreat") + LINE_TIME
    there = ease((clock - first) / (near - first)) * ease((last - clock) / (last - away))
    resting = home[robot.torso_indices]
    path[:, robot.torso_indices] = resting + there[:, None] * (torso - resting)


def _on_clock(path: ObjectPath, timeline: Timeline) -> RigidTransform:
    """An object's poses at the ticks of the motion's clock."""
    if np.allclose(np.diff(timeline.model_time), STEP):
        return poses_at(path, timeline.model_time)
    time = timeline.model_time.clip(path.model_time[0], path.model_time[-1])
    position = make_interp_spline(path.model_time, path.pose.translation, k=3)(time)
    return RigidTransform.from_components(position, Slerp(path.model_time, path.pose.rotation)(time))
