"""Constraints: how the vector between two affordance regions is seen."""

from collections.abc import Mapping

from sbam.constraints.base import ConstraintType
from sbam.constraints.cartesian import Cartesian
from sbam.constraints.cylindrical import Cylindrical
from sbam.constraints.region_pair import RegionPair, RegionReference
from sbam.constraints.symbolic import SPATIAL_RELATIONS, SpatialRelation, Symbolic
from sbam.errors import UnknownNameError
from sbam.extensions import BUILT_IN, registered

CONSTRAINT_TYPES: Mapping[str, ConstraintType] = registered("sbam.constraints", ConstraintType)
"""The constraint types by name, in mode ``default``, those that other distributions register included."""

BUILT_IN_CONSTRAINTS = tuple(BUILT_IN["sbam.constraints"])
"""Names of the paper's types."""

CARTESIAN = Cartesian.name
"""The type whose channels are the vector itself, which some pairs have in models of every type."""


def constraint_type(name: str) -> ConstraintType:
    """The constraint type with that name.

    Raises:
        UnknownNameError: if there is none; lists the known ones.
        ExtensionError: if another distribution registers it and it cannot be used.
    """
    if name not in CONSTRAINT_TYPES:
        raise UnknownNameError("constraint type", name, CONSTRAINT_TYPES)
    return CONSTRAINT_TYPES[name]


__all__ = [
    "BUILT_IN_CONSTRAINTS",
    "CARTESIAN",
    "CONSTRAINT_TYPES",
    "SPATIAL_RELATIONS",
    "Cartesian",
    "ConstraintType",
    "Cylindrical",
    "RegionPair",
    "RegionReference",
    "SpatialRelation",
    "Symbolic",
    "constraint_type",
]
