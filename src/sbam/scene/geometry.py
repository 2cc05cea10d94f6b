"""Poses of agents and standing objects, and how high the support is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.scene.affordance_region import AffordanceRegion
from sbam.scene.object_model import ObjectModel
from sbam.scene.scene import Scene

AGENT_DISTANCE = 0.45
"""How far before the objects an agent stands where a scene does not say it, m (as people do at a table)."""


def agent_pose(position: Float[np.ndarray, " 3"] | Sequence[float], heading_deg: float) -> RigidTransform:
    """The agent frame ``T_world_agent``: x right, y forward, z up.

    Args:
        position: origin (x, y, z), on the support surface under the agent's trunk, world, m.
        heading_deg: angle of the agent's forward axis about world z, from world +x, degrees.
    """
    rotation = Rotation.from_euler("z", heading_deg - 90.0, degrees=True)
    return RigidTransform.from_components(np.asarray(position, dtype=float), rotation)


def agent_heading_deg(T_world_agent: RigidTransform) -> float:
    """Inverse of `agent_pose`: the angle of the agent's forward axis about world z, from world +x, degrees.

    Raises:
        ValueError: if the frame's z axis does not point up.
    """
    matrix = T_world_agent.rotation.as_matrix()
    if not np.isclose(matrix[2, 2], 1.0, atol=1e-6):
        raise ValueError("the agent frame must be gravity-aligned: its z axis has to point up")
    return float(np.degrees(np.arctan2(matrix[1, 1], matrix[0, 1])))


def upright_rotation(up: Float[np.ndarray, " 3"], yaw_deg: float) -> Rotation:
    """Rotation of a standing object, ``R_world_object``.

    At yaw 0 it is the shortest rotation that turns ``up`` to world +z (half a turn about x for an object whose up is
    -z), so that the local x axis of an object with up +y, +z or -z points along world +x.

    Args:
        up: unit vector that points up when the object stands, object frame.
        yaw_deg: turn about world z after that, degrees.
    """
    axis = np.cross(up, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    stand = Rotation.from_rotvec(axis * np.arctan2(sine, up[2]))
    return Rotation.from_euler("z", yaw_deg, degrees=True) * stand


def region_centers(scene: Scene, affordance: str) -> Mapping[str, Float[np.ndarray, " 3"]]:
    """Where the regions with an affordance are at the start: object name -> centre, world, m."""
    return {
        name: scene.T_world_object[name].apply(region.center)
        for name, model in scene.objects.items()
        for region in model.affordance_regions
        if region.affordance == affordance
    }


def support_height(scene: Scene) -> float:
    """Height of the surface that the objects stand on, world z, m.

    The highest upward ``place onto`` region of the furniture; without furniture the lowest ``place`` region, and
    without those the lowest object origin.
    """
    return _support_height(scene.objects, scene.T_world_object)


def default_agent_pose(
    objects: Mapping[str, ObjectModel], T_world_object: Mapping[str, RigidTransform]
) -> RigidTransform:
    """The agent frame where a scene does not say it.

    The agent looks along world +x and stands `AGENT_DISTANCE` before the mean position of the movable objects (of all
    objects, if none is movable), on the support.
    """
    names = [name for name, model in objects.items() if model.movable] or list(objects)
    centroid = np.mean([T_world_object[name].translation for name in names], axis=0)
    return agent_pose([centroid[0] - AGENT_DISTANCE, centroid[1], _support_height(objects, T_world_object)], 0.0)


def _support_height(objects: Mapping[str, ObjectModel], T_world_object: Mapping[str, RigidTransform]) -> float:
    def heights(affordance: str, direction: float, movable: bool | None = None) -> list[float]:
        """Heights of the regions whose normal points up (direction 1) or down (-1)."""
        return [
            float(pose.apply(region.center)[2])
            for name, pose in T_world_object.items()
            for region in objects[name].affordance_regions
            if region.affordance == affordance
            and movable in (None, objects[name].movable)
            and _vertical(region, pose) * direction > 0.5
        ]

    if tops := heights("place onto", 1.0, movable=False):
        return max(tops)
    if bottoms := heights("place", -1.0):
        return min(bottoms)
    return min(float(pose.translation[2]) for pose in T_world_object.values())


def _vertical(region: AffordanceRegion, pose: RigidTransform) -> float:
    """Vertical component of a region's normal in the world."""
    return float(pose.rotation.apply(region.normal)[2])
