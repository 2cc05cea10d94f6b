"""Affordance region: a part of an object that affords an action."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def is_support(affordance: str) -> bool:
    """Whether regions of that affordance are supports: what things are placed, rolled or cut *onto*."""
    return affordance.endswith(" onto")


@dataclass(frozen=True)
class AffordanceRegion:
    """An ellipse fixed in its object's frame (paper, section III-A).

    Attributes:
        affordance: what the region affords, unique within its object: ``pour from``, ``place onto``...
        center: centre of the ellipse, (3,), object frame, m.
        half_axes: half-axes of the ellipse, (2,), m.
        normal: unit normal of the ellipse's plane, (3,), object frame; points out of the object.
    """

    affordance: str
    center: NDArray[np.float64]
    half_axes: NDArray[np.float64]
    normal: NDArray[np.float64]
