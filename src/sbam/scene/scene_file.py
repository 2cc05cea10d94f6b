"""Scene file: a YAML file that says which objects stand where, and where the agent stands.

See `docs/objects_and_scenes.md` for the format with an example.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import yaml
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, UnknownNameError
from sbam.files import write_atomically
from sbam.scene.geometry import agent_heading_deg, agent_pose, default_agent_pose, upright_rotation
from sbam.scene.object_file import UNIT_TOLERANCE, Vector, check_version
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import ObjectModel
from sbam.scene.scene import Scene
from sbam.schema import convert, read_yaml

FORMAT_VERSION = 1

LARGEST_COORDINATE = 20.0
"""No arm's work lies further from the world's origin, m; larger numbers are taken for mm."""

LARGEST_DISTANCE = 10.0
"""No two objects of one arm's work are further apart, m; larger distances are taken for mm."""

Quaternion = tuple[float, float, float, float]


class _Agent(msgspec.Struct, forbid_unknown_fields=True):
    position: Vector
    heading_deg: float


class _Object(msgspec.Struct, forbid_unknown_fields=True):
    position: Vector
    model: str | None = None
    rotation_xyzw: Quaternion | None = None
    rotation_wxyz: Quaternion | None = None
    rotation_rpy_deg: Vector | None = None
    upright_yaw_deg: float | None = None


class _Scene(msgspec.Struct, forbid_unknown_fields=True):
    format_version: int
    objects: dict[str, Any]
    name: str | None = None
    robot: str | None = None
    agent: _Agent | None = None


ROTATION_FIELDS = ("rotation_xyzw", "rotation_wxyz", "rotation_rpy_deg", "upright_yaw_deg")


def load_scene(path: str | Path, library: ObjectLibrary | None = None) -> Scene:
    """Read a starting scene.

    Args:
        path: YAML file; m and degrees.
        library: where the object models come from; by default the built-in ones.

    Returns:
        The scene. Without ``agent`` in the file it holds the pose of `sbam.scene.geometry.default_agent_pose`.

    Raises:
        FileFormatError: with the place inside the file and what was expected; also for a scene in mm.
        FileVersionError: if the file was written for a later version of the format.
        UnknownNameError: if the library lacks a model; lists the known ones.
    """
    path = Path(path)
    library = library or ObjectLibrary.built_in()
    content = read_yaml(path)
    check_version(content, path, FORMAT_VERSION)
    file = convert(content, _Scene, path)
    if not file.objects:
        raise FileFormatError(path, "$.objects", "is empty", "at least one object")
    objects: dict[str, ObjectModel] = {}
    T_world_object: dict[str, RigidTransform] = {}
    for name, part in file.objects.items():
        where = f"$.objects.{name}"
        entry = convert(part, _Object, path, where)
        model_name = name if entry.model is None else entry.model
        if model_name not in library:
            raise UnknownNameError("object model", model_name, library.names, f"{path} at {where}")
        objects[name] = library[model_name]
        rotation = _rotation(entry, objects[name], path, where)
        T_world_object[name] = RigidTransform.from_components(np.array(entry.position, dtype=float), rotation)
    positions = {f"$.objects.{name}.position": pose.translation for name, pose in T_world_object.items()}
    if file.agent is not None:
        positions["$.agent.position"] = np.array(file.agent.position, dtype=float)
    _refuse_millimetres(positions, path)
    return Scene(
        name=path.stem if file.name is None else file.name,
        objects=objects,
        T_world_object=T_world_object,
        T_world_agent=default_agent_pose(objects, T_world_object)
        if file.agent is None
        else agent_pose(file.agent.position, file.agent.heading_deg),
        robot=file.robot,
        source=str(path),
    )


def save_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene so that `load_scene` gives it back; object models are referred to by name.

    Raises:
        OutputError: if the file cannot be written.
        ValueError: if the agent frame is not gravity-aligned.
    """
    content: dict[str, Any] = {"format_version": FORMAT_VERSION, "name": scene.name}
    if scene.robot is not None:
        content["robot"] = scene.robot
    content["agent"] = {
        "position": scene.T_world_agent.translation.tolist(),
        "heading_deg": agent_heading_deg(scene.T_world_agent),
    }
    content["objects"] = {name: _entry(name, scene) for name in scene.objects}
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, allow_unicode=True, width=120)
    write_atomically(path, text)


def _entry(name: str, scene: Scene) -> dict[str, Any]:
    model, pose = scene.objects[name], scene.T_world_object[name]
    reference = {} if model.name == name else {"model": model.name}
    return {
        **reference,
        "position": pose.translation.tolist(),
        "rotation_xyzw": pose.rotation.as_quat(canonical=True).tolist(),
    }


def _rotation(entry: _Object, model: ObjectModel, path: Path, where: str) -> Rotation:
    given = [field for field in ROTATION_FIELDS if getattr(entry, field) is not None]
    if len(given) != 1:
        problem = f"says its rotation {len(given)} times ({', '.join(given)})" if given else "does not say its rotation"
        raise FileFormatError(path, where, problem, f"exactly one of {', '.join(ROTATION_FIELDS)}")
    if entry.upright_yaw_deg is not None:
        return upright_rotation(model.up, entry.upright_yaw_deg)
    if entry.rotation_rpy_deg is not None:
        return Rotation.from_euler("xyz", entry.rotation_rpy_deg, degrees=True)
    quaternion = np.array(entry.rotation_xyzw or entry.rotation_wxyz, dtype=float)
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1) > UNIT_TOLERANCE:
        raise FileFormatError(path, f"{where}.{given[0]}", f"has length {length:.4g}", "a unit quaternion")
    return Rotation.from_quat(quaternion, scalar_first=entry.rotation_wxyz is not None)


def _refuse_millimetres(positions: Mapping[str, Float[np.ndarray, " 3"]], path: Path) -> None:
    """Raise where coordinates or distances are too large to be metres."""
    for where, position in positions.items():
        if (largest := float(np.abs(position).max())) > LARGEST_COORDINATE:
            raise FileFormatError(path, where, f"holds {largest:g}, which looks like mm", "metres")
    for (where, position), (other, place) in combinations(positions.items(), 2):
        if (distance := float(np.linalg.norm(position - place))) > LARGEST_DISTANCE:
            problem = f"lies {distance:.4g} m from {other}, which looks like mm"
            raise FileFormatError(path, where, problem, f"metres, and at most {LARGEST_DISTANCE:g} m between objects")
