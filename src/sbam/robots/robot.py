"""Robot: joints, arms and batched kinematics of a two-armed robot on MuJoCo."""

from __future__ import annotations

import copy
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import ConfigurationError, FileFormatError, UnknownNameError
from sbam.robots.composition import BASE, compile_spec, compose, pose_arrays
from sbam.robots.description import ArmDescription, ArmName, HandDescription, RobotDescription

if TYPE_CHECKING:
    import mujoco

Floats = NDArray[np.float64]

TWINS = 8  # configurations for which MuJoCo is called once: more save little and make few configurations slower


@dataclass(frozen=True)
class Arm:
    """One arm.

    Attributes:
        name: ``left`` or ``right``.
        tcp_frame: tool centre point.
        joint_indices: (m,) columns of the robot's joints that belong to this arm alone, shoulder to hand.
        shoulder_frame: frame at the centre of the shoulder.
        elbow_frame: frame at the elbow.
        wrist_frame: frame at the wrist.
        length: largest distance of the TCP from the shoulder, m.
        hand: body of the hand and its directions of approach and opening in the TCP frame.
        ik_seeds: (k, m) good starts of inverse kinematics beside the home posture.
    """

    name: ArmName
    tcp_frame: str
    joint_indices: NDArray[np.int64]
    shoulder_frame: str
    elbow_frame: str
    wrist_frame: str
    length: float
    hand: HandDescription
    ik_seeds: Floats


@dataclass(frozen=True)
class Kinematics:
    """Where B configurations put F frames and n joints, in the world.

    Attributes:
        frames: names of the frames, in the order asked for.
        position: (B, F, 3) origins of the frames, m.
        rotation: (B, F, 3, 3) rotation matrices of the frames, R_world_frame.
        joint_position: (B, n, 3) a point on each joint's axis, m.
        joint_axis: (B, n, 3) unit axes of the joints.
        is_prismatic: (n,) which joints slide along their axis instead of turning about it.
    """

    frames: tuple[str, ...]
    position: Floats
    rotation: Floats
    joint_position: Floats
    joint_axis: Floats
    is_prismatic: NDArray[np.bool_]


