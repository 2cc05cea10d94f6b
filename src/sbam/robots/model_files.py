"""Model files of robots: where they are, and reading them even where meshes are missing."""

from __future__ import annotations

import difflib
import importlib
import importlib.util
import pkgutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sbam.errors import FileFormatError, UnknownNameError
from sbam.robots.urdf import read_urdf

if TYPE_CHECKING:
    import mujoco

MODEL_SUFFIXES = (".xml", ".mjcf", ".urdf")
MESH_SUFFIXES = (".stl", ".obj", ".msh")  # what MuJoCo reads
NEAREST_NAMES = 8
LINK_RADIUS = (0.02, 0.06)  # m: radius of a capsule that stands for a link, an eighth of its length within this
COLOR = (0.72, 0.74, 0.77, 1.0)
SHORTEST_LINK = 0.03  # m: links shorter than this get no capsule


@dataclass(frozen=True)
class ModelFile:
    """A model that was read, and what is missing in it.

    Attributes:
        spec: the model; it is the caller's to change.
        path: the file.
        missing_meshes: meshes that were not found or cannot be read, as the file names them.
        stand_ins: bodies that got capsules between their joints because their own shapes are missing.
    """

    spec: mujoco.MjSpec
    path: Path
    missing_meshes: tuple[str, ...]
    stand_ins: tuple[str, ...]


def find_model(model: str, description_path: str | Path = "", where: str = "") -> Path:
    """The file of a model.

    Args:
        model: path relative to the description, or the name of a model of the package `robot_descriptions`, such as
            ``baxter_description`` or ``aloha_mj_description``, which is downloaded when it is first used.
        description_path: file that names it.
        where: the place in that file.

    Raises:
        FileFormatError: if there is no such file, or the model cannot be downloaded.
        UnknownNameError: if `robot_descriptions` has no model of that name; lists the nearest.
    """
    if model.endswith("_description"):
        return _from_robot_descriptions(model, description_path, where)
    path = Path(description_path).parent / model
    if not path.is_file():
        expected = "a path relative to this file, or a name such as 'baxter_description'"
        raise FileFormatError(description_path, where, f"no model file {str(path)!r}", expected)
    if path.suffix not in MODEL_SUFFIXES:
        raise FileFormatError(description_path, where, f"model file {str(path)!r}", "MJCF (.xml) or URDF (.urdf)")
    return path


def _from_robot_descriptions(name: str, description_path: str | Path, where: str) -> Path:
    package = importlib.util.find_spec("robot_descriptions")
    if package is None or not package.submodule_search_locations:
        problem = f"model {name!r} needs the package robot_descriptions, which is not installed"
        raise FileFormatError(description_path, where, problem, "`pip install robot_descriptions`, or a path")
    names = [m.name for m in pkgutil.iter_modules(package.submodule_search_locations) if "_description" in m.name]
    if name not in names:
        near = difflib.get_close_matches(name, names, NEAREST_NAMES, 0.3)
        raise UnknownNameError("robot_descriptions model", name, near, f"{description_path} at {where}; nearest names")
    try:
        module = importlib.import_module(f"robot_descriptions.{name}")
    except Exception as error:  # it clones a repository when imported, which fails in many ways
        problem = f"robot_descriptions cannot download {name!r}: {type(error).__name__}: {str(error).strip()}"
        raise FileFormatError(description_path, where, problem, "a connection to its repository, or a path") from error
    for attribute in ("MJCF_PATH", "URDF_PATH"):
        if hasattr(module, attribute):
            return Path(getattr(module, attribute))
    raise FileFormatError(description_path, where, f"model {name!r} is xacro", "a file expanded to URDF")


def read_model(path: Path, *, meshes: bool = False) -> ModelFile:
    """Read a model, whatever of its meshes is there.

    A link whose collision shapes are meshes gets capsules between its joints instead; so does one whose shapes are
    missing.

    Args:
        path: MJCF or URDF.
        meshes: keep meshes that are only drawn.

    Raises:
        FileFormatError: if it cannot be used.
    """
    import mujoco

    missing: list[str] = []

    def find(name: str) -> Path | None:
        file = _mesh_file(path, name)
        if file is None:
            missing.append(name)
        return file

    try:
        if path.suffix == ".urdf":
            spec = mujoco.MjSpec.from_string(read_urdf(path, find))
        else:
            spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise FileFormatError(path, "", f"MuJoCo cannot read it: {error}", "an MJCF or URDF model") from error
    if path.suffix != ".urdf":
        missing += _drop_missing_meshes(spec, path)
    stand_ins = _replace_mesh_collisions(spec) if path.suffix == ".urdf" or missing else []
    if not meshes:
        _drop_drawn_meshes(spec)
    return ModelFile(spec, path, tuple(dict.fromkeys(missing)), tuple(stand_ins))


def _mesh_file(path: Path, name: str) -> Path | None:
    """A mesh beside a URDF or, for ``package://name/...``, in a folder of that name above it; None if unreadable."""
    relative = name.removeprefix("file://")
    if name.startswith("package://"):
        relative = name.removeprefix("package://").lstrip("/")
        package, _, inside = relative.partition("/")
        candidates = [folder / relative for folder in path.resolve().parents]
        candidates += [folder / inside for folder in path.resolve().parents if folder.name == package]
    else:
        candidates = [path.resolve().parent / relative]
    found = next((file for file in candidates if file.is_file()), None)
    return found if found is not None and found.suffix.lower() in MESH_SUFFIXES else None


def _drop_missing_meshes(spec: mujoco.MjSpec, path: Path) -> list[str]:
    """Remove meshes of an MJCF whose files are not there, and the shapes that use them."""
    folder = path.resolve().parent / spec.meshdir
    gone = {mesh.name: mesh.file for mesh in spec.meshes if mesh.file and not (folder / mesh.file).is_file()}
    for geom in list(spec.geoms):
        if geom.meshname in gone:
            spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name in gone:
            spec.delete(mesh)
    return list(gone.values())


def _replace_mesh_collisions(spec: mujoco.MjSpec) -> list[str]:
    """Capsules between the joints of every link that has no primitive to collide with; names of these links."""
    import mujoco

    replaced = []
    solid = {body.name for body in spec.bodies if body.geoms or body.joints}  # others are frames, such as a TCP
    for body in list(spec.bodies)[1:]:
        touching = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        if any(geom.type != mujoco.mjtGeom.mjGEOM_MESH for geom in touching):
            continue
        for geom in touching:
            spec.delete(geom)
        made = False
        for child in body.bodies:
            length = float(np.linalg.norm(child.pos))
            if length < SHORTEST_LINK or child.name not in solid:
                continue
            radius = min(max(length / 8, LINK_RADIUS[0]), LINK_RADIUS[1])
            inset = np.array(child.pos) * min(radius / length, 0.4)
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=[*inset, *(child.pos - inset)],
                size=[radius, 0, 0],
                mass=0.0,
                rgba=COLOR,
            )
            made = True
        if made:
            replaced.append(body.name)
    return replaced


def _drop_drawn_meshes(spec: mujoco.MjSpec) -> None:
    """Remove meshes that touch nothing: they cost time to load and only matter in pictures."""
    import mujoco

    used = set()
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
            if geom.contype or geom.conaffinity:
                used.add(geom.meshname)
            else:
                spec.delete(geom)
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
