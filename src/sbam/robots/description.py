"""Robot description: what SBAM must know of a robot beside its model file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, FileVersionError, UnknownNameError
from sbam.schema import convert, read_yaml

FORMAT_VERSION = 1
ArmName = Literal["left", "right"]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Vector = tuple[float, float, float]


class _Struct(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base: unknown keys are errors."""


class Pose(_Struct, frozen=True):
    """A pose: position in m; roll, pitch, yaw in degrees (R = Rz(yaw) Ry(pitch) Rx(roll))."""

    position: Vector = (0.0, 0.0, 0.0)
    rotation_rpy_deg: Vector = (0.0, 0.0, 0.0)

    def transform(self) -> RigidTransform:
        """The pose as a rigid transform."""
        rotation = Rotation.from_euler("xyz", self.rotation_rpy_deg, degrees=True)
        return RigidTransform.from_components(self.position, rotation)


class Part(Pose, frozen=True, kw_only=True):
    """A model file (MJCF or URDF) and where it is mounted in the robot's frame.

    Attributes:
        model: path of the file, relative to the description, or the name of a model of `robot_descriptions`.
        prefix: put before every name of the file, so that one file can be mounted twice.
    """

    model: str
    prefix: str = ""


class JointDescription(_Struct, frozen=True, kw_only=True):
    """Home position and limits of a planned joint; rad and Nm, or m and N for a prismatic joint.

    ``lower`` and ``upper`` replace the model's position limits, or give them where the model has none.
    """

    home: float = 0.0
    lower: float | None = None
    upper: float | None = None
    velocity: Positive
    acceleration: Positive
    jerk: Positive
    torque: Positive


class HandDescription(_Struct, frozen=True, kw_only=True):
    """The hand: its body, and how the TCP frame stands in it.

    A gripper has an ``opening``, a hand with a palm has ``fingers``.

    Attributes:
        body: the hand is this body of the model and all its descendants.
        approach: direction of approach towards what is grasped, out of the palm; unit vector in the TCP frame.
        max_width: widest object that fits between the fingers, m.
        opening: direction in which a gripper's fingers open, unit vector in the TCP frame.
        fingers: direction in which the stretched fingers of a hand point that presses its palm against what it holds,
            at right angles to ``approach``; unit vector in the TCP frame.
    """

    body: str
    approach: Vector
    max_width: Positive
    opening: Vector | None = None
    fingers: Vector | None = None

    @property
    def has_palm(self) -> bool:
        """Whether the palm is pressed against what is held (a power grasp) instead of two fingers."""
        return self.fingers is not None

    @property
    def across(self) -> Vector:
        """The second direction that says how the hand is turned about its approach: ``opening`` or ``fingers``."""
        direction = self.fingers or self.opening
        assert direction is not None  # one of them is there: `read_description` checks it
        return direction


class ArmDescription(_Struct, frozen=True):
    """One arm: its joints from shoulder to hand, its frames (bodies or sites of the model) and IK seeds.

    Attributes:
        joints: names of the arm's own joints (shared torso joints are listed in `RobotDescription.torso_joints`).
        tcp: tool centre point.
        shoulder: frame whose origin is the centre of the shoulder.
        elbow: frame whose origin is the elbow.
        wrist: frame whose origin is the wrist.
        length: largest distance of the TCP from the shoulder, m.
        hand: the hand.
        ik_seeds: postures of ``joints`` to start inverse kinematics from, beside the home posture.
    """

    joints: tuple[str, ...]
    tcp: str
    shoulder: str
    elbow: str
    wrist: str
    length: Positive
    hand: HandDescription
    ik_seeds: tuple[tuple[float, ...], ...] = ()


