"""Affordance regions, object models, the object library and starting scenes."""

from sbam.scene.affordance_region import AffordanceRegion, is_support
from sbam.scene.built_in_scenes import built_in_scene, built_in_scene_names
from sbam.scene.geometry import agent_heading_deg, agent_pose, region_centers, support_height, upright_rotation
from sbam.scene.object_file import load_object
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import GraspRegion, ObjectModel, Primitive, VesselProfile
from sbam.scene.scene import Scene
from sbam.scene.scene_file import load_scene, save_scene

__all__ = [
    "AffordanceRegion",
    "GraspRegion",
    "ObjectLibrary",
    "ObjectModel",
    "Primitive",
    "Scene",
    "VesselProfile",
    "agent_heading_deg",
    "agent_pose",
    "built_in_scene",
    "built_in_scene_names",
    "is_support",
    "load_object",
    "load_scene",
    "region_centers",
    "save_scene",
    "support_height",
    "upright_rotation",
]
