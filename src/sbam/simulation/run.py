"""Running an action in physics."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import SimulationError
from sbam.robots.composition import OBJECT_PREFIX, pose_arrays
from sbam.robots.lighting import light
from sbam.robots.robot import Robot
from sbam.scene import support_height
from sbam.simulation.arms import FINGER_FORCE, MotorControl, add_motors, finger_joints
from sbam.simulation.contacts import ContactWatch
from sbam.simulation.holding import WELD, WELD_IMPEDANCE, GraspKind, Holds, add_grips, check_grasp
from sbam.simulation.world import GUIDE, add_object, set_robot_contacts
from sbam.tasks.action import Action
from sbam.tasks.materials import SUPPORT, physics_options
from sbam.tasks.physics_task import PhysicsTask
from sbam.tasks.record import Record

if TYPE_CHECKING:
    import mujoco

SETTLE = 0.4  # s before the motion
AFTER = 0.6  # s after it, until what falls has fallen
FRAME = 0.02  # s between two frames of the record
FLOOR = 0.85  # m below the support


class World:
    """An action's robot, objects and what the task adds as one MuJoCo model, ready to be run.

    Attributes:
        action: what will be done.
        model: the model.
        grasp: how hands hold.
        grasp_force: of each finger, N, where they hold by contact.
    """

    def __init__(
        self, action: Action, task: PhysicsTask, grasp: GraspKind = "weld", grasp_force: float = FINGER_FORCE
    ) -> None:
        import mujoco

        check_grasp(action, grasp)
        if not 0.0 < grasp_force < np.inf:
            raise SimulationError(f"a grasp with {grasp_force:g} N: give a force above 0")
        self.action, self._task = action, task
        self.grasp: GraspKind = grasp
        self.grasp_force = grasp_force
        arms = action.arms
        spec = arms.robot.spec(free=_fingers(arms.robot)) if arms else mujoco.MjSpec()
        physics_options(spec)
        if arms:
            set_robot_contacts(spec, arms.robot)
            add_motors(spec, arms.robot, grasp_force)
        scene = action.scene
        for name, model in scene.objects.items():
            body = add_object(spec, name, model)
            body.pos, body.quat = pose_arrays(scene.T_world_object[name])
        floor = support_height(scene) - FLOOR
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[3, 3, 0.1],
            pos=[0, 0, floor],
            contype=SUPPORT[0],
            conaffinity=SUPPORT[1],
            rgba=[0.86, 0.87, 0.88, 1],
        )
        if arms:
            add_grips(spec, action, grasp)
        else:
            self._add_guides(spec)
        task.build(spec, action)
        light(spec, scene.T_world_agent)
        try:
            self.model = spec.compile()
        except ValueError as error:
            raise SimulationError(f"{action.name}: MuJoCo cannot build the world: {error}") from error
        self.control = MotorControl(self.model, arms, grasp_force if grasp == "contact" else None) if arms else None
        count = sum(self.model.body(i).name.startswith("particle/") for i in range(self.model.nbody))
        joints = [int(self.model.body(f"particle/{i}").jntadr[0]) for i in range(count)]
        self._particles = np.array([int(self.model.jnt_qposadr[j]) for j in joints], dtype=np.int64)
        self._movable = [name for name, model in scene.objects.items() if model.movable]
        self._bodies = [int(self.model.body(OBJECT_PREFIX + name).id) for name in self._movable]

    def _add_guides(self, spec: mujoco.MjSpec) -> None:
        import mujoco

        for name in self.action.T_world_object:
            position, quaternion_wxyz = pose_arrays(self.action.T_world_object[name][0])
            spec.worldbody.add_body(name=GUIDE + name, mocap=True, pos=position, quat=quaternion_wxyz)
            spec.add_equality(
                name=GUIDE + name,
                type=mujoco.mjtEq.mjEQ_WELD,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                name1=GUIDE + name,
                name2=OBJECT_PREFIX + name,
                active=True,
                data=[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0],
                solref=list(WELD),
                solimp=list(WELD_IMPEDANCE),
            )

    def run(self, progress: Callable[[float, float], None] | None = None) -> Record:
        """Let it happen.

        Args:
            progress: called now and then with the time that was simulated and how much there is, s.

        Raises:
            SimulationError: if the physics becomes unstable.
        """
        import mujoco

        model, action, control = self.model, self.action, self.control
        step = model.opt.timestep
        first, last = -round(SETTLE / step), round((action.duration + AFTER) / step)
        times = step * np.arange(first, last + 1)
        data = mujoco.MjData(model)
        commands = wanted = np.zeros((len(times), 0))
        if control:
            control.reset(data)
            commands, (wanted, _) = control.commands(times), control.wanted(times)
        self._task.start(model, data, action)
        guides = self._guide_poses(times)
        holds = Holds(model, action, self.grasp, times)
        watch = ContactWatch(model, action)
        every = round(FRAME / step)
        frames: list[
            tuple[float, Float[np.ndarray, " positions"], Float[np.ndarray, "bodies 3"], Float[np.ndarray, "bodies 4"]]
        ] = []
        measured: list[dict[str, Float[np.ndarray, ...]]] = []
        error = np.zeros(len(action.arms.trajectory.joint_names) if action.arms else 0)
        torque, worst = error.copy(), (0.0, 0.0)
        since = clock.process_time()
        for index, time in enumerate(times):
            for mocap, position, quaternion in guides:
                data.mocap_pos[mocap], data.mocap_quat[mocap] = position[index], quaternion[index]
            holds.switch(data, index)
            if control:
                data.ctrl[:] = commands[index]
            mujoco.mj_step(model, data)
            if control and time >= 0.0:
                now = np.abs(control.tracking_error(data, wanted[index]))
                np.maximum(error, now, out=error)
                worst = max(worst, (float(now.max()), float(time)))
                np.maximum(torque, np.abs(control.torque(data)), out=torque)
            if index % every == 0:
                watch.look(data, float(time), FRAME)
                holds.look(data, index, float(time))
                frames.append((float(time), data.qpos.copy(), data.xpos[self._bodies], data.xquat[self._bodies]))
                measured.append(self._task.observe(model, data, action))
                if progress:
                    progress(float(time) - times[0], times[-1] - times[0])
        seconds = clock.process_time() - since
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number or not np.isfinite(data.qpos).all():
            raise SimulationError(f"{action.name}: the physics became unstable")
        qpos = np.stack([frame[1] for frame in frames])
        positions, quaternions = np.stack([f[2] for f in frames], 1), np.stack([f[3] for f in frames], 1)
        names = action.arms.trajectory.joint_names if action.arms else ()
        limits = action.arms.robot.torque_limit if action.arms else np.ones(0)
        return Record(
            time=np.array([frame[0] for frame in frames]),
            T_world_object={
                name: RigidTransform.from_components(
                    positions[i], Rotation.from_quat(quaternions[i], scalar_first=True)
                )
                for i, name in enumerate(self._movable)
            },
            qpos=qpos,
            particles=qpos[:, self._particles[:, None] + np.arange(3)],
            measured={key: np.stack([m[key] for m in measured]) for key in measured[0]},
            contacts=watch.contacts(),
            tracking_error=dict(zip(names, error.tolist(), strict=True)),
            torque_ratio=dict(zip(names, (torque / limits).tolist(), strict=True)),
            worst_tracking=worst[1],
            slip=holds.slips(),
            seconds=seconds,
            simulated=float(times[-1] - times[0]),
        )

    def _guide_poses(
        self, times: Float[np.ndarray, " times"]
    ) -> list[tuple[int, Float[np.ndarray, "times 3"], Float[np.ndarray, "times 4"]]]:
        if self.action.arms:
            return []
        poses = {name: self.action.poses(name, times) for name in self.action.T_world_object}
        return [(int(self.model.body(GUIDE + name).mocapid[0]), *pose_arrays(pose)) for name, pose in poses.items()]


def _fingers(robot: Robot) -> list[str]:
    """Joints that move beside the planned ones; all others, such as torso and neck, are braked."""
    return [joint for hand in robot.arms for joint in finger_joints(robot, hand)]
