"""The joint form of human-likeness, for arms with the joints of ARMAR-6 and ARMAR-7.

Reconstruction of the paper's SOA_q (section III-F) in joint space: the distance of the arm's first five joints from
those that put a person's natural posture (`sbam.robots.human_likeness`) into the robot's joints. The clavicle rests,
the first shoulder joint lifts the upper arm, the second spreads it, the third keeps a turn of 45 degrees, the elbow
takes the forearm's elevation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.errors import FileFormatError
from sbam.robots.human_likeness import PERSON_ARM_LENGTH, natural_angles
from sbam.robots.jacobian import point_jacobian
from sbam.robots.robot import Arm, Kinematics, Robot

Floats = NDArray[np.float64]

WEIGHTS = np.array([0.5, 1.0, 2.0, 0.5, 0.5])
"""Of clavicle, lift, spread, turn and elbow."""

TURN = -np.pi / 4
LEAST_SPREAD = -0.1  # rad


def has_natural_joints(robot: Robot) -> bool:
    """Whether a robot's description says that its arms have the joints that this form is about."""
    return robot.description.natural_joints


class NaturalJoints:
    """SOA_q = |W (q* - q)| over the first five joints of each arm.

    Attributes:
        frames: the frames that a `Kinematics` must hold.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare the term.

        Args:
            robot: the robot, standing where it acts.

        Raises:
            FileFormatError: if its arms do not have such joints.
        """
        if not has_natural_joints(robot):
            problem = "is not set: the joint form of human-likeness is for arms with ARMAR's joints"
            raise FileFormatError(robot.description.path, "$.natural_joints", problem, "true, or the form 'directions'")
        self._robot = robot
        self._R_agent_world = robot.T_world_agent.rotation.as_matrix().T
        self.frames = tuple(frame for arm in robot.arms.values() for frame in (arm.shoulder_frame, arm.tcp_frame))

    def value(self, kinematics: Kinematics, configurations: Floats) -> Floats:
        """(B, A) SOA_q of each arm."""
        residual = self.residual(kinematics, configurations)
        return np.linalg.norm(residual.reshape(len(residual), len(self._robot.arms), -1), axis=2)

    def residual(self, kinematics: Kinematics, configurations: Floats) -> Floats:
        """(B, 5 A) W (q - q*), arm by arm; differences of joints that turn endlessly are at most half a turn."""
        residuals = []
        for arm in self._robot.arms.values():
            joints = arm.joint_indices[:5]
            off = configurations[:, joints] - self._natural(kinematics, arm)[0]
            off = np.where(self._robot.is_continuous[joints], (off + np.pi) % (2 * np.pi) - np.pi, off)
            residuals.append(WEIGHTS * off)
        return np.concatenate(residuals, axis=1)

    def jacobian(self, kinematics: Kinematics) -> Floats:
        """(B, 5 A, n) derivative of the residual by the joints."""
        count = len(self._robot.joint_names)
        jacobians = []
        for arm in self._robot.arms.values():
            _, slopes = self._natural(kinematics, arm)
            hand, shoulder = (
                self._R_agent_world
                @ point_jacobian(
                    kinematics, kinematics.position[:, kinematics.frames.index(frame)], self._robot.frame_joints(frame)
                )
                for frame in (arm.tcp_frame, arm.shoulder_frame)
            )
            own = np.eye(count)[arm.joint_indices[:5]]
            jacobians.append(WEIGHTS[:, None] * (own - slopes @ (hand - shoulder)))
        return np.concatenate(jacobians, axis=1)

    def _natural(self, kinematics: Kinematics, arm: Arm) -> tuple[Floats, Floats]:
        """q* (B, 5) and its derivative by the vector from shoulder to hand (B, 5, 3), agent axes."""
        side = -1.0 if arm.name == "left" else 1.0
        mirror, scale = np.array([side, 1.0, 1.0]), PERSON_ARM_LENGTH / arm.length
        ends = [kinematics.frames.index(frame) for frame in (arm.shoulder_frame, arm.tcp_frame)]
        vector = (kinematics.position[:, ends[1]] - kinematics.position[:, ends[0]]) @ self._R_agent_world.T
        angles, slopes = natural_angles(vector * mirror * scale)
        slopes = slopes * mirror * scale
        lift, yaw, bend = angles[:, 0, 0], angles[:, 0, 1], angles[:, 1, 0]
        spread, by_lift, by_yaw = _spread(lift, yaw)
        zero = np.zeros_like(lift)
        joints = np.stack([zero, side * lift, spread, zero + side * TURN, bend], axis=1)
        derivative = np.zeros((len(lift), 5, 3))
        derivative[:, 1] = side * slopes[:, 0, 0]
        derivative[:, 2] = by_lift[:, None] * slopes[:, 0, 0] + by_yaw[:, None] * slopes[:, 0, 1]
        derivative[:, 4] = slopes[:, 1, 0]
        return joints, derivative


def _spread(lift: Floats, yaw: Floats) -> tuple[Floats, Floats, Floats]:
    """atan2(u'_x, -u'_z) of u' = Rx(-lift) Rz(-yaw) Rx(lift) (-e_z), not below -0.1; derivatives by lift and yaw."""
    aside = np.sin(yaw) * np.sin(lift)
    down = np.cos(yaw) * np.sin(lift) ** 2 + np.cos(lift) ** 2
    square = np.maximum(aside**2 + down**2, 1e-12)
    aside_by = np.sin(yaw) * np.cos(lift), np.cos(yaw) * np.sin(lift)
    down_by = (np.cos(yaw) - 1.0) * np.sin(2.0 * lift), -np.sin(yaw) * np.sin(lift) ** 2
    spread = np.arctan2(aside, down)
    free = spread > LEAST_SPREAD
    slopes = [free * (a * down - d * aside) / square for a, d in zip(aside_by, down_by, strict=True)]
    return np.maximum(spread, LEAST_SPREAD), slopes[0], slopes[1]