class Robot:
    """A two-armed robot that stands somewhere in the world; immutable.

    Build it with `sbam.robots.load_robot`.

    Attributes:
        name: name of the robot.
        description: its description.
        T_world_base: where the robot's frame (x forward, y left, z up) stands.
        model: MuJoCo model whose joints are exactly ``joint_names``; shapes included, no actuators.
        joint_names: names of the n planned joints; the column order of every joint array.
        lower: (n,) lower position limits, rad or m; -inf for continuous joints.
        upper: (n,) upper position limits; inf for continuous joints.
        velocity_limit: (n,) rad/s or m/s.
        acceleration_limit: (n,) rad/s^2 or m/s^2.
        jerk_limit: (n,) rad/s^3 or m/s^3.
        torque_limit: (n,) Nm or N.
        is_prismatic: (n,) bool.
        is_continuous: (n,) bool: revolute without position limits.
        home: (n,) home posture.
        torso_indices: columns of the joints that move both arms.
        arms: ``left`` and ``right``.
        frame_names: names of all frames: the model's bodies and sites.
    """

    def __init__(self, description: RobotDescription, T_world_base: RigidTransform) -> None:
        import mujoco

        self.name = description.name
        self.description = description
        self.T_world_base = T_world_base
        model = compile_spec(compose(description, T_world_base), description.path)
        self.model = model
        self.joint_names = tuple(model.joint(i).name for i in range(model.njnt))
        self.is_prismatic = np.asarray(model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE)
        limited = model.jnt_limited.astype(bool)
        self.is_continuous = ~limited & ~self.is_prismatic
        self.lower = np.where(limited, model.jnt_range[:, 0], -np.inf)
        self.upper = np.where(limited, model.jnt_range[:, 1], np.inf)
        joints = [description.joints[name] for name in self.joint_names]
        self.velocity_limit = np.array([joint.velocity for joint in joints])
        self.acceleration_limit = np.array([joint.acceleration for joint in joints])
        self.jerk_limit = np.array([joint.jerk for joint in joints])
        self.torque_limit = np.array([joint.torque for joint in joints])
        self.home = np.array([joint.home for joint in joints])
        for name, home, lower, upper in zip(self.joint_names, self.home, self.lower, self.upper, strict=True):
            if not lower <= home <= upper:
                where = f"$.joints.{name}.home"
                raise FileFormatError(description.path, where, f"is {home}", f"{lower} to {upper}, the model's limits")
        column = {name: index for index, name in enumerate(self.joint_names)}
        self.torso_indices = np.array([column[name] for name in description.torso_joints], dtype=np.int64)
        self._frames = _frame_table(model)
        self.frame_names = tuple(self._frames)
        self.arms: Mapping[ArmName, Arm] = {
            side: self._arm(side, arm, column) for side, arm in sorted(description.arms.items())
        }
        self._kinematic_model = _twins(description, T_world_base)
        self._spare_data: list[mujoco.MjData] = []

    def _arm(self, side: ArmName, arm: ArmDescription, column: Mapping[str, int]) -> Arm:
        path, where = self.description.path, f"$.arms.{side}"
        for field in ("tcp", "shoulder", "elbow", "wrist"):
            if (frame := getattr(arm, field)) not in self._frames:
                raise UnknownNameError("frame", frame, self._frames, f"{path} at {where}.{field}")
        bodies = [self.model.body(body).name for body in range(1, self.model.nbody)]
        if arm.hand.body not in bodies:
            raise UnknownNameError("body", arm.hand.body, bodies, f"{path} at {where}.hand.body")
        indices = np.array([column[name] for name in arm.joints], dtype=np.int64)
        seeds = np.array(arm.ik_seeds).reshape(-1, len(indices))
        outside = np.argwhere((seeds < self.lower[indices]) | (seeds > self.upper[indices]))
        for seed, joint in outside:
            limits = f"{self.lower[indices[joint]]} to {self.upper[indices[joint]]}"
            raise FileFormatError(path, f"{where}.ik_seeds[{seed}][{joint}]", f"is {seeds[seed, joint]}", limits)
        return Arm(side, arm.tcp, indices, arm.shoulder, arm.elbow, arm.wrist, arm.length, arm.hand, seeds)

    @property
    def T_world_agent(self) -> RigidTransform:
        """The agent frame at which the robot stands in its default place."""
        return self.T_world_base * self.description.base_in_agent.transform().inv()

    @cached_property
    def _joint_masks(self) -> dict[str, NDArray[np.bool_]]:
        model = self.model
        masks = {}
        for name, (body, _, _) in self._frames.items():
            mask = np.zeros(len(self.joint_names), dtype=bool)
            while body:
                if model.body_jntnum[body]:
                    mask[model.body_jntadr[body] :][: model.body_jntnum[body]] = True
                body = model.body_parentid[body]
            mask.setflags(write=False)
            masks[name] = mask
        return masks

    def _known(self, frame: str) -> str:
        if frame not in self._frames:
            raise UnknownNameError("frame", frame, self._frames, f"robot {self.name!r}")
        return frame

    def frame_joints(self, frame: str) -> NDArray[np.bool_]:
        """Mask (n,) of the joints that move a frame; raises `UnknownNameError` for an unknown frame."""
        return self._joint_masks[self._known(frame)]

    def clip(self, configurations: ArrayLike) -> Floats:
        """Configurations (..., n) projected into the position limits."""
        return np.clip(configurations, self.lower, self.upper)

    def turned_near(self, configurations: ArrayLike, reference: ArrayLike) -> Floats:
        """The same postures (..., n) with every continuous joint within half a turn of a reference."""
        q = np.asarray(configurations, dtype=np.float64)
        turns = np.round((q - np.asarray(reference)) / (2 * np.pi))
        return np.where(self.is_continuous, q - 2 * np.pi * turns, q)

    def checked(self, configurations: ArrayLike) -> Floats:
        """Configurations as a contiguous (B, n) array of finite numbers.

        Raises:
            ConfigurationError: if the shape is another or a value is not finite; names sample and joint.
        """
        result = np.ascontiguousarray(configurations, dtype=np.float64)
        if result.ndim != 2 or result.shape[1] != len(self.joint_names):
            expected = f"(B, {len(self.joint_names)}), columns {', '.join(self.joint_names)}"
            raise ConfigurationError(self.name, f"shape {result.shape}", expected)
        if not np.isfinite(result).all():
            sample, joint = np.argwhere(~np.isfinite(result))[0]
            problem = f"joint {self.joint_names[joint]!r} of sample {sample} is {result[sample, joint]}"
            raise ConfigurationError(self.name, problem, "finite numbers")
        return result

    def kinematics(self, configurations: ArrayLike, frames: Sequence[str]) -> Kinematics:
        """Forward kinematics of many configurations; may be called from several threads at once.

        Args:
            configurations: (B, n) joint positions, rad or m, columns as ``joint_names``.
            frames: names of the frames wanted.

        Raises:
            ConfigurationError: if the configurations have another shape or are not finite.
            UnknownNameError: if a frame is not known.
        """
        import mujoco

        configurations = self.checked(configurations)
        table = [self._frames[self._known(frame)] for frame in frames]
        model = self._kinematic_model
        try:
            data = self._spare_data.pop()
        except IndexError:
            data = mujoco.MjData(model)
        count, joints = configurations.shape
        bodies = self.model.nbody - 1  # but for the world
        positions = np.empty((count, bodies, 3))
        rotations = np.empty((count, bodies, 9))
        anchors = np.empty((count, joints, 3))
        axes = np.empty((count, joints, 3))
        qpos = data.qpos.reshape(TWINS, joints)
        xpos, xmat = data.xpos[1:].reshape(TWINS, bodies, 3), data.xmat[1:].reshape(TWINS, bodies, 9)
        xanchor, xaxis = data.xanchor.reshape(TWINS, joints, 3), data.xaxis.reshape(TWINS, joints, 3)
        forward = mujoco.mj_kinematics
        for first in range(0, count, TWINS):
            at, own = slice(first, first + TWINS), slice(0, min(TWINS, count - first))
            qpos[own] = configurations[at]
            forward(model, data)
            positions[at] = xpos[own]
            rotations[at] = xmat[own]
            anchors[at] = xanchor[own]
            axes[at] = xaxis[own]
        self._spare_data.append(data)
        wanted = [body - 1 for body, _, _ in table]
        position = positions[:, wanted]
        rotation = rotations[:, wanted].reshape(count, len(wanted), 3, 3)
        for index, (_, offset, turn) in enumerate(table):
            if offset is not None:
                position[:, index] += rotation[:, index] @ offset
            if turn is not None:
                rotation[:, index] = rotation[:, index] @ turn
        return Kinematics(tuple(frames), position, rotation, anchors, axes, self.is_prismatic)

    def placed(self, T_world_base: RigidTransform) -> Robot:
        """The same robot, standing elsewhere.

        Args:
            T_world_base: pose of the robot's frame (x forward, y left, z up) in the world.
        """
        result = copy.copy(self)
        result.T_world_base = T_world_base
        result._spare_data = []
        position, quaternion_wxyz = pose_arrays(T_world_base)
        for field in ("model", "_kinematic_model"):
            model = copy.copy(getattr(self, field))
            bases = slice(1, None, self.model.nbody - 1)
            model.body_pos[bases], model.body_quat[bases] = position, quaternion_wxyz
            setattr(result, field, model)
        return result

    def placed_for(self, T_world_agent: RigidTransform) -> Robot:
        """The same robot, standing where its description wants it in an agent frame.

        Args:
            T_world_agent: the agent frame of a scene or a demonstration (x right, y forward, z up).
        """
        return self.placed(T_world_agent * self.description.base_in_agent.transform())

    def with_home(self, home: ArrayLike) -> Robot:
        """The same robot with another home posture, (n,) rad or m.

        Raises:
            ConfigurationError: if it is not finite or outside the position limits; names the joint.
        """
        posture = self.checked(np.atleast_2d(home))[0]
        for name, position, lower, upper in zip(self.joint_names, posture, self.lower, self.upper, strict=True):
            if not lower <= position <= upper:
                raise ConfigurationError(self.name, f"home of joint {name!r} is {position}", f"{lower} to {upper}")
        result = copy.copy(self)
        result.home, result._spare_data = posture, []
        return result

    def spec(self, *, lock: bool = True, meshes: bool = False, free: Collection[str] = ()) -> mujoco.MjSpec:
        """A fresh editable MuJoCo model of the robot where it stands, to compose scenes with (see `compose`)."""
        return compose(self.description, self.T_world_base, lock=lock, meshes=meshes, free=free)

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_spare_data": []}

    def __repr__(self) -> str:
        return f"<Robot {self.name!r} with {len(self.joint_names)} joints>"


