"""The physical world: robot, objects and what they are filled with, in one MuJoCo model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sbam.robots.composition import OBJECT_PREFIX, pose_arrays
from sbam.robots.robot import Robot
from sbam.scene import ObjectModel
from sbam.tasks.materials import (
    FOOT,
    LEFT,
    OBJECT,
    OBJECT_FRICTION,
    OPEN_SHELL,
    RIGHT,
    ROLLING_FRICTION,
    SHELL,
    SUPPORT,
)
from sbam.tasks.vessel import add_shell

if TYPE_CHECKING:
    import mujoco

GUIDE = "guide/"
"""Before the name of an object that is led along a path, the name of the body that leads it."""


def add_object(spec: mujoco.MjSpec, name: str, model: ObjectModel) -> mujoco.MjsBody:
    """Add an object: furniture stands still, everything else moves freely.

    A vessel that starts empty is its shell, so that things can be in it; one that is filled keeps its solid outside.
    """
    import mujoco

    types = {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
        "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    }
    body = spec.worldbody.add_body(name=OBJECT_PREFIX + name)
    profile = model.profile
    is_open = profile is not None and profile.fill is None
    bits = OBJECT if model.movable else SUPPORT
    for index, primitive in enumerate(model.geometry):
        size = np.zeros(3)
        size[: len(primitive.size)] = primitive.size
        position, quaternion_wxyz = pose_arrays(primitive.T_object_primitive)
        geom = body.add_geom(
            type=types[primitive.kind],
            size=size,
            pos=position,
            quat=quaternion_wxyz,
            rgba=primitive.rgba if profile is None else [*primitive.rgba[:3], 0.0 if is_open else 0.3],
            contype=0 if is_open else bits[0],
            conaffinity=0 if is_open else bits[1],
            condim=3 if model.movable else 6,  # with rolling friction: a pin that lies on a table stays there
            friction=[OBJECT_FRICTION, 0.01, 0.0001 if model.movable else ROLLING_FRICTION],
            group=3 if is_open else 0,
        )
        geom.mass = model.mass if index == 0 else 0.0
    if profile is not None:
        add_shell(body, profile, model.up, OPEN_SHELL if is_open else SHELL, model.geometry[0].rgba)
    if model.movable:
        body.add_freejoint()
    return body


def set_robot_contacts(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Give every shape of the robot the contact bits of its arm, and let gravity be compensated."""
    for body in spec.bodies:
        if body.name not in robot.frame_names:
            continue
        body.gravcomp = 1.0
        moved = robot.frame_joints(body.name)
        bits = FOOT
        for side, arm in robot.arms.items():
            if moved[arm.joint_indices].any():
                bits = LEFT if side == "left" else RIGHT
        for geom in body.geoms:
            if geom.contype or geom.conaffinity:
                geom.contype, geom.conaffinity = bits
