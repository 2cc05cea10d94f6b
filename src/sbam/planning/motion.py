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
from sbam.errors import UnreachableError
from sbam.planning.grasps import Grasp
from sbam.planning.inverse_kinematics import solve_poses
from sbam.planning.object_path import SMOOTHING, ObjectPath, ease, object_path
from sbam.planning.task import MovedObject, Task
from sbam.robots import Robot

Array = NDArray[np.float64]

STEP = 0.02  # s between the configurations that are solved for
STANDOFF = 0.08  # m from which a grasp is approached in a straight line, and to which the hand retreats
LINE_TIME = 0.8  # s of the straight part
CLOSING_TIME = 0.3  # s in which the fingers close before the lift and open after the place
TRANSFER_SPEED = 1.0  # rad/s: mean speed of the fastest joint between home and the standoff
TOLERANCE = 2e-4  # m: what a solved configuration may be off its target


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


@dataclass(frozen=True)
class _Reach:
    """Way of one arm from home to its grasp, or back: configurations at equal steps of the clock."""

    transfer: Array
    line: Array

    @property
    def joined(self) -> Array:
        return np.concatenate([self.transfer, self.line[1:]])


def make_motion(
    task: Task,
    robot: Robot,
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
    held, reaches, begins, ends = {}, {}, [], []
    for moved in task.moved:
        for hand in moved.hands:
            grasp = grasps[moved.role, hand]
            if interpolate_joints:
                ticks = _hold_clock(moved)
                hold = np.stack([np.interp(ticks, keypoint_times, column) for column in configurations.T], axis=-1)
            else:
                hold = _hold(task, robot, moved, grasp, keypoint_times, configurations, object_poses[moved.role])
            approach = _reach(robot, moved.start, grasp, hold[0], home)
            retreat = _reach(robot, moved.put_down, grasp, hold[-1], home)
            held[moved.role, hand], reaches[moved.role, hand] = hold, (approach, retreat)
            begins.append(moved.lift - CLOSING_TIME - STEP * (len(approach.joined) - 1))
            ends.append(moved.place + CLOSING_TIME + STEP * (len(retreat.joined) - 1))
    first = int(np.floor(min([*begins, keypoint_times[0]]) / STEP)) - 2
    last = int(np.ceil(max([*ends, keypoint_times[-1]]) / STEP)) + 2
    clock = STEP * np.arange(first, last + 1)
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
    return STEP * np.arange(int(np.floor(moved.lift / STEP)), int(np.ceil(moved.place / STEP)) + 1)


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
    solved = _follow(robot, grasp.hand, tcp, reference, f"holding {moved.name!r}", clock)
    return solved


def _follow(
    robot: Robot, hand: Hand, tcp: RigidTransform, reference: Array, what: str, clock: Array | None = None
) -> Array:
    """Configurations that bring one TCP to a sequence of poses, near a smooth reference."""
    position, rotation = tcp.translation[:, None], tcp.rotation.as_matrix()[:, None]
    solution = solve_poses(robot, [hand], position, rotation, reference, pull=(1e-3,))
    missed = ~solution.reached(TOLERANCE, np.deg2rad(0.05))
    if missed.any():
        # The neighbours of what was reached are good starts; the reference alone was too far off.
        q = solution.configurations.copy()
        for order in (range(1, len(q)), range(len(q) - 2, -1, -1)):
            for i in order:
                if missed[i]:
                    near = q[i - 1] if order.step == 1 else q[i + 1]
                    again = solve_poses(robot, [hand], position[[i]], rotation[[i]], near, reference[[i]], pull=(1e-3,))
                    if again.reached(TOLERANCE, np.deg2rad(0.05))[0]:
                        q[i], missed[i] = again.configurations[0], False
        if missed.any():
            worst = int(np.argmax(np.where(missed, solution.position_error, -1.0)))
            q_worst = solution.configurations[worst]
            joints = [
                robot.joint_names[j]
                for j in np.flatnonzero(robot.frame_joints(robot.arms[hand].tcp_frame))
                if q_worst[j] - robot.lower[j] < 1e-3 or robot.upper[j] - q_worst[j] < 1e-3
            ]
            when = f" at {clock[worst]:.2f} s" if clock is not None else ""
            stopped = f"; joints at their limits: {', '.join(joints)}" if joints else "; the arm is too short"
            raise UnreachableError(
                f"{robot.name}'s {hand} hand cannot follow its path {what}{when}: "
                f"{1e3 * solution.position_error[worst]:.1f} mm and "
                f"{np.rad2deg(solution.rotation_error[worst]):.1f} degrees off{stopped}"
            )
        return q
    return solution.configurations


def _reach(robot: Robot, pose: RigidTransform, grasp: Grasp, at_grasp: Array, home: Array) -> _Reach:
    """From home to the grasp: joints to the standoff, then a straight line along the hand's approach."""
    T_agent_tcp = pose * grasp.T_object_tcp
    approach = T_agent_tcp.rotation.apply(np.array(robot.arms[grasp.hand].hand.approach))
    count = int(round(LINE_TIME / STEP)) + 1
    distance = STANDOFF * (1.0 - ease(np.linspace(0.0, 1.0, count)))
    positions = T_agent_tcp.translation - distance[:, None] * approach
    line_poses = RigidTransform.from_components(positions, T_agent_tcp.rotation)
    line = _follow(robot, grasp.hand, line_poses, np.tile(at_grasp, (count, 1)), f"to its grasp of {grasp.role!r}")
    joints = np.flatnonzero(robot.frame_joints(robot.arms[grasp.hand].tcp_frame))
    # The last configuration is the grasp's own: the line is moved over by the (tiny) difference it was solved with.
    line = line + (at_grasp - line[-1])
    travel = float(np.abs(line[0, joints] - home[joints]).max())
    steps = max(int(np.ceil(max(travel / TRANSFER_SPEED, 0.5) / STEP)), 1)
    share = ease(np.linspace(0.0, 1.0, steps + 1))[:, None]
    return _Reach(home + share * (line[0] - home), line)


def _place_on_clock(
    clock: Array,
    path: Array,
    joints: NDArray[np.int_],
    moved: MovedObject,
    hand: Hand,
    hold: Array,
    approach: _Reach,
    retreat: _Reach,
) -> Sequence[Phase]:
    """Write one arm's columns of the path and say which phase is when."""
    ticks = _hold_clock(moved)
    offset = int(round((ticks[0] - clock[0]) / STEP))
    closing = int(round(CLOSING_TIME / STEP))
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
