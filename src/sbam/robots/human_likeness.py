"""Human-likeness: how far an arm is from the posture that a person would naturally take for the same hand position.

Reconstruction of the paper's term SOA_q (section III-F), whose defining text was not available to us: the natural
posture is the linear map of Soechting and Flanders (1989) from the hand's position to the orientation of upper arm
and forearm. It asks nothing of the robot but where shoulder, elbow, wrist and hand are; the hand's position is scaled
by the ratio of the arms' lengths.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sbam.errors import FileFormatError
from sbam.robots.jacobian import point_jacobian
from sbam.robots.robot import Arm, Kinematics, Robot

Floats = NDArray[np.float64]

PERSON_SWIVEL_DEG = {"left": 36.0, "right": -49.0}
"""Swivel angles of people who pour and roll, measured; see `NaturalDirections.swivel`."""

PERSON_ARM_LENGTH = 0.645
"""Shoulder to grasping hand of a person of average stature with a straight arm, m."""

# Rows: elevation and yaw of the upper arm, elevation and yaw of the forearm, in degrees, for the right arm.
# Columns: constant; distance R of the hand from the shoulder, cm; its azimuth chi and elevation psi, degrees.
NATURAL_POSTURE = np.array(
    [
        [-4.0, 1.10, 0.00, 0.90],
        [13.2, 0.00, 0.86, 0.11],
        [39.4, 0.54, 0.00, -1.06],
        [-10.0, 0.00, 1.08, -0.35],
    ]
)


def natural_angles(hand: Floats) -> tuple[Floats, Floats]:
    """Elevation and yaw of a person's right upper arm and forearm, and how they change with the hand.

    Args:
        hand: (B, 3) from the shoulder to the hand of a person; x right, y forward, z up; m.

    Returns:
        Angles (B, 2, 2) of upper arm and forearm, rad. Their derivatives (B, 2, 2, 3) by ``hand``, rad/m.
    """
    x, y, z = 100.0 * hand.T
    level = np.maximum(np.hypot(x, y), 1e-6)
    distance = np.maximum(np.hypot(level, z), 1e-6)
    degrees = np.rad2deg(1.0)
    zero = np.zeros_like(x)
    features = np.stack([zero + 1, distance, np.arctan2(x, y) * degrees, np.arctan2(z, level) * degrees], axis=1)
    slopes = np.empty((len(hand), 4, 3))
    slopes[:, 0] = 0.0
    slopes[:, 1] = np.stack([x, y, z], axis=1) / distance[:, None]
    slopes[:, 2] = np.stack([y, -x, zero], axis=1) * (degrees / level**2)[:, None]
    slopes[:, 3] = np.stack([-x * z / level, -y * z / level, level], axis=1) * (degrees / distance**2)[:, None]
    angles = np.deg2rad(features @ NATURAL_POSTURE.T).reshape(-1, 2, 2)
    return angles, np.deg2rad(100.0 * (NATURAL_POSTURE @ slopes)).reshape(-1, 2, 2, 3)


def natural_directions(hand: Floats) -> tuple[Floats, Floats]:
    """Natural directions of a person's right upper arm and forearm, and how they change with the hand.

    Args:
        hand: (B, 3) from the shoulder to the hand of a person; x right, y forward, z up; m.

    Returns:
        Unit vectors (B, 2, 3): shoulder to elbow, elbow to wrist. Their derivatives (B, 2, 3, 3) by ``hand``, 1/m.
    """
    angles, angle_slopes = natural_angles(hand)
    sine, cosine = np.sin(angles), np.cos(angles)
    rising, yaw_sine = sine[..., 0], sine[..., 1]
    upright, yaw_cosine = cosine[..., 0], cosine[..., 1]
    down = np.array([-1.0, 1.0])  # an upper arm of elevation 0 hangs down, a forearm of elevation 0 points up
    direction = np.stack([yaw_sine * rising, yaw_cosine * rising, down * upright], axis=-1)
    by_elevation = np.stack([yaw_sine * upright, yaw_cosine * upright, -down * rising], axis=-1)
    by_yaw = np.stack([yaw_cosine * rising, -yaw_sine * rising, np.zeros_like(rising)], axis=-1)
    derivative = by_elevation[..., None] * angle_slopes[:, :, None, 0] + by_yaw[..., None] * angle_slopes[:, :, None, 1]
    return direction, derivative


class NaturalDirections:
    """The term t_h = sum over arms of (1 - u_robot . u) + mu (1 - f_robot . f).

    u and f are the natural directions of upper arm and forearm. With the residual r of `residual` it is r . r / 2, so
    that Gauss-Newton solvers can take it as it is.

    Attributes:
        frames: the frames that a `Kinematics` must hold for this term.
    """

    def __init__(self, robot: Robot, forearm_weight: float = 1.0) -> None:
        """Prepare the term.

        Args:
            robot: the robot, standing where it acts; its agent frame says what is right, forward and up.
            forearm_weight: mu.

        Raises:
            FileFormatError: if two of an arm's shoulder, elbow and wrist coincide.
        """
        self._robot = robot
        self._weights = np.sqrt([1.0, forearm_weight])
        self._R_agent_world = robot.T_world_agent.rotation.as_matrix().T
        self._chains = [(arm, _chain(arm)) for arm in robot.arms.values()]
        self.frames = tuple(dict.fromkeys(frame for _, chain in self._chains for frame in chain))
        home = robot.kinematics(robot.home[None], self.frames)
        for arm, _ in self._chains:
            lengths = np.linalg.norm(np.diff(self._points(home, arm)[0, :3], axis=0), axis=1)
            for length, field in zip(lengths, ("elbow", "wrist"), strict=True):
                if length < 1e-3:
                    where = f"$.arms.{arm.name}.{field}"
                    problem = "is where the frame before it in the arm is"
                    raise FileFormatError(robot.description.path, where, problem, "shoulder, elbow and wrist apart")

    def residual(self, kinematics: Kinematics) -> Floats:
        """(B, 6 A) for A arms: u_robot - u, then sqrt(mu) (f_robot - f), arm by arm, in agent axes."""
        return self._evaluate(kinematics, with_jacobian=False)[0]

    def jacobian(self, kinematics: Kinematics) -> Floats:
        """(B, 6 A, n) derivative of the residual by the joints."""
        jacobian = self._evaluate(kinematics, with_jacobian=True)[1]
        assert jacobian is not None
        return jacobian

    def value(self, kinematics: Kinematics) -> Floats:
        """(B,) t_h without its weight lambda."""
        return 0.5 * np.square(self.residual(kinematics)).sum(axis=1)

    def gradient(self, kinematics: Kinematics) -> Floats:
        """(B, n) derivative of `value` by the joints."""
        residual, jacobian = self._evaluate(kinematics, with_jacobian=True)
        assert jacobian is not None
        return np.einsum("br,brn->bn", residual, jacobian)

    def deviation(self, kinematics: Kinematics) -> Floats:
        """(B, A, 2) angles between the robot's and the natural direction of upper arm and forearm, degrees.

        People themselves are 15 to 32 degrees off the map's upper arm when they pour and roll.
        """
        angles = []
        for arm, _ in self._chains:
            actual, natural = self._directions(kinematics, arm)[:2]
            sine = np.linalg.norm(np.cross(actual, natural), axis=-1)
            angles.append(np.rad2deg(np.arctan2(sine, np.einsum("bij,bij->bi", actual, natural))))
        return np.stack(angles, axis=1)

    def swivel(self, kinematics: Kinematics) -> Floats:
        """(B, A) angle by which the elbow is turned about the line from shoulder to wrist, degrees.

        0 where it hangs straight down; positive to the agent's left where the arm points forward: outwards for the left
        arm, inwards for the right one. People have +36 (left) and -49 (right) when they pour and roll.
        """
        angles = []
        for arm, _ in self._chains:
            shoulder, elbow, wrist, _ = self._points(kinematics, arm).swapaxes(0, 1)
            axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder, axis=1, keepdims=True)
            upper, down = elbow - shoulder, np.broadcast_to([0.0, 0.0, -1.0], axis.shape)
            sine = np.einsum("bi,bi->b", axis, np.cross(down, upper))
            cosine = np.einsum("bi,bi->b", upper, down) - np.einsum("bi,bi->b", upper, axis) * (axis * down).sum(axis=1)
            angles.append(np.rad2deg(np.arctan2(sine, cosine)))
        return np.stack(angles, axis=1)

    def _evaluate(self, kinematics: Kinematics, *, with_jacobian: bool) -> tuple[Floats, Floats | None]:
        residuals, jacobians = [], []
        count = len(kinematics.position)
        for arm, chain in self._chains:
            actual, natural, derivative, lengths = self._directions(kinematics, arm)
            residuals.append((self._weights[:, None] * (actual - natural)).reshape(count, 6))
            if not with_jacobian:
                continue
            shoulder, elbow, wrist, tcp = (
                self._R_agent_world
                @ point_jacobian(
                    kinematics, kinematics.position[:, kinematics.frames.index(frame)], self._robot.frame_joints(frame)
                )
                for frame in chain
            )
            segments = np.stack([elbow - shoulder, wrist - elbow], axis=1) / lengths[..., None, None]
            along = np.einsum("bsi,bsin->bsn", actual, segments)
            turning = segments - actual[..., None] * along[:, :, None]
            following = derivative @ (tcp - shoulder)[:, None]
            jacobians.append((self._weights[:, None, None] * (turning - following)).reshape(count, 6, -1))
        residual = np.concatenate(residuals, axis=1)
        return residual, np.concatenate(jacobians, axis=1) if with_jacobian else None

    def _directions(self, kinematics: Kinematics, arm: Arm) -> tuple[Floats, Floats, Floats, Floats]:
        """Robot's and natural directions (B, 2, 3), derivative of the latter by the hand, lengths (B, 2)."""
        shoulder, elbow, wrist, tcp = self._points(kinematics, arm).swapaxes(0, 1)
        segments = np.stack([elbow - shoulder, wrist - elbow], axis=1)
        lengths = np.linalg.norm(segments, axis=2)
        scale = PERSON_ARM_LENGTH / arm.length
        mirror = np.array([-1.0 if arm.name == "left" else 1.0, 1.0, 1.0])
        natural, derivative = natural_directions((tcp - shoulder) * mirror * scale)
        return segments / lengths[..., None], natural * mirror, mirror[:, None] * derivative * mirror * scale, lengths

    def _points(self, kinematics: Kinematics, arm: Arm) -> Floats:
        """Shoulder, elbow, wrist and TCP in agent axes, (B, 4, 3)."""
        indices = [kinematics.frames.index(frame) for frame in _chain(arm)]
        return kinematics.position[:, indices] @ self._R_agent_world.T


def _chain(arm: Arm) -> tuple[str, str, str, str]:
    return arm.shoulder_frame, arm.elbow_frame, arm.wrist_frame, arm.tcp_frame
