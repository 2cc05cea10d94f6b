"""Object file: one YAML file describes one object model.

See `docs/objects_and_scenes.md` for the format with an example.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import msgspec
import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, FileVersionError
from sbam.scene.affordance_region import AffordanceRegion
from sbam.scene.object_model import GraspRegion, ObjectModel, Primitive, VesselProfile
from sbam.schema import convert, read_yaml

FORMAT_VERSION = 1

Part = TypeVar("Part")
Vector = tuple[float, float, float]
Color = Annotated[list[float], msgspec.Meta(min_length=3, max_length=4)]

UNIT_TOLERANCE = 1e-3
"""How far the length of a unit vector in a file may be off 1: three written digits."""


class _Struct(msgspec.Struct, forbid_unknown_fields=True):
    """Base of all parts of the file."""


class _Region(_Struct):
    affordance: str
    center: Vector
    half_axes: tuple[float, float]
    normal: Vector


class _Box(_Struct, tag_field="kind", tag="box"):
    size: Vector
    center: Vector = (0.0, 0.0, 0.0)
    rotation_rpy_deg: Vector = (0.0, 0.0, 0.0)
    rgba: Color = msgspec.field(default_factory=lambda: [0.7, 0.7, 0.7])


class _Cylinder(_Struct, tag_field="kind", tag="cylinder"):
    radius: float
    length: float
    axis: Vector
    center: Vector = (0.0, 0.0, 0.0)
    rgba: Color = msgspec.field(default_factory=lambda: [0.7, 0.7, 0.7])


class _Capsule(_Struct, tag_field="kind", tag="capsule"):
    radius: float
    length: float
    axis: Vector
    center: Vector = (0.0, 0.0, 0.0)
    rgba: Color = msgspec.field(default_factory=lambda: [0.7, 0.7, 0.7])


class _Sphere(_Struct, tag_field="kind", tag="sphere"):
    radius: float
    center: Vector = (0.0, 0.0, 0.0)
    rgba: Color = msgspec.field(default_factory=lambda: [0.7, 0.7, 0.7])


class _Grasp(_Struct):
    name: str
    kind: Literal["around", "across"]
    center: Vector
    axis: Vector
    half_length: float
    width: float
    faces: int = 0


class _Profile(_Struct):
    inner: Annotated[list[tuple[float, float]], msgspec.Meta(min_length=2)]
    wall: float
    fill: float | None = None


class _Object(_Struct):
    format_version: int
    name: str
    up: Vector
    movable: bool
    mass: float
    affordance_regions: list[_Region]
    geometry: list[_Box | _Cylinder | _Capsule | _Sphere]
    grasp_regions: list[_Grasp] = []
    description: str = ""
    profile: _Profile | None = None


def load_object(path: str | Path) -> ObjectModel:
    """Read one object model.

    Args:
        path: YAML file; lengths in m, mass in kg.

    Raises:
        FileFormatError: with the place inside the file, what was expected and the valid names.
        FileVersionError: if the file was written for a later version of the format.
    """
    path = Path(path)
    content = read_yaml(path)
    check_version(content, path, FORMAT_VERSION)
    file = convert(content, _Object, path)
    check = _Checker(path)
    check.name("$.name", file.name)
    check.positive("$.mass", file.mass)
    check.unique("affordance_regions", "affordance", [region.affordance for region in file.affordance_regions])
    check.unique("grasp_regions", "name", [grasp.name for grasp in file.grasp_regions])
    return ObjectModel(
        name=file.name,
        affordance_regions=tuple(
            AffordanceRegion(
                affordance=region.affordance,
                center=np.array(region.center),
                half_axes=np.array([check.positive(f"{at}.half_axes[{i}]", v) for i, v in enumerate(region.half_axes)]),
                normal=check.unit(f"{at}.normal", region.normal),
            )
            for at, region in _numbered("affordance_regions", file.affordance_regions)
        ),
        geometry=tuple(_primitive(at, part, check) for at, part in _numbered("geometry", file.geometry)),
        grasp_regions=tuple(
            GraspRegion(
                name=grasp.name,
                kind=grasp.kind,
                center=np.array(grasp.center),
                axis=check.unit(f"{at}.axis", grasp.axis),
                half_length=check.positive(f"{at}.half_length", grasp.half_length),
                width=check.positive(f"{at}.width", grasp.width),
                faces=check.faces(f"{at}.faces", grasp.faces),
            )
            for at, grasp in _numbered("grasp_regions", file.grasp_regions)
        ),
        up=check.unit("$.up", file.up),
        movable=file.movable,
        mass=file.mass,
        description=" ".join(file.description.split()),
        profile=None if file.profile is None else _vessel(file.profile, check),
    )


def check_version(content: object, path: Path, supported: int) -> None:
    """Refuse a file of a later format before anything else in it is looked at.

    Raises:
        FileFormatError: if the file is no mapping or its ``format_version`` is below 1.
        FileVersionError: if its ``format_version`` is later than ``supported``.
    """
    if not isinstance(content, dict):
        raise FileFormatError(path, "$", "holds no fields", "fields such as `format_version: 1`")
    version = content.get("format_version")
    if isinstance(version, int) and not isinstance(version, bool):
        if version > supported:
            raise FileVersionError(path, version, supported)
        if version < 1:
            raise FileFormatError(path, "$.format_version", f"is {version}", f"1 to {supported}")


class _Checker:
    """What the schema's types cannot say; every method returns the checked value."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def positive(self, where: str, value: float) -> float:
        if value <= 0:
            raise FileFormatError(self.path, where, f"is {value:g}", "a number above 0")
        return float(value)

    def unit(self, where: str, value: Vector) -> Float[np.ndarray, " 3"]:
        vector = np.array(value, dtype=float)
        length = float(np.linalg.norm(vector))
        if abs(length - 1) > UNIT_TOLERANCE:
            raise FileFormatError(self.path, where, f"has length {length:.4g}", "a unit vector")
        return vector / length

    def name(self, where: str, value: str) -> str:
        if not value.strip():
            raise FileFormatError(self.path, where, "is empty", "a name")
        return value

    def faces(self, where: str, value: int) -> int:
        if value != 0 and value < 3:
            raise FileFormatError(self.path, where, f"is {value}", "0 for round, or 3 and more")
        return value

    def color(self, where: str, value: Sequence[float]) -> Float[np.ndarray, " 4"]:
        for index, component in enumerate(value):
            if not 0 <= component <= 1:
                raise FileFormatError(self.path, f"{where}[{index}]", f"is {component:g}", "0 to 1")
        return np.array([*value, 1.0][:4], dtype=float)

    def unique(self, part: str, field: str, names: Sequence[str]) -> None:
        for index, name in enumerate(names):
            where = f"$.{part}[{index}].{field}"
            self.name(where, name)
            if name in names[:index]:
                raise FileFormatError(self.path, where, f"{name!r} is given twice", "unique names")


