"""Verification: what a timed trajectory does to the objects, and whether all of it would be accepted."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform

from sbam.planning.grasping.candidates import Grasp
from sbam.planning.motion.allowed_contacts import touching_hands
from sbam.planning.motion.motion import Motion, Phase
from sbam.planning.task import RoleHand, Task
from sbam.planning.trajectory.limits import Check, check_receivers
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.robots import ObjectHand, Robot, point_jacobian
from sbam.robots.collision import CollisionModel
from sbam.robots.rotation_error import rotation_error
from sbam.robots.swept_clearance import swept_clearances

CLOSURE_POSITION = 1e-3  # m: how far the second hand of a two-handed grasp may slip
CLOSURE_ROTATION = np.deg2rad(0.5)  # rad
JUMP = 1e-3  # m: how far an object may jump when it is taken over by a hand or left standing
TORQUE_SAMPLES = 50.0  # Hz
GRAVITY = 9.81  # m/s^2


def verify(
    task: Task,
    robot: Robot,
    collision: CollisionModel,
    grasps: Mapping[RoleHand, Grasp],
    motion: Motion,
    trajectory: JointTrajectory,
    clock: Float[np.ndarray, " samples"],
    clearance: float,
    speed: float = 1.0,
) -> tuple[dict[str, RigidTransform], tuple[Check, ...]]:
    """Check a trajectory as its receivers would, and carry the objects along it by forward kinematics at every sample.

    Args:
        task: model bound to a scene.
        robot: robot standing in the agent frame.
        collision: shapes of the robot and the scene's objects.
        grasps: (role, hand) -> grasp.
        motion: the dense motion that was timed.
        trajectory: the timed trajectory.
        clock: of its samples, the motion's clock, s.
        clearance: distance that must be kept from what is not touched on purpose, m.
        speed: share of the velocity limits that is granted.

    Returns:
        Object name -> poses of every moved object, agent frame: still before the lift, carried, still after the
        place. And all checks.
    """
    arms = list(robot.arms)
    kinematics = robot.kinematics(trajectory.position, [robot.arms[arm].tcp_frame for arm in arms])
    T_agent_tcp = np.zeros((len(arms), len(clock), 4, 4))
    T_agent_tcp[..., :3, :3] = kinematics.rotation.swapaxes(0, 1)
    T_agent_tcp[..., :3, 3] = kinematics.position.swapaxes(0, 1)
    T_agent_tcp[..., 3, 3] = 1.0
    tcp = dict(zip(arms, T_agent_tcp, strict=True))
    checks = check_receivers(robot, trajectory, robot.clip(robot.home), speed)
    poses: dict[str, RigidTransform] = {}
    for moved in task.moved:
        phases = {
            phase.name: phase for phase in motion.phases if phase.role == moved.role and phase.hand == moved.hands[0]
        }
        lift, place = phases["manipulate"].start, phases["manipulate"].end
        carrier = RoleHand(moved.role, moved.hands[0])
        pose = tcp[carrier.hand] @ grasps[carrier].T_object_tcp.inv().as_matrix()
        pose[clock <= lift] = moved.start.as_matrix()
        pose[clock >= place] = moved.put_down.as_matrix()
        poses[moved.name] = RigidTransform(pose, normalize=False, copy=False)
        for hand in moved.hands:
            grasp = grasps[RoleHand(moved.role, hand)]
            checks += _check_hold(task, grasp, tcp[hand], pose, motion, trajectory, clock)
        wanted = motion.T_agent_object[moved.name].translation
        expected = np.stack([np.interp(clock, motion.clock, column) for column in wanted.T], axis=-1)
        off = np.linalg.norm(pose[:, :3, 3] - expected, axis=1)
        checks.append(_largest(f"{moved.name} follows its path", off, 2e-3, "m", trajectory.time))
    checks += check_clearances(task, collision, motion, poses, trajectory, clock, clearance)
    checks.append(_check_torques(task, robot, poses, grasps, trajectory))
    return poses, tuple(checks)


def check_clearances(
    task: Task,
    collision: CollisionModel,
    motion: Motion,
    poses: Mapping[str, RigidTransform],
    trajectory: JointTrajectory,
    clock: Float[np.ndarray, " samples"],
    clearance: float,
) -> list[Check]:
    """Distances over all samples, by class of pairs; a hand may touch its object from the straight approach on.

    Of a palm and what it holds the distance is known up to what the grasp slips, which `_check_hold` limits.
    """
    objects = {**task.T_agent_object, **poses}
    held = touching_hands(task, motion.phases, clock)
    rigid = {ObjectHand(moved.name, key.hand): _is_held(motion, key, clock) for moved, key in task.holds}
    report = swept_clearances(collision, trajectory.position, objects, held, rigid)
    checks = []
    for kind, (distance,) in report.distance_by_class.items():
        (pair,), (when,) = report.pair_by_class[kind], report.sample_by_class[kind]
        where = f"{' and '.join(pair)} at {trajectory.time[when]:.3f} s" if pair else ""
        wanted = 0.0 if kind == "palm-object" else clearance
        checks.append(Check(f"clearance {kind}", bool(distance >= wanted), float(distance), wanted, "m", where))
    return checks


def _stride(trajectory: JointTrajectory, rate: float) -> int:
    """Samples between two that are looked at ``rate`` times per second, at least 1."""
    return max(1, round(1.0 / (rate * float(trajectory.time[1] - trajectory.time[0]))))


def _largest(
    name: str, values: Float[np.ndarray, " samples"], limit: float, unit: str, time: Float[np.ndarray, " samples"]
) -> Check:
    worst = int(np.argmax(values))
    return Check(name, bool(values[worst] <= limit), float(values[worst]), limit, unit, f"at {time[worst]:.3f} s")


def _is_held(motion: Motion, key: RoleHand, clock: Float[np.ndarray, " samples"]) -> Bool[np.ndarray, " samples"]:
    """When a hand holds its object fast: from the closing of its fingers to their opening."""
    phases = {phase.name: phase for phase in motion.phases if (phase.role, phase.hand) == key}
    return (clock >= phases["grasp"].start) & (clock <= phases["place"].end)


def _check_hold(
    task: Task,
    grasp: Grasp,
    tcp: Float[np.ndarray, "samples 4 4"],
    pose: Float[np.ndarray, "samples 4 4"],
    motion: Motion,
    trajectory: JointTrajectory,
    clock: Float[np.ndarray, " samples"],
) -> Sequence[Check]:
    """A hand keeps its grasp from closing to opening: in the object's frame the TCP stands still.

    Args:
        task: model bound to a scene.
        grasp: the grasp.
        tcp: poses of the hand's TCP, agent frame.
        pose: poses of the object, agent frame.
        motion: says when the fingers close and open.
        trajectory: the timed trajectory.
        clock: of its samples, the motion's clock, s.
    """
    held = _is_held(motion, RoleHand(grasp.role, grasp.hand), clock)
    tcp, wanted = tcp[held], pose[held] @ grasp.T_object_tcp.as_matrix()
    slip = np.linalg.norm(tcp[:, :3, 3] - wanted[:, :3, 3], axis=1)
    turn = np.linalg.norm(rotation_error(tcp[:, :3, :3], wanted[:, :3, :3]), axis=1)
    name = next(moved.name for moved in task.moved if moved.role == grasp.role)
    time = trajectory.time[held]
    return [
        _largest(
            f"{grasp.hand} hand keeps its place on {name}",
            slip,
            min(CLOSURE_POSITION, JUMP),
            "m",
            time,
        ),
        _largest(f"{grasp.hand} hand keeps its angle on {name}", turn, CLOSURE_ROTATION, "rad", time),
    ]


def _check_torques(
    task: Task,
    robot: Robot,
    poses: Mapping[str, RigidTransform],
    grasps: Mapping[RoleHand, Grasp],
    trajectory: JointTrajectory,
) -> Check:
    """Inverse dynamics of the arms with the weight of what they hold, against the torque limits.

    An object's weight acts at its TCP; two hands share it. The object's inertia is left out: it is small beside gravity
    at the accelerations of manipulation.
    """
    import mujoco

    model = copy.copy(robot.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    samples = np.arange(0, len(trajectory.time), _stride(trajectory, TORQUE_SAMPLES))
    motion = np.stack([a[samples] for a in (trajectory.position, trajectory.velocity, trajectory.acceleration)], axis=1)
    torque = np.empty((len(samples), len(robot.joint_names)))
    qpos, qvel, qacc, inverse = data.qpos, data.qvel, data.qacc, data.qfrc_inverse
    for row, (position, velocity, acceleration) in enumerate(motion):
        qpos[:], qvel[:], qacc[:] = position, velocity, acceleration
        mujoco.mj_inverse(model, data)
        torque[row] = inverse
    frames = [robot.arms[hand].tcp_frame for _, hand in grasps]
    kinematics = robot.kinematics(motion[:, 0], frames)
    for i, (role, _) in enumerate(grasps):
        moved = next(moved for moved in task.moved if moved.role == role)
        aloft = np.linalg.norm(poses[moved.name].translation[samples] - moved.start.translation, axis=1) > 1e-3
        lifting = point_jacobian(kinematics, kinematics.position[:, i], robot.frame_joints(frames[i]))[:, 2]
        torque += (aloft * moved.model.mass * GRAVITY / len(moved.hands))[:, None] * lifting
    ratio = np.abs(torque) / robot.torque_limit
    row, joint = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    worst = float(ratio[row, joint])
    where = f"{robot.joint_names[joint]} at {trajectory.time[samples[row]]:.3f} s"
    return Check("torque limits", worst <= 1.0, worst, 1.0, "of the limit", where)


def phase_times(motion: Motion, trajectory: JointTrajectory, clock: Float[np.ndarray, " samples"]) -> tuple[Phase, ...]:
    """The motion's phases with their times on the trajectory's axis, s; ``clock`` is that of its samples, s."""

    def on_trajectory(moment: float) -> float:
        return float(np.interp(moment, clock, trajectory.time))

    return tuple(replace(p, start=on_trajectory(p.start), end=on_trajectory(p.end)) for p in motion.phases)