def _frame_table(model: mujoco.MjModel) -> dict[str, tuple[int, Floats | None, Floats | None]]:
    """Frame name -> body, offset (3,) and rotation (3, 3) in that body; None where there is none."""
    table: dict[str, tuple[int, Floats | None, Floats | None]] = {}
    for body in range(1, model.nbody):
        table[model.body(body).name] = (body, None, None)
    for index in range(model.nsite):
        site = model.site(index)
        turn = Rotation.from_quat(site.quat, scalar_first=True).as_matrix()
        table[site.name] = (
            int(model.site_bodyid[index]),
            site.pos.copy() if site.pos.any() else None,
            None if np.array_equal(turn, np.eye(3)) else turn,
        )
    return table


def _twins(description: RobotDescription, T_world_base: RigidTransform) -> mujoco.MjModel:
    """`TWINS` times the robot's bodies and joints, all in its place: their kinematics cost one call from Python.

    Without shapes they take half the time.
    """
    import mujoco

    spec = compose(description, T_world_base)
    for body in spec.bodies:
        body.explicitinertial = True
        body.mass, body.inertia = 1.0, np.ones(3)
        body.fullinertia = np.full(6, np.nan)
    for elements in (spec.excludes, spec.pairs, spec.geoms, spec.sites):
        for element in list(elements):
            spec.delete(element)
    twins = mujoco.MjSpec()
    twins.copy_during_attach = True
    twins.memory = 1 << 16  # bytes for contacts, of which there are none
    for index in range(TWINS):
        twins.worldbody.add_frame().attach_body(spec.body(BASE), f"{index}/", "")
    return compile_spec(twins, description.path)
