"""Affordance region: a part of an object that affords an action."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


def is_support(affordance: str) -> bool:
    """Whether regions of that affordance are supports: what things are placed, rolled or cut *onto*."""
    return affordance.endswith(" onto")


@dataclass(frozen=True)
class AffordanceRegion:
    """An ellipse fixed in its object's frame (paper, section III-A).

    Attributes:
        affordance: what the region affords, unique within its object: ``pour from``, ``place onto``...
        center: centre of the ellipse, object frame, m.
        half_axes: half-axes of the ellipse, m.
        normal: unit normal of the ellipse's plane, object frame; points out of the object.
    """

    affordance: str
    center: Float[np.ndarray, " 3"]
    half_axes: Float[np.ndarray, " 2"]
    normal: Float[np.ndarray, " 3"]
