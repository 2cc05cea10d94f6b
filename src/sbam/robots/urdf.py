"""Reading URDF models through MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import defusedxml.ElementTree
import numpy as np
from defusedxml import DefusedXmlException

from sbam.errors import FileFormatError

# fusestatic would drop fixed links, and with them the TCP; links without inertia are refused without bounds
COMPILER = {
    "fusestatic": "false",
    "discardvisual": "false",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "1e-3",
    "boundinertia": "1e-6",
}
NUMBERS = {  # attributes that hold numbers, and how many
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1, "effort": 1},
    "mimic": {"multiplier": 1, "offset": 1},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
}
INFINITE_ALLOWED = {"lower", "upper", "velocity", "effort"}


@dataclass(frozen=True)
class UrdfJoint:
    """What a URDF says of a joint and MuJoCo does not keep; None where it says nothing.

    Attributes:
        kind: ``revolute``, ``continuous``, ``prismatic``, ``fixed`` or what else the file says.
        lower: rad or m.
        upper: rad or m.
        velocity: rad/s or m/s.
        effort: Nm or N.
        mimics: joint whose position it follows.
    """

    kind: str
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    mimics: str | None = None


def read_urdf(path: Path, find_mesh: Callable[[str], Path | None] = lambda name: None) -> str:
    """A URDF file as MuJoCo can take it: fixed links kept, meshes that cannot be used left out.

    Args:
        path: the file.
        find_mesh: file name of a mesh, as the URDF has it -> file that MuJoCo can read, or None.

    Raises:
        FileFormatError: if it is not a URDF; names line, or link or joint, and attribute.
    """
    robot = _parse(path)
    for old in robot.findall("mujoco"):
        robot.remove(old)
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", COMPILER)
    for link in robot.iter("link"):
        if not _has_inertia(link):
            for inertial in link.findall("inertial"):
                link.remove(inertial)
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if mesh is None and shape.tag == "collision":
                continue
            file = find_mesh(mesh.get("filename", "")) if mesh is not None else None
            if mesh is None or file is None:
                link.remove(shape)
            else:
                mesh.set("filename", str(file))
    return ElementTree.tostring(robot, encoding="unicode")


def urdf_joints(path: Path) -> dict[str, UrdfJoint]:
    """Name -> what the file says of each joint that is not fixed; raises `FileFormatError` as `read_urdf` does."""
    joints = {}
    for joint in _parse(path).findall("joint"):
        kind = joint.get("type", "")
        if kind == "fixed":
            continue
        limit, mimic = joint.find("limit"), joint.find("mimic")
        values = {
            key: float(limit.get(key, "")) if limit is not None and limit.get(key) else None
            for key in ("lower", "upper", "velocity", "effort")
        }
        joints[joint.get("name", "")] = UrdfJoint(kind, **values, mimics=None if mimic is None else mimic.get("joint"))
    return joints


def urdf_meshes(path: Path) -> list[str]:
    """File names of all meshes that the URDF draws or collides with, as it has them."""
    return [mesh.get("filename", "") for mesh in _parse(path).iter("mesh")]


def links_without_inertia(path: Path) -> list[str]:
    """Links that move and have no mass or no positive inertia."""
    robot = _parse(path)
    moved = [joint.find("child") for joint in robot.findall("joint") if joint.get("type") != "fixed"]
    names = {child.get("link") for child in moved if child is not None}
    return [
        link.get("name", "") for link in robot.findall("link") if link.get("name") in names and not _has_inertia(link)
    ]


def _has_inertia(link: ElementTree.Element) -> bool:
    """Whether a link's mass and moments of inertia are there and positive: MuJoCo refuses others."""
    mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
    if mass is None or inertia is None:
        return False
    xx, xy, xz, yy, yz, zz = (float(inertia.get(key, "0")) for key in NUMBERS["inertia"])
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return float(mass.get("value", "0")) > 0.0 and bool(moments.min() > 0.0)


def _parse(path: Path) -> ElementTree.Element:
    try:
        robot = defusedxml.ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise FileFormatError(path, f"line {error.position[0]}", f"not XML: {error}", "a URDF model") from error
    except (OSError, UnicodeDecodeError, DefusedXmlException) as error:
        raise FileFormatError(path, "", f"cannot be read: {error}", "a URDF model") from error
    if robot is None or robot.tag != "robot":
        raise FileFormatError(path, "", "root element is not <robot>", "a URDF model (expand xacro files first)")
    for part in robot:
        if part.tag in ("link", "joint"):
            for element in part.iter():
                _check_numbers(path, f"{part.tag} {part.get('name')!r}", element)
    return robot


def _check_numbers(path: Path, owner: str, element: ElementTree.Element) -> None:
    for attribute, count in NUMBERS.get(element.tag, {}).items():
        text = element.get(attribute)
        if text is None:
            continue
        where = f"{owner}, <{element.tag} {attribute}={text!r}>"
        expected = "one number" if count == 1 else f"{count} numbers"
        try:
            values = [float(word) for word in text.split()]
        except ValueError as error:
            raise FileFormatError(path, where, f"not a number: {error}", expected) from error
        finite = all(map(math.isfinite, values)) or (attribute in INFINITE_ALLOWED and not any(map(math.isnan, values)))
        if len(values) != count or not finite:
            problem = "not finite" if not finite else f"{len(values)} numbers"
            raise FileFormatError(path, where, problem, expected)
