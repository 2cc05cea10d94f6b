"""Reading URDF models through MuJoCo."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import defusedxml.ElementTree
from defusedxml import DefusedXmlException

from sbam.errors import FileFormatError

# fusestatic would drop fixed links, and with them the TCP; links without inertia are refused without bounds
COMPILER = {
    "fusestatic": "false",
    "discardvisual": "true",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "1e-3",
    "boundinertia": "1e-6",
}


def read_urdf(path: Path) -> str:
    """A URDF file as MuJoCo can take it: fixed links kept, drawings and meshes left out.

    Only primitives count for collisions: a link whose collision shapes are meshes has none.

    Args:
        path: the file.

    Raises:
        FileFormatError: if it is not a URDF.
    """
    try:
        robot = defusedxml.ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise FileFormatError(path, f"line {error.position[0]}", f"not XML: {error}", "a URDF model") from error
    except (OSError, UnicodeDecodeError, DefusedXmlException) as error:
        raise FileFormatError(path, "", f"cannot be read: {error}", "a URDF model") from error
    if robot is None or robot.tag != "robot":
        raise FileFormatError(path, "", "root element is not <robot>", "a URDF model (expand xacro files first)")
    for old in robot.findall("mujoco"):
        robot.remove(old)
    ElementTree.SubElement(ElementTree.SubElement(robot, "mujoco"), "compiler", COMPILER)
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for collision in link.findall("collision"):
            if collision.find("geometry/mesh") is not None:
                link.remove(collision)
    return ElementTree.tostring(robot, encoding="unicode")
