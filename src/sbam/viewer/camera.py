"""Where cameras stand to see a plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.errors import UnknownNameError

LOOK_AT = (0.0, 0.36, 0.20)
"""Point in the agent frame that every camera looks at, m."""


@dataclass(frozen=True)
class View:
    """A camera that looks at the place before the agent.

    Attributes:
        azimuth_deg: direction in which the camera looks, from the agent's x axis, counter-clockwise.
        elevation_deg: its pitch; negative looks down.
        distance: of the camera from `LOOK_AT`, m.
    """

    azimuth_deg: float
    elevation_deg: float
    distance: float

    def position(self) -> Float[np.ndarray, " 3"]:
        """Where the camera stands, agent frame, m."""
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        level = np.cos(elevation)
        forward = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
        return np.array(LOOK_AT) - self.distance * forward


VIEWS = {
    "opposite": View(-112.0, -24.0, 1.55),
    "left": View(-15.0, -12.0, 1.7),
    "right": View(195.0, -12.0, 1.7),
    "behind": View(75.0, -35.0, 2.1),
    "above": View(90.0, -89.0, 2.0),
}
"""Views by name: from opposite the agent, from its sides, over its shoulders and from above."""


def view_named(name: str) -> View:
    """The view with that name; raises `UnknownNameError` that lists the known ones."""
    if name not in VIEWS:
        raise UnknownNameError("view", name, VIEWS)
    return VIEWS[name]


def heading_deg(T_world_agent: RigidTransform) -> float:
    """Angle of the agent's x axis about world z, degrees."""
    right = T_world_agent.rotation.apply([1.0, 0.0, 0.0])
    return float(np.degrees(np.arctan2(right[1], right[0])))
