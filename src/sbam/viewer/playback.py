"""A plan as one MuJoCo model that can be set to any time of its trajectory; pictures and recordings draw it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from sbam.planning.plan import Plan
from sbam.robots.collision_pairs import hand_bodies
from sbam.robots.composition import OBJECT_PREFIX, add_objects, compile_spec, pose_arrays
from sbam.robots.lighting import light
from sbam.scene import AffordanceRegion, upright_rotation

STAND_RADIUS = 0.09
FLOOR_GAP = 0.002
STAND_COLOR = (0.35, 0.37, 0.40, 1.0)


@dataclass(frozen=True)
class Frames:
    """Where all bodies are at some times.

    Attributes:
        position: world, m; bodies as in the model.
        quaternion_wxyz: scalar first.
    """

    position: Float[np.ndarray, "times bodies 3"]
    quaternion_wxyz: Float[np.ndarray, "times bodies 4"]


class Playback:
    """Robot, fingers and objects of a plan over time, in the scene's world.

    Fingers are not planned; they are drawn open before the grasp, as wide as what they hold, and open afterwards.

    Attributes:
        plan: the plan.
        model: MuJoCo model; objects are mocap bodies called `OBJECT_PREFIX` + name; joints are all the robot's joints.
        duration: s.
        floor: height of the floor, world z, m: below everything that stands.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.duration = plan.trajectory.duration
        scene = plan.task.scene
        robot = plan.robot
        spec = robot.spec(lock=False)
        add_objects(spec, scene.objects)
        self.floor = _lowest_furniture(plan, float(robot.T_world_base.translation[2])) - FLOOR_GAP
        for part in robot.description.parts:
            foot = (robot.T_world_base * part.transform()).translation
            if foot[2] > self.floor + 0.005:
                half = 0.5 * (foot[2] - self.floor)
                spec.worldbody.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                    size=[STAND_RADIUS, half, 0.0],
                    pos=[foot[0], foot[1], self.floor + half],
                    rgba=STAND_COLOR,
                )
        light(spec, plan.T_world_agent)
        self.model = compile_spec(spec, robot.description.path)
        self._joints = [int(self.model.joint(name).qposadr[0]) for name in plan.trajectory.joint_names]
        self._rest = self.model.qpos0.copy()
        for name, position in robot.description.locked_joints.items():
            self._rest[self.model.joint(name).qposadr[0]] = position
        self._fingers = {hand: self._finger_joints(hand) for hand in robot.arms}
        self._poses = plan.object_poses()
        self._moved = list(self._poses)

    def body(self, name: str) -> int:
        """Index of a scene's object among the model's bodies."""
        return int(self.model.body(OBJECT_PREFIX + name).id)

    def configurations(self, times: ArrayLike) -> Float[np.ndarray, "times positions"]:
        """Positions of all the model's joints at times, s."""
        times = np.clip(np.atleast_1d(np.asarray(times, dtype=np.float64)), 0.0, self.duration)
        trajectory = self.plan.trajectory
        result = np.tile(self._rest, (len(times), 1))
        for column, address in enumerate(self._joints):
            result[:, address] = np.interp(times, trajectory.time, trajectory.position[:, column])
        for (role, hand), grasp in self.plan.grasps.items():
            phases = {p.name: p for p in self.plan.phases if p.role == role and p.hand == hand}
            closing, opening = phases["grasp"], phases["place"]
            share = np.interp(times, [closing.start, closing.end, opening.start, opening.end], [0.0, 1.0, 1.0, 0.0])
            held = grasp.width / self.plan.robot.arms[hand].hand.max_width
            for address in self._fingers[hand]:
                result[:, address] *= 1.0 - share * (1.0 - held)
        return result

    def object_poses(self, times: ArrayLike) -> dict[str, RigidTransform]:
        """Scene's name of every object -> poses in the world at times, s."""
        times = np.clip(np.atleast_1d(np.asarray(times, dtype=np.float64)), 0.0, self.duration)
        result = {}
        for name, start in self.plan.task.scene.T_world_object.items():
            if name not in self._poses:
                result[name] = RigidTransform.from_matrix(np.tile(start.as_matrix(), (len(times), 1, 1)))
                continue
            pose, clock = self._poses[name], self.plan.trajectory.time
            position = np.stack([np.interp(times, clock, column) for column in pose.translation.T], axis=-1)
            result[name] = RigidTransform.from_components(position, Slerp(clock, pose.rotation)(times))
        return result

    def set_time(self, data: mujoco.MjData, time: float) -> None:
        """Put all bodies where they are at a time, s, and compute what drawing needs."""
        data.qpos[:] = self.configurations(time)[0]
        for name, pose in self.object_poses(time).items():
            mocap = int(self.model.body_mocapid[self.body(name)])
            data.mocap_pos[mocap], data.mocap_quat[mocap] = pose_arrays(pose[0])
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_camlight(self.model, data)

    def frames(self, times: ArrayLike) -> Frames:
        """Poses of all bodies at times, s."""
        times = np.atleast_1d(np.asarray(times, dtype=np.float64))
        data = mujoco.MjData(self.model)
        position = np.empty((len(times), self.model.nbody, 3))
        quaternion_wxyz = np.empty((len(times), self.model.nbody, 4))
        configurations, poses = self.configurations(times), self.object_poses(times)
        mocap = {name: int(self.model.body_mocapid[self.body(name)]) for name in poses}
        for row in range(len(times)):
            data.qpos[:] = configurations[row]
            for name, index in mocap.items():
                data.mocap_pos[index], data.mocap_quat[index] = pose_arrays(poses[name][row])
            mujoco.mj_kinematics(self.model, data)
            position[row], quaternion_wxyz[row] = data.xpos, data.xquat
        return Frames(position, quaternion_wxyz)

    def label(self, time: float) -> str:
        """What the hands do at a time, such as ``left: manipulate, right: grasp``."""
        doing = [f"{p.hand}: {p.name}" for p in self.plan.phases if p.start <= time < p.end]
        return ", ".join(sorted(doing)) or "rest"

    def moments(self, count: int = 6) -> Float[np.ndarray, " moments"]:
        """Times that show the action, s: grasping, moving, the largest tilt, the end."""
        held = [phase for phase in self.plan.phases if phase.name == "manipulate"]
        start, end = min(phase.start for phase in held), max(phase.end for phase in held)
        times = np.linspace(start, end, count)
        tilts = [(pose.rotation * pose[0].rotation.inv()).as_matrix()[:, 2, 2] for pose in self._poses.values()]
        if tilts and count > 2:
            tilt = np.min(tilts, axis=0)
            steepest = self.plan.trajectory.time[tilt <= tilt.min() + 0.02].mean()
            times[1 + np.abs(times[1:-1] - steepest).argmin()] = steepest
        return np.sort(times)

    def _finger_joints(self, hand: str) -> list[int]:
        """Addresses of the joints that are not planned and belong to a hand."""
        side = "left" if hand == "left" else "right"
        bodies = {int(self.model.body(name).id) for name in hand_bodies(self.plan.robot, side)}
        planned = set(self._joints)
        return [
            int(self.model.jnt_qposadr[joint])
            for joint in range(self.model.njnt)
            if int(self.model.jnt_bodyid[joint]) in bodies and int(self.model.jnt_qposadr[joint]) not in planned
        ]


def ellipse_rotation(region: AffordanceRegion) -> Rotation:
    """How a region's ellipse lies in its object: x and y along its half-axes, z along its normal.

    The ellipse is the one in the x-y plane, turned by the shortest rotation that brings z to the normal (half a turn
    about x for a normal along -z).
    """
    return upright_rotation(region.normal, 0.0).inv()


def _lowest_furniture(plan: Plan, default: float) -> float:
    """Lowest point of what the objects stand on, and of the robot's base, world z, m."""
    lowest = default
    scene = plan.task.scene
    for name, model in scene.objects.items():
        for primitive in model.geometry:
            pose = scene.T_world_object[name] * primitive.T_object_primitive
            down = np.abs(pose.rotation.as_matrix()[2])
            size = primitive.size
            if primitive.kind == "box":
                reach = float(down @ size)
            elif primitive.kind == "sphere":
                reach = float(size[0])
            else:
                reach = float(size[0] + down[2] * size[1])
            lowest = min(lowest, float(pose.translation[2]) - reach)
    return lowest
