"""Composes a robot's MuJoCo model from its description."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, UnknownNameError
from sbam.robots.description import RobotDescription
from sbam.robots.model_files import find_model, read_model
from sbam.robots.urdf import UrdfJoint, urdf_joints
from sbam.scene import ObjectModel

if TYPE_CHECKING:
    import mujoco

BASE = "robot_base"
"""Name of the body that carries all parts; its frame is the robot's frame."""

OBJECT_PREFIX = "object/"
"""Before the name of a scene's object, the name of its body."""

UNNAMED = "unnamed/"
"""MuJoCo warns of an empty prefix: a part without one is mounted with this and loses it afterwards."""


def compose(
    description: RobotDescription,
    T_world_base: RigidTransform,
    *,
    lock: bool = True,
    meshes: bool = False,
    free: Collection[str] = (),
) -> mujoco.MjSpec:
    """Mount all parts of a robot on one base body.

    Args:
        description: the robot.
        T_world_base: pose of the robot's frame in the world.
        lock: make every joint that is not planned rigid, at the position that the description gives, so that the
            model's joints are exactly the planned ones, and drop equalities. Without it they move (for physics with
            fingers). Actuators, sensors, tendons, keyframes, planes and free joints of the files are dropped in either
            case.
        meshes: keep meshes that are only drawn, where their files are found.
        free: joints that are not planned and shall move nevertheless, such as fingers, with what couples them.

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
        path = find_model(part.model, description.path, f"$.parts[{index}].model")
        child = read_model(path, meshes=meshes).spec
        child.option = spec.option  # the files' solver settings are of no account, and MuJoCo warns where they differ
        if path.suffix == ".urdf":
            _check_urdf_joints(description, part.prefix, urdf_joints(path))
        stand_on_base(child)
        position, quaternion_wxyz = pose_arrays(part.transform())
        frame = base.add_frame(pos=position, quat=quaternion_wxyz)
        spec.attach(child, prefix=part.prefix or UNNAMED, frame=frame)
    dropped: tuple[Any, ...] = (spec.actuators, spec.sensors, spec.tendons, spec.keys)
    for elements in dropped:
        for element in list(elements):
            spec.delete(element)
    _strip_prefix(spec)
    _check_joints(spec, description)
    _check_closures(spec, description)
    for name, joint in description.joints.items():
        if joint.lower is not None and joint.upper is not None:
            planned = spec.joint(name)
            planned.range, planned.limited = [joint.lower, joint.upper], mujoco.mjtLimited.mjLIMITED_TRUE
    _exclude(spec, description)
    if lock:
        _lock(spec, description, free)
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


def stand_on_base(spec: mujoco.MjSpec) -> None:
    """Remove what belongs to a scene and not to a robot: floors, and joints that let the whole robot float."""
    import mujoco

    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for geom in list(spec.geoms):
        if geom.type in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
            spec.delete(geom)


def _check_urdf_joints(description: RobotDescription, prefix: str, joints: Mapping[str, UrdfJoint]) -> None:
    """What MuJoCo would pass over: planned joints that follow others, or whose limits are none."""
    for own_name, joint in joints.items():
        name = prefix + own_name
        planned = description.joints.get(name)
        if planned is None:
            continue
        where = f"$.joints.{name}"
        if joint.mimics:
            problem = f"mimics {prefix + joint.mimics!r} in the model and cannot be planned"
            raise FileFormatError(description.path, where, problem, "it in locked_joints, or a joint that moves freely")
        if joint.kind == "continuous" or planned.lower is not None:
            continue
        lower, upper = joint.lower, joint.upper
        if lower is None or upper is None or not (math.isfinite(lower) and math.isfinite(upper)) or lower >= upper:
            problem = f"is {joint.kind} with limits {lower} to {upper} in the model"
            raise FileFormatError(description.path, where, problem, "lower and upper here, or a continuous joint")


def _check_closures(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    """Couplings of planned joints, which kinematics of open chains would silently ignore."""
    import mujoco

    planned, kinds = description.joints, mujoco.mjtEq
    for equality in spec.equalities:
        if equality.type == kinds.mjEQ_JOINT:
            names = [name for name in (equality.name1, equality.name2) if name]
            coupled = [name for name in names if name in planned]
            if coupled:
                problem = f"the model couples joint {' with '.join(map(repr, names))}"
                raise FileFormatError(description.path, f"$.joints.{coupled[0]}", problem, "joints that move freely")
        elif equality.type in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            first, second = (_joints_above(spec, name) for name in (equality.name1, equality.name2))
            closed = [name for name in planned if (name in first) != (name in second)]
            if closed:
                problem = f"the model closes a chain through it: {equality.name1!r} is held to {equality.name2!r}"
                raise FileFormatError(description.path, f"$.joints.{closed[0]}", problem, "an open chain")


def _joints_above(spec: mujoco.MjSpec, name: str) -> set[str]:
    """Names of the joints that move a body or site."""
    site = spec.site(name)
    body, joints = site.parent if site is not None else spec.body(name), set()
    while body is not None and body.parent is not None:
        joints |= {joint.name for joint in body.joints}
        body = body.parent
    return joints


def _exclude(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    names = [body.name for body in spec.bodies]
    for index, pair in enumerate(description.may_touch):
        for name in pair:
            if name not in names:
                raise UnknownNameError("body", name, names, f"{description.path} at $.may_touch[{index}]")
        spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
    for index, name in enumerate(description.without_collision):
        if name not in names:
            raise UnknownNameError("body", name, names, f"{description.path} at $.without_collision[{index}]")
        for geom in spec.body(name).geoms:
            geom.contype = geom.conaffinity = 0


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


def _lock(spec: mujoco.MjSpec, description: RobotDescription, free: Collection[str]) -> None:
    """Turn unplanned joints into fixed offsets of their bodies, but for those that are free."""
    import mujoco

    for equality in list(spec.equalities):
        if equality.type != mujoco.mjtEq.mjEQ_JOINT or not {equality.name1, equality.name2} - {""} <= set(free):
            spec.delete(equality)
    model = compile_spec(spec, description.path)
    moving = set(description.joints) | set(free)
    for joint in [joint for joint in spec.joints if joint.name not in moving]:
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
