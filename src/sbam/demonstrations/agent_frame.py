"""Where the acting person stands and looks, for recordings that do not say it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.recording import Track
from sbam.scene.geometry import AGENT_DISTANCE, agent_pose, support_height
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.scene import Scene

KIT_TABLE = "kitchen_sideboard"
KIT_HEADING = 180.0
"""In the KIT recordings the person looks along world -x, degrees from world +x."""
DEFAULT_HEADING = 90.0
"""Without person and table the agent's axes are the world's: it looks along +y, degrees from world +x."""
TABLE = "table"
"""A body of this name is taken as the table top, its origin on the surface, unless the object library knows better."""
_SQUARE_ON = 20.0


def find_agent(T_world_start: Mapping[str, RigidTransform], person: Track | None) -> tuple[RigidTransform, str]:
    """The agent frame: origin on the support under the person, x right, y forward, z up.

    The heading is the person's, or the axis of the world that it is within 20 degrees of, because people stand square
    to the table and tables to the world. Without a person it is that of the KIT laboratory where its sideboard is
    present, else world +y; the agent then stands `AGENT_DISTANCE` before the middle of the objects.

    Args:
        T_world_start: object name -> pose at the start.
        person: track of the person's root, y forward, if recorded.

    Returns:
        T_world_agent and a note on how it was found.
    """
    height, surface = _support_height(T_world_start)
    if person is not None and person.seen.any():
        root = person.where(person.seen).poses
        position = np.median(root.translation, axis=0)
        forward = root.rotation.apply([0.0, 1.0, 0.0]).mean(axis=0)
        heading = float(np.degrees(np.arctan2(forward[1], forward[0])))
        square = 90.0 * round(heading / 90.0)
        if abs(heading - square) < _SQUARE_ON:
            heading = square
        note = f"agent frame from the person's root: looks along {heading % 360:.0f} degrees from world +x"
        return agent_pose([position[0], position[1], height], heading), f"{note}, {surface}"
    heading, reason = (
        (KIT_HEADING, "as in the KIT laboratory")
        if KIT_TABLE in T_world_start
        else (
            DEFAULT_HEADING,
            "its axes are the world's",
        )
    )
    forward = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading))])
    near = [T.translation[:2] for name, T in T_world_start.items() if not _is_furniture(name)]
    middle = np.mean(near or [T.translation[:2] for T in T_world_start.values()], axis=0)
    x, y = middle - AGENT_DISTANCE * forward
    note = (
        f"no person in the recording: the agent is taken to stand {AGENT_DISTANCE:g} m before the middle of the "
        f"objects and to look along {heading:.0f} degrees from world +x ({reason}), {surface}"
    )
    return agent_pose([x, y, height], heading), note


def _is_furniture(name: str) -> bool:
    library = ObjectLibrary.built_in()
    return not library[name].movable if name in library else name == TABLE


def _support_height(T_world_start: Mapping[str, RigidTransform]) -> tuple[float, str]:
    """Height of the surface that is worked on, m, and how it is known."""
    library = ObjectLibrary.built_in()
    known = {name: library[name] for name in T_world_start if name in library}
    if TABLE in T_world_start and TABLE not in known:
        return float(T_world_start[TABLE].translation[2]), f"on the origin of {TABLE}"
    if known:
        start = {name: T_world_start[name] for name in known}
        scene = Scene("start", known, start, RigidTransform.identity())
        return support_height(scene), "on the surface under the objects"
    lowest = min(float(T.translation[2]) for T in T_world_start.values())
    return lowest, "at the height of the lowest object"
