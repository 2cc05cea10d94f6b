"""Affordance regions, object models, the object library and starting scenes."""

from sbam.scene.affordance_region import AffordanceRegion
from sbam.scene.object_file import load_object
from sbam.scene.object_library import ObjectLibrary
from sbam.scene.object_model import GraspRegion, ObjectModel, Primitive
from sbam.scene.scene import Scene

__all__ = ["AffordanceRegion", "GraspRegion", "ObjectLibrary", "ObjectModel", "Primitive", "Scene", "load_object"]
