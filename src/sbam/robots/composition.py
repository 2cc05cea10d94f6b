"""Composes a robot's MuJoCo model from its description."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, UnknownNameError
from sbam.robots.description import RobotDescription
from sbam.robots.urdf import read_urdf
from sbam.scene import ObjectModel

if TYPE_CHECKING:
    import mujoco

BASE = "base"
"""Name of the body that carries all parts; its frame is the robot's frame."""

OBJECT_PREFIX = "object/"
"""Before the name of a scene's object, the name of its body."""

UNNAMED = "unnamed/"
"""MuJoCo warns of an empty prefix: a part without one is mounted with this and loses it afterwards."""


def compose(description: RobotDescription, T_world_base: RigidTransform, *, lock: bool = True) -> mujoco.MjSpec:
    """Mount all parts of a robot on one base body.

    Args:
        description: the robot.
        T_world_base: pose of the robot's frame in the world.
        lock: make every joint that is not planned rigid, at the position that the description gives, so that the
            model's joints are exactly the planned ones, and drop equalities. Without it they move (for physics with
            fingers). Actuators, sensors, tendons and keyframes of the files are dropped in either case.

    Raises:
        FileFormatError: if a model file cannot be used.
        UnknownNameError: if the description names a joint that the model does not have.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.modelname = description.name
    position, quaternion_wxyz = pose_arrays(T_world_base)
    base = spec.worldbody.add_body(name=BASE, pos=position, quat=quaternion_wxyz)
    for index, part in enumerate(description.parts):
        path = Path(description.path).parent / part.model
        child = _read_model(path, description.path, index)
        position, quaternion_wxyz = pose_arrays(part.transform())
        frame = base.add_frame(pos=position, quat=quaternion_wxyz)
        spec.attach(child, prefix=part.prefix or UNNAMED, frame=frame)
    dropped: tuple[Any, ...] = (spec.actuators, spec.sensors, spec.tendons, spec.keys)
    for elements in dropped:
        for element in list(elements):
            spec.delete(element)
    _strip_prefix(spec)
    _check_joints(spec, description)
    if lock:
        _lock(spec, description)
    return spec


def add_objects(spec: mujoco.MjSpec, objects: Mapping[str, ObjectModel]) -> None:
    """Add a scene's objects to a robot's model: bodies (mocap) that are set from outside, with colours.

    Args:
        spec: a robot's model, see `sbam.robots.Robot.spec`; it is changed.
        objects: object name in the scene -> its model. The bodies are called `OBJECT_PREFIX` + name.
    """
    import mujoco

    types = {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
        "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    }
    for name, model in objects.items():
        body = spec.worldbody.add_body(name=OBJECT_PREFIX + name, mocap=True)
        for primitive in model.geometry:
            size = np.zeros(3)
            size[: len(primitive.size)] = primitive.size
            position, quaternion_wxyz = pose_arrays(primitive.T_object_primitive)
            body.add_geom(
                type=types[primitive.kind], size=size, pos=position, quat=quaternion_wxyz, rgba=primitive.rgba
            )


def pose_arrays(T: RigidTransform) -> tuple[np.ndarray, np.ndarray]:
    """Position (3,) and quaternion wxyz (4,), as MuJoCo takes them."""
    return T.translation, T.rotation.as_quat(scalar_first=True)


def compile_spec(spec: mujoco.MjSpec, path: str) -> mujoco.MjModel:
    """Compile a spec; MuJoCo's complaint becomes a `FileFormatError` that names the description."""
    try:
        return spec.compile()
    except ValueError as error:
        raise FileFormatError(path, "$.parts", f"MuJoCo cannot compile the model: {error}") from error


def _read_model(path: Path, description_path: str, index: int) -> mujoco.MjSpec:
    import mujoco

    where = f"$.parts[{index}].model"
    if not path.is_file():
        raise FileFormatError(description_path, where, f"no model file {str(path)!r}", "a path relative to this file")
    try:
        if path.suffix == ".urdf":
            return mujoco.MjSpec.from_string(read_urdf(path))
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise FileFormatError(path, "", f"MuJoCo cannot read it: {error}", "an MJCF or URDF model") from error


def _check_joints(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    import mujoco

    names = [joint.name for joint in spec.joints]
    for field in ("joints", "locked_joints"):
        for name in getattr(description, field):
            if name not in names:
                raise UnknownNameError("joint", name, names, f"{description.path} at $.{field}")
    for joint in spec.joints:
        if joint.type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            problem = f"joint {joint.name!r} is neither hinge nor slide"
            raise FileFormatError(description.path, "$.parts", problem, "joints with one degree of freedom")


def _strip_prefix(spec: mujoco.MjSpec) -> None:
    named: tuple[tuple[Any, tuple[str, ...]], ...] = (
        (spec.bodies, ("name",)),
        (spec.joints, ("name",)),
        (spec.sites, ("name",)),
        (spec.geoms, ("name",)),
        (spec.excludes, ("bodyname1", "bodyname2")),
        (spec.pairs, ("geomname1", "geomname2")),
        (spec.equalities, ("name1", "name2")),
    )
    for elements, fields in named:
        for element in elements:
            for field in fields:
                name = getattr(element, field)
                if name.startswith(UNNAMED):
                    setattr(element, field, name.removeprefix(UNNAMED))


def _lock(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    """Turn unplanned joints into fixed offsets of their bodies."""
    import mujoco

    for equality in list(spec.equalities):
        spec.delete(equality)
    model = compile_spec(spec, description.path)
    for joint in [joint for joint in spec.joints if joint.name not in description.joints]:
        body = joint.parent
        compiled = model.joint(joint.name)
        offset = description.locked_joints.get(joint.name, 0.0) - float(model.qpos0[compiled.qposadr[0]])
        if offset:
            if len(body.joints) > 1:
                problem = f"joint {joint.name!r} shares body {body.name!r} with other joints"
                raise FileFormatError(description.path, "$.locked_joints", problem, "a locked joint alone in its body")
            at = model.body(compiled.bodyid[0])
            T_parent_body = RigidTransform.from_components(at.pos, Rotation.from_quat(at.quat, scalar_first=True))
            if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
                motion = RigidTransform.from_translation(compiled.axis * offset)
            else:
                anchor = RigidTransform.from_translation(compiled.pos)
                turn = RigidTransform.from_rotation(Rotation.from_rotvec(compiled.axis * offset))
                motion = anchor * turn * anchor.inv()
            body.pos, body.quat = pose_arrays(T_parent_body * motion)
            body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
            body.set_frame(body.parent.add_frame())  # the compiled pose holds the old frames already
        spec.delete(joint)
