"""Position-controlled arms: what a robot's joint controllers do with a timed trajectory."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from sbam.robots.collision_pairs import hand_bodies
from sbam.robots.composition import OBJECT_PREFIX
from sbam.robots.description import ArmName
from sbam.robots.jacobian import point_jacobian
from sbam.robots.robot import Robot
from sbam.tasks.action import Arms, Grip

if TYPE_CHECKING:
    import mujoco

BANDWIDTH = 60.0  # rad/s: of a joint's critically damped position control
FINGER_FORCE = 40.0  # N, of each finger
CLOSED = 0.6  # share of the closing phase after which fingers that hold by contact press
LOAD_PERIOD = 0.02  # s between moments at which the held weight is computed


def finger_joints(robot: Robot, hand: ArmName) -> tuple[str, ...]:
    """Joints of a hand that are not planned: those of the bodies that the hand carries."""
    carried = set(hand_bodies(robot, hand)[1:])
    spec = robot.spec(lock=False)
    found = [joint.name for body in spec.bodies if body.name in carried for joint in body.joints]
    return tuple(name for name in found if name not in robot.joint_names)


def add_motors(spec: mujoco.MjSpec, robot: Robot, finger_force: float = FINGER_FORCE) -> None:
    """One position servo for every joint; gravity is compensated within the torque limits."""
    import mujoco

    limits = dict(zip(robot.joint_names, robot.torque_limit, strict=True))
    for joint in spec.joints:
        limit = float(limits.get(joint.name, finger_force))
        joint.actfrclimited = True
        joint.actfrcrange = [-limit, limit]
        joint.actgravcomp = True
        spec.add_actuator(
            name=joint.name,
            target=joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )


class MotorControl:
    """Commands of all servos over time: positions with feed-forward of velocity and of the weight that is held.

    The stiffness of each joint follows from its inertia at the start and `BANDWIDTH`.
    """

    def __init__(self, model: mujoco.MjModel, arms: Arms, press: float | None = None) -> None:
        """Prepare the servos.

        Args:
            model: the world.
            arms: robot, trajectory and grips.
            press: force with which fingers hold by contact, N; None for fingers that close for the eye only.
        """
        import mujoco

        self._arms, self._model, self._press = arms, model, press
        names = [model.actuator(i).name for i in range(model.nu)]
        joints = [model.joint(name) for name in names]
        self._address = np.array([int(joint.qposadr[0]) for joint in joints])
        self._dof = np.array([int(joint.dofadr[0]) for joint in joints])
        self.planned = np.array([names.index(name) for name in arms.trajectory.joint_names])
        rest = model.qpos0[self._address].copy()
        self._fingers = {hand: [names.index(j) for j in finger_joints(arms.robot, hand)] for hand in arms.robot.arms}
        for motor in itertools.chain(*self._fingers.values()):
            rest[motor] = arms.robot.description.locked_joints.get(names[motor], rest[motor])
        self._rest = rest
        data = mujoco.MjData(model)
        self.reset(data)
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        inertia = np.diag(mass)[self._dof]
        stiffness, self._damping = inertia * BANDWIDTH**2, 2.0 * inertia * BANDWIDTH
        self._lead, self._compliance = self._damping / stiffness, 1.0 / stiffness
        model.actuator_gainprm[:, 0] = stiffness
        model.actuator_biasprm[:, 1], model.actuator_biasprm[:, 2] = -stiffness, -self._damping

    def reset(self, data: mujoco.MjData) -> None:
        """Put the robot where its trajectory starts."""
        data.qpos[self._address] = self.wanted(np.zeros(1))[0][0]

    def wanted(
        self, times: Float[np.ndarray, " times"]
    ) -> tuple[Float[np.ndarray, "times motors"], Float[np.ndarray, "times motors"]]:
        """Positions and velocities that are commanded at times, s; fingers included."""
        trajectory = self._arms.trajectory
        times = np.clip(times, 0.0, trajectory.duration)
        position, velocity = np.tile(self._rest, (len(times), 1)), np.zeros((len(times), len(self._rest)))
        for column, motor in enumerate(self.planned):
            position[:, motor] = np.interp(times, trajectory.time, trajectory.position[:, column])
            velocity[:, motor] = np.interp(times, trajectory.time, trajectory.velocity[:, column])
        for grip in self._arms.grips:
            share = self._share(grip, times)
            held = 0.0
            if self._press is None:
                held = min(grip.width / self._arms.robot.arms[grip.hand].hand.max_width, 1.0)
            for motor in self._fingers[grip.hand]:
                position[:, motor] *= 1.0 - share * (1.0 - held)
        return position, velocity

    def commands(self, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, "times motors"]:
        """Control inputs at times, s."""
        position, velocity = self.wanted(times)
        return position + self._lead * velocity + self._compliance * (self._load(times) + self._pressing(times))

    def _share(self, grip: Grip, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, " times"]:
        """How far the fingers are closed, 0 to 1."""
        closed = grip.start
        if self._press is not None:  # they shall press before the object is lifted
            closed = grip.closing + CLOSED * (grip.start - grip.closing)
        return np.interp(times, [grip.closing, closed, grip.end, grip.opened], [0.0, 1.0, 1.0, 0.0])

    def _pressing(self, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, "times motors"]:
        """Forces of the fingers towards each other, N."""
        force = np.zeros((len(times), len(self._rest)))
        for grip in self._arms.grips:
            closed = self._share(grip, times) >= 1.0
            for motor in self._fingers[grip.hand]:
                force[closed, motor] -= np.sign(self._rest[motor]) * (self._press or 0.0)
        return force

    def _load(self, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, "times motors"]:
        """Torques that bear the weight of what is held, shared by its hands, Nm or N."""
        robot, grips, trajectory = self._arms.robot, self._arms.grips, self._arms.trajectory
        torque = np.zeros((len(times), len(self._rest)))
        moments = np.arange(0.0, trajectory.duration + LOAD_PERIOD, LOAD_PERIOD)
        configurations = self.wanted(moments)[0][:, self.planned]
        for grip in grips:
            tcp = robot.arms[grip.hand].tcp_frame
            kinematics = robot.kinematics(configurations, [tcp])
            body = self._model.body(OBJECT_PREFIX + grip.object)
            T_tcp_object = grip.T_object_tcp.inv()
            center = kinematics.position[:, 0] + kinematics.rotation[:, 0] @ T_tcp_object.apply(body.ipos)
            jacobian = point_jacobian(kinematics, center, robot.frame_joints(tcp))
            hands = sum(other.object == grip.object for other in grips)
            weight = -self._model.opt.gravity * float(body.mass[0]) / hands
            held = (times >= grip.start) & (times <= grip.end)
            for motor, column in zip(self.planned, (weight @ jacobian).T, strict=True):
                torque[held, motor] += np.interp(times[held], moments, column)
        return torque

    def tracking_error(
        self, data: mujoco.MjData, wanted: Float[np.ndarray, " motors"]
    ) -> Float[np.ndarray, " planned"]:
        """Measured minus commanded positions of the planned joints, rad or m."""
        return (data.qpos[self._address] - wanted)[self.planned]

    def torque(self, data: mujoco.MjData) -> Float[np.ndarray, " planned"]:
        """Torques of the planned joints, gravity compensation included, Nm or N."""
        return data.qfrc_actuator[self._dof[self.planned]]
