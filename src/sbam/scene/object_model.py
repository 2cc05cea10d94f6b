"""Object model: affordance regions, simple geometry and where the object can be grasped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.errors import UnknownNameError
from sbam.scene.affordance_region import AffordanceRegion


@dataclass(frozen=True)
class Primitive:
    """A geometric primitive for drawing, collision and physics.

    Attributes:
        kind: ``box`` (size = half-extents), ``cylinder`` and ``capsule`` (size = radius, half-length along local z),
            ``sphere`` (size = radius); m.
        size: m; three numbers, two or one, as ``kind`` says.
        T_object_primitive: pose in the object's frame.
        rgba: colour, 0 to 1.
    """

    kind: Literal["box", "cylinder", "capsule", "sphere"]
    size: Float[np.ndarray, " sizes"]
    T_object_primitive: RigidTransform
    rgba: Float[np.ndarray, " 4"]


@dataclass(frozen=True)
class GraspRegion:
    """Where a hand can hold the object.

    Attributes:
        name: unique within the object, such as ``body`` or ``handle left``.
        kind: ``around`` for vessels held from the side, ``across`` for bars held across their axis.
        center: a point on the axis, object frame, m.
        axis: unit axis of the vessel or bar, object frame; for vessels it points up when the object stands.
        half_length: how far along the axis from ``center`` a hand may hold, m.
        width: outer diameter, or the distance of opposite faces, m.
        faces: number of flat faces around the axis (4 for a square carton), or 0 for round.
    """

    name: str
    kind: Literal["around", "across"]
    center: Float[np.ndarray, " 3"]
    axis: Float[np.ndarray, " 3"]
    half_length: float
    width: float
    faces: int = 0


@dataclass(frozen=True)
class VesselProfile:
    """The hollow of a round vessel about its ``up`` axis, through the object's origin, for physics.

    Attributes:
        heights: along ``up`` from the origin, increasing from the inner floor to the mouth, m.
        radii: inner radius at each height, linear between them, m.
        wall: thickness of the walls, m.
        fill: level to which the vessel is filled, same axis, m; None for a vessel that starts empty.
    """

    heights: Float[np.ndarray, " levels"]
    radii: Float[np.ndarray, " levels"]
    wall: float
    fill: float | None = None

    @property
    def fill_volume(self) -> float:
        """Volume between the inner floor and the level, m^3; 0 for an empty vessel."""
        if self.fill is None:
            return 0.0
        inside = self.heights < self.fill
        heights = np.append(self.heights[inside], self.fill)
        radii = np.append(self.radii[inside], np.interp(self.fill, self.heights, self.radii))
        low, high = radii[:-1], radii[1:]
        return float(np.pi / 3.0 * np.sum(np.diff(heights) * (low**2 + low * high + high**2)))


@dataclass(frozen=True)
class ObjectModel:
    """What SBAM knows of a kind of object.

    Attributes:
        name: name in the object library.
        affordance_regions: its regions, unique by affordance.
        geometry: primitives for drawing, collision and physics.
        grasp_regions: where hands can hold it.
        up: unit vector that points up when the object stands, object frame.
        movable: False for furniture.
        mass: kg.
        description: what it is and where its numbers come from.
        profile: its hollow, for vessels.
    """

    name: str
    affordance_regions: tuple[AffordanceRegion, ...]
    geometry: tuple[Primitive, ...]
    grasp_regions: tuple[GraspRegion, ...]
    up: Float[np.ndarray, " 3"]
    movable: bool
    mass: float
    description: str = ""
    profile: VesselProfile | None = None

    @property
    def affordances(self) -> tuple[str, ...]:
        """Names of all affordances, in file order."""
        return tuple(region.affordance for region in self.affordance_regions)

    def region(self, affordance: str) -> AffordanceRegion:
        """The region with that affordance; raises `UnknownNameError` that lists the known ones."""
        for region in self.affordance_regions:
            if region.affordance == affordance:
                return region
        raise UnknownNameError("affordance", affordance, self.affordances, f"object {self.name!r}")