class RobotDescription(_Struct, frozen=True):
    """A robot, as its YAML file describes it (docs/robots.md).

    Attributes:
        format_version: version of this format.
        name: name of the robot.
        parts: model files and where they are mounted in the robot's frame (x forward, y left, z up).
        base_in_agent: default pose of the robot's frame in the agent frame (x right, y forward, z up).
        joints: every planned joint.
        arms: the left and the right arm.
        torso_joints: planned joints that move both arms.
        locked_joints: other joints of the model and the position they are held at; unlisted ones are held at 0.
        may_touch: pairs of bodies that are not compared in collision checks because they touch in many postures.
        without_collision: bodies whose shapes are left out of collision checks, such as boxes around a whole hand.
        human_likeness: whether the human-likeness term is on by default.
        natural_joints: whether the arms have the joints of ARMAR-6 and ARMAR-7, in their order and with their signs,
            for the joint form of human-likeness (`sbam.robots.natural_joints`).
        note: origin of the numbers.
        path: file it was read from.
        options: options that were given behind its name (`sbam.robots.options`).
    """

    format_version: int
    name: str
    parts: Annotated[tuple[Part, ...], msgspec.Meta(min_length=1)]
    base_in_agent: Pose
    joints: dict[str, JointDescription]
    arms: dict[ArmName, ArmDescription]
    torso_joints: tuple[str, ...] = ()
    locked_joints: dict[str, float] = {}
    may_touch: tuple[tuple[str, str], ...] = ()
    without_collision: tuple[str, ...] = ()
    human_likeness: bool = False
    natural_joints: bool = False
    note: str = ""
    path: str = ""
    options: dict[str, float] = {}

    def with_base_distance(self, distance: float) -> RobotDescription:
        """The same robot with its two parts mounted ``distance`` m apart, symmetric about where they were."""
        if len(self.parts) != 2:
            raise FileFormatError(
                self.path, "$.parts", f"{len(self.parts)} part(s)", "two parts to set a base distance"
            )
        if not (math.isfinite(distance) and distance > 0):
            raise FileFormatError(self.path, "base_distance", f"{distance} m", "a positive distance")
        first, second = (part.position for part in self.parts)
        old = math.dist(first, second)
        if old == 0:
            raise FileFormatError(self.path, "$.parts", "both parts are at one place", "two places")
        half = [(a - b) / 2 * distance / old for a, b in zip(first, second, strict=True)]
        middle = [(a + b) / 2 for a, b in zip(first, second, strict=True)]
        places = [tuple(m + sign * h for m, h in zip(middle, half, strict=True)) for sign in (1, -1)]
        parts = tuple(
            msgspec.structs.replace(part, position=place) for part, place in zip(self.parts, places, strict=True)
        )
        return msgspec.structs.replace(self, parts=parts)


def read_description(path: str | Path) -> RobotDescription:
    """Read a robot description.

    Args:
        path: YAML file.

    Raises:
        FileFormatError: naming the file and the place in it, if it is not YAML or not such a description.
        FileVersionError: if it was written for a later version.
        UnknownNameError: if an arm uses a joint that ``joints`` does not hold.
    """
    path = Path(path)
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise FileFormatError(path, "$", f"holds {type(content).__name__}", "a mapping, see docs/robots.md")
    if isinstance(content.get("format_version"), int) and content["format_version"] > FORMAT_VERSION:
        raise FileVersionError(path, content["format_version"], FORMAT_VERSION)
    description = convert(content, RobotDescription, path)
    description = msgspec.structs.replace(description, path=str(path), options={})
    check_description(description)
    return description


def check_description(description: RobotDescription) -> None:
    """Check what the types alone cannot say; raises as `read_description` does."""
    path, known = description.path, description.joints
    for missing in {"left", "right"} - set(description.arms):
        expected = "arms 'left' and 'right'; for two arms of one file mount it twice in $.parts"
        raise FileFormatError(path, "$.arms", f"no {missing} arm", expected)
    users: dict[str, str] = {}
    lists = [("$.torso_joints", description.torso_joints)]
    lists += [(f"$.arms.{side}.joints", arm.joints) for side, arm in description.arms.items()]
    for where, names in lists:
        for index, name in enumerate(names):
            place = f"{where}[{index}]"
            if name not in known:
                raise UnknownNameError("joint", name, known, f"{path} at {place}")
            if name in users:
                raise FileFormatError(path, place, f"joint {name!r} is already used by {users[name]}")
            users[name] = place
    for name in set(known) - set(users):
        raise FileFormatError(path, f"$.joints.{name}", "belongs to no arm and not to the torso", "locked_joints")
    for name in set(known) & set(description.locked_joints):
        raise FileFormatError(path, f"$.locked_joints.{name}", "is also a planned joint")
    for name, joint in known.items():
        if (joint.lower is None) != (joint.upper is None):
            raise FileFormatError(path, f"$.joints.{name}", "has only one of lower and upper", "both or none")
        if joint.lower is not None and joint.upper is not None and joint.lower >= joint.upper:
            problem = f"lower {joint.lower} is not below upper {joint.upper}"
            raise FileFormatError(path, f"$.joints.{name}", problem, "a range in which the joint can move")
    for side, arm in description.arms.items():
        for index, seed in enumerate(arm.ik_seeds):
            if len(seed) != len(arm.joints):
                where = f"$.arms.{side}.ik_seeds[{index}]"
                raise FileFormatError(path, where, f"{len(seed)} values", f"{len(arm.joints)}, one for each joint")
        _check_hand(arm.hand, path, f"$.arms.{side}.hand")


def _check_hand(hand: HandDescription, path: str, where: str) -> None:
    if (hand.opening is None) == (hand.fingers is None):
        problem = "neither opening nor fingers" if hand.opening is None else "both opening and fingers"
        raise FileFormatError(path, where, problem, "opening for a gripper or fingers for a hand with a palm")
    second = "fingers" if hand.has_palm else "opening"
    for field, axis in (("approach", hand.approach), (second, hand.across)):
        if abs(math.hypot(*axis) - 1) > 1e-6:
            raise FileFormatError(path, f"{where}.{field}", f"{list(axis)}", "a unit vector")
    if abs(sum(a * b for a, b in zip(hand.approach, hand.across, strict=True))) > 1e-6:
        raise FileFormatError(path, f"{where}.{second}", "not at right angles to approach", "a direction across it")
