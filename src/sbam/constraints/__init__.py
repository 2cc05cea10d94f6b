"""Constraints: how the vector between two affordance regions is seen."""

from sbam.constraints.base import ConstraintType
from sbam.constraints.cartesian import Cartesian
from sbam.constraints.cylindrical import Cylindrical
from sbam.constraints.region_pair import RegionPair, RegionReference
from sbam.constraints.symbolic import SPATIAL_RELATIONS, SpatialRelation, Symbolic
from sbam.errors import UnknownNameError

CONSTRAINT_TYPES: dict[str, ConstraintType] = {
    constraint.name: constraint for constraint in (Cartesian(), Cylindrical(), Symbolic())
}
"""The constraint types by name, in mode ``default``; a new type is one file and one entry here."""


def constraint_type(name: str) -> ConstraintType:
    """The constraint type with that name; raises `UnknownNameError` that lists the known ones."""
    if name not in CONSTRAINT_TYPES:
        raise UnknownNameError("constraint type", name, CONSTRAINT_TYPES)
    return CONSTRAINT_TYPES[name]


__all__ = [
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