def _numbered(name: str, parts: Sequence[Part]) -> list[tuple[str, Part]]:
    return [(f"$.{name}[{index}]", part) for index, part in enumerate(parts)]


def _vessel(profile: _Profile, check: _Checker) -> VesselProfile:
    heights, radii = np.array(profile.inner, dtype=float).T
    for index in range(len(heights)):
        where = f"$.profile.inner[{index}]"
        check.positive(f"{where}[1]", radii[index])
        if index and heights[index] <= heights[index - 1]:
            problem = f"is {heights[index]:g}, not above {heights[index - 1]:g} before it"
            raise FileFormatError(check.path, f"{where}[0]", problem, "heights from the inner floor to the mouth")
    if profile.fill is not None and not heights[0] < profile.fill <= heights[-1]:
        limits = f"above {heights[0]:g}, at most {heights[-1]:g}"
        raise FileFormatError(check.path, "$.profile.fill", f"is {profile.fill:g}", limits)
    return VesselProfile(heights, radii, check.positive("$.profile.wall", profile.wall), profile.fill)


def _primitive(where: str, part: _Box | _Cylinder | _Capsule | _Sphere, check: _Checker) -> Primitive:
    center, rgba = np.array(part.center, dtype=float), check.color(f"{where}.rgba", part.rgba)
    if isinstance(part, _Box):
        size = np.array([check.positive(f"{where}.size[{i}]", v) for i, v in enumerate(part.size)])
        pose = RigidTransform.from_components(center, Rotation.from_euler("xyz", part.rotation_rpy_deg, degrees=True))
        return Primitive("box", size / 2, pose, rgba)
    radius = check.positive(f"{where}.radius", part.radius)
    if isinstance(part, _Sphere):
        pose = RigidTransform.from_components(center, Rotation.identity())
        return Primitive("sphere", np.array([radius]), pose, rgba)
    length = check.positive(f"{where}.length", part.length)
    axis = check.unit(f"{where}.axis", part.axis)
    rotation = Rotation.align_vectors(axis[None], np.array([[0.0, 0.0, 1.0]]))[0]
    pose = RigidTransform.from_components(center, rotation)
    kind = "cylinder" if isinstance(part, _Cylinder) else "capsule"
    return Primitive(kind, np.array([radius, length / 2]), pose, rgba)
