"""State of a planning problem: what the robot's configurations do to the affordance regions.

Everything is expressed in the agent frame (x right, y forward, z up), in metres and radians.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.robots import Kinematics, Robot, point_jacobian, rotation_jacobian


@dataclass(frozen=True)
class Carrying:
    """An object rigidly held by one arm.

    Attributes:
        role: role of the action model that the object plays.
        arm: name of the arm whose tool centre point (TCP) carries it.
        T_tcp_object: pose of the object in the TCP's frame.
    """

    role: str
    arm: str
    T_tcp_object: RigidTransform


@dataclass(frozen=True)
class RegionPoint:
    """The centre of an affordance region as the problem sees it.

    Attributes:
        carrying: index of the carrying that moves it, or -1 where it stands still.
        position: m; in the object's frame if carried, else in the agent frame.
    """

    carrying: int
    position: Float[np.ndarray, " 3"]


class Workspace:
    """Robot, carried objects and regions; makes a `State` from configurations.

    Terms that look at other frames than the arms' tool centre points (TCPs) name them in ``more_frames``.
    """

    def __init__(
        self,
        robot: Robot,
        carryings: Sequence[Carrying],
        regions: Sequence[RegionPoint],
        more_frames: Sequence[str] = (),
    ) -> None:
        self.robot = robot
        self.carryings = tuple(carryings)
        self.regions = tuple(regions)
        self.arms = tuple(robot.arms)
        tcp_frames = tuple(robot.arms[arm].tcp_frame for arm in self.arms)
        self._frames = tcp_frames + tuple(frame for frame in more_frames if frame not in tcp_frames)
        self.arm_of = np.array([self.arms.index(carrying.arm) for carrying in self.carryings], dtype=int)
        self.arm_joints = np.array([robot.frame_joints(frame) for frame in tcp_frames])
        self.tcp_to_object = np.array([c.T_tcp_object.translation for c in self.carryings]).reshape(-1, 3)
        self.R_tcp_object = np.array([c.T_tcp_object.rotation.as_matrix() for c in self.carryings]).reshape(-1, 3, 3)
        self.carried = np.array([i for i, region in enumerate(self.regions) if region.carrying >= 0], dtype=int)
        self.still = np.array([region.position for region in self.regions]).reshape(-1, 3)
        carrying = np.array([self.regions[i].carrying for i in self.carried], dtype=int)
        self.region_arm = self.arm_of[carrying] if len(carrying) else np.zeros(0, int)
        offsets = np.array([self.still[i] for i in self.carried]).reshape(-1, 3)
        self.region_in_tcp = (
            np.einsum("rij,rj->ri", self.R_tcp_object[carrying], offsets) + self.tcp_to_object[carrying]
        )

        self.moving_arm = np.concatenate([self.region_arm, self.arm_of])

    def state(self, configurations: Float[np.ndarray, "keypoints joints"]) -> State:
        """The state of configurations, rad or m."""
        return State(self, configurations, self.robot.kinematics(configurations, self._frames))


@dataclass(frozen=True)
class State:
    """Configurations and what follows from them; Jacobians are computed when asked for.

    Attributes:
        workspace: robot, carried objects and regions.
        configurations: rad or m.
        kinematics: first frames are the arms' TCPs, in the order of ``workspace.arms``.
    """

    workspace: Workspace
    configurations: Float[np.ndarray, "keypoints joints"]
    kinematics: Kinematics

    @cached_property
    def region_position(self) -> Float[np.ndarray, "keypoints regions 3"]:
        """Region centres in the agent frame, m."""
        w, k = self.workspace, self.kinematics
        positions = np.broadcast_to(w.still, (len(self.configurations), *w.still.shape)).copy()
        if len(w.carried):
            rotation = k.rotation[:, w.region_arm]
            positions[:, w.carried] = k.position[:, w.region_arm] + np.matvec(rotation, w.region_in_tcp)
        return positions

    @cached_property
    def moving_jacobian(self) -> Float[np.ndarray, "keypoints points 3 joints"]:
        """Derivative of all points that move: the carried regions' centres, then the objects' origins."""
        w = self.workspace
        points = np.concatenate([self.region_position[:, w.carried], self.object_position], axis=1)
        return self.point_jacobian(points, w.moving_arm)

    @property
    def region_jacobian(self) -> Float[np.ndarray, "keypoints regions 3 joints"]:
        """Derivative of the region centres with respect to the configuration."""
        w = self.workspace
        count, joints = self.configurations.shape
        jacobian = np.zeros((count, len(w.regions), 3, joints))
        jacobian[:, w.carried] = self.moving_jacobian[:, : len(w.carried)]
        return jacobian

    @cached_property
    def object_position(self) -> Float[np.ndarray, "keypoints objects 3"]:
        """Origins of the carried objects in the agent frame, m."""
        w, k = self.workspace, self.kinematics
        return k.position[:, w.arm_of] + np.matvec(k.rotation[:, w.arm_of], w.tcp_to_object)

    @cached_property
    def object_rotation(self) -> Float[np.ndarray, "keypoints objects 3 3"]:
        """Rotation matrices of the carried objects in the agent frame."""
        w = self.workspace
        return self.kinematics.rotation[:, w.arm_of] @ w.R_tcp_object

    def object_poses(self) -> dict[str, RigidTransform]:
        """Role -> poses of the carried object, agent frame."""
        return {
            carrying.role: RigidTransform.from_components(
                self.object_position[:, i], Rotation.from_matrix(self.object_rotation[:, i])
            )
            for i, carrying in enumerate(self.workspace.carryings)
        }

    @property
    def object_jacobian(self) -> Float[np.ndarray, "keypoints objects 3 joints"]:
        """Derivative of the carried objects' origins."""
        return self.moving_jacobian[:, len(self.workspace.carried) :]

    @cached_property
    def object_rotation_jacobian(self) -> Float[np.ndarray, "keypoints objects 3 joints"]:
        """Angular velocity of the carried objects, agent frame, per joint velocity."""
        return self.angular_jacobian(self.workspace.arm_of)

    def point_jacobian(
        self, points: Float[np.ndarray, "keypoints points 3"], arm: Int[np.ndarray, " points"]
    ) -> Float[np.ndarray, "keypoints points 3 joints"]:
        """Jacobian of points that move with an arm's TCP.

        Args:
            points: m, agent frame.
            arm: index of the arm that moves each point.

        Returns:
            The Jacobian; zero for joints that do not move the arm.
        """
        return point_jacobian(self.kinematics, points, self.workspace.arm_joints[arm])

    def angular_jacobian(self, arm: Int[np.ndarray, " frames"]) -> Float[np.ndarray, "keypoints frames 3 joints"]:
        """Angular velocity of arms' TCPs per joint velocity, agent frame."""
        return rotation_jacobian(self.kinematics, self.workspace.arm_joints[arm])
