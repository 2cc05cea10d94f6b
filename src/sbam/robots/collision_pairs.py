"""Which shapes are compared with which."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from sbam.errors import UnknownNameError
from sbam.robots.collision_shapes import CollisionShapes
from sbam.robots.description import ArmName
from sbam.robots.robot import Robot
from sbam.scene import ObjectModel

PAIR_CLASSES = ("arm-arm", "self", "arm-support", "arm-object", "object-object", "palm-object")
"""Names of the pair classes, see `sbam.robots.collision.CollisionModel`."""


def hand_bodies(robot: Robot, side: ArmName) -> tuple[str, ...]:
    """Bodies of a hand: the one that the description names, and its descendants."""
    if side not in robot.arms:
        raise UnknownNameError("arm", side, robot.arms, f"robot {robot.name!r}")
    model = robot.model
    hand = {model.body(robot.arms[side].hand.body).id}
    for body in range(model.nbody):  # parents come before their children
        if model.body_parentid[body] in hand:
            hand.add(body)
    return tuple(model.body(body).name for body in sorted(hand))


def gripping_bodies(robot: Robot, side: ArmName) -> tuple[str, ...]:
    """Bodies that may touch what the hand holds: its fingers, or the whole hand if it has none."""
    bodies = hand_bodies(robot, side)
    return bodies[1:] or bodies


def collision_pairs(
    robot: Robot, shapes: CollisionShapes, objects: Mapping[str, ObjectModel], allowed: Collection[tuple[str, str]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of shapes to compare, (P, 2), and the index of each pair's class in `PAIR_CLASSES`, (P,)."""
    for name in {name for pair in allowed for name in pair} - set(shapes.owners):
        raise UnknownNameError("robot body or object", name, shapes.owners, "allowed contacts")
    skipped = {frozenset(pair) for pair in allowed} | _excluded_by_model(robot)
    parts = {name: _part(robot, name) for name in shapes.robot_bodies}
    parts |= {name: "object" if model.movable else "support" for name, model in objects.items()}
    kind = np.full((len(shapes.owners),) * 2, -1)
    for i, first in enumerate(shapes.owners):
        for j, second in enumerate(shapes.owners[:i]):
            if frozenset((first, second)) not in skipped:
                name = _pair_class(robot, {first: parts[first], second: parts[second]})
                kind[i, j] = kind[j, i] = PAIR_CLASSES.index(name) if name else -1
    first, second = np.triu_indices(len(shapes.owner), 1)
    classes = kind[shapes.owner[first], shapes.owner[second]]
    counts = classes >= 0
    return np.column_stack([first[counts], second[counts]]), classes[counts]


def _part(robot: Robot, body: str) -> str:
    """To which part a body belongs: ``left``, ``right``, ``torso`` (moves, with both arms) or ``foot`` (stands)."""
    joints = robot.frame_joints(body)
    for side, arm in robot.arms.items():
        if joints[arm.joint_indices].any():
            return side
    return "torso" if joints.any() else "foot"


def _pair_class(robot: Robot, parts: Mapping[str, str]) -> str | None:
    kinds = set(parts.values())
    if kinds == {"left", "right"}:
        return "arm-arm"
    if kinds <= {"object"}:
        return "object-object"
    moving = kinds & {"left", "right", "torso"}
    if moving and "support" in kinds:
        return "arm-support"
    if moving and "object" in kinds:
        return "arm-object"
    if kinds & {"left", "right"} and not kinds & {"object", "support"}:
        first, second = (_weld(robot, body) for body in parts)
        parents = [_weld(robot, robot.model.body(robot.model.body_parentid[w]).name) for w in (first, second)]
        return None if first == second or first == parents[1] or second == parents[0] else "self"
    return None


def _weld(robot: Robot, body: str) -> int:
    """Topmost body that moves rigidly with this one."""
    return int(robot.model.body_weldid[robot.model.body(body).id])


def _excluded_by_model(robot: Robot) -> set[frozenset[str]]:
    """Pairs of bodies that the model file excludes from contact."""
    model = robot.model
    pairs = [divmod(int(signature), 1 << 16) for signature in model.exclude_signature]
    return {frozenset(model.body(body).name for body in pair) for pair in pairs}
