"""Scene: which objects stand where, and where the agent stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from scipy.spatial.transform import RigidTransform

from sbam.scene.object_model import ObjectModel


@dataclass(frozen=True)
class Scene:
    """A starting scene.

    Attributes:
        name: for reports.
        objects: object name in the scene -> its model.
        T_world_object: object name -> pose at the start. World z is up (gravity along -z), m.
        T_world_agent: the agent frame, gravity-aligned: x right, y forward (where the agent looks), z up; its origin is
            on the support surface (table top) under the agent's trunk. Constraints are expressed in its axes, robots
            are placed relative to it.
        robot: name of the robot the scene is meant for, or None.
        source: file it was read from.
    """

    name: str
    objects: Mapping[str, ObjectModel]
    T_world_object: Mapping[str, RigidTransform]
    T_world_agent: RigidTransform
    robot: str | None = None
    source: str = ""
