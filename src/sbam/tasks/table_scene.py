"""A scene of objects on a table before the agent."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import RigidTransform

from sbam.scene import ObjectLibrary, Scene, upright_rotation

TABLE = "kitchen_sideboard"


def scene_on_table(name: str, T_world_object: Mapping[str, RigidTransform]) -> Scene:
    """Built-in objects on a table whose top is at z = 0, long side across, front edge 22 cm before the agent.

    Args:
        name: of the scene.
        T_world_object: library name of each object -> its pose; the world is the agent frame.
    """
    library = ObjectLibrary.built_in()
    table = library[TABLE]
    rotation = upright_rotation(table.up, 0.0)
    top = rotation.apply(table.region("place onto").center)
    table_pose = RigidTransform.from_components(np.array([0.0, 0.545, 0.0]) - top, rotation)
    return Scene(
        name=name,
        objects={key: library[key] for key in (TABLE, *T_world_object)},
        T_world_object={TABLE: table_pose, **T_world_object},
        T_world_agent=RigidTransform.identity(),
    )
