"""Where the mouth of the bottle must be while it is tilted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import RigidTransform

from sbam.scene import ObjectModel
from sbam.tasks.geometry import GeometryResult
from sbam.tasks.object_motion import ObjectMotion, region_path

POUR_TILT = np.deg2rad(60.0)  # rad: beyond it something may flow
POUR_HEIGHT = (0.010, 0.080)  # m: of the mouth above the rim while something may flow
ABOUT_TO_POUR_TILT = np.deg2rad(30.0)  # rad: a person pours or is about to: beyond this tilt...
ABOUT_TO_POUR_DISTANCE = 0.080  # m: ...with the mouth this near to the rim


@dataclass(frozen=True)
class MouthPath:
    """The mouth of a bottle as seen from the rim of a cup, in N samples.

    Attributes:
        tilt: of the bottle from upright, rad.
        aside: horizontal distance of the mouth from the middle of the rim, m.
        above: height of the mouth above the rim, m.
    """

    tilt: Float[np.ndarray, " samples"]
    aside: Float[np.ndarray, " samples"]
    above: Float[np.ndarray, " samples"]

    @property
    def may_flow(self) -> Bool[np.ndarray, " samples"]:
        """Whether the bottle is tilted so far that something may flow."""
        return self.tilt > POUR_TILT


def mouth_path(bottle: ObjectModel, T_bottle: RigidTransform, rim: Float[np.ndarray, "samples 3"]) -> MouthPath:
    """Where the mouth goes.

    Args:
        bottle: what is poured from.
        T_bottle: its N poses in a frame whose z-axis points up.
        rim: middle of the rim in the same frame, m.
    """
    up = T_bottle.rotation.apply(bottle.up)[:, 2]
    offset = T_bottle.apply(bottle.region("pour from").center) - rim
    return MouthPath(np.arccos(np.clip(up, -1.0, 1.0)), np.hypot(offset[:, 0], offset[:, 1]), offset[:, 2])


def rim_radius(cup: ObjectModel) -> float:
    """Within it the mouth is over the cup, m."""
    return float(cup.region("pour into").half_axes.min())


def mouth_of_motion(motion: ObjectMotion, pour_from: str, pour_into: str) -> MouthPath:
    """Where the mouth goes in a motion of the objects that play two roles."""
    name = motion.task.binding[pour_from]
    bottle = motion.task.scene.objects[name]
    return mouth_path(bottle, motion.T_agent_object[name], region_path(motion, pour_into, "pour into"))


def measure_pouring(motion: ObjectMotion, pour_from: str = "pour_from", pour_into: str = "pour_into") -> GeometryResult:
    """Whenever the bottle is tilted beyond 60 degrees its mouth is over the cup and 10-80 mm above the rim.

    Args:
        motion: a plan, or another motion of the objects.
        pour_from: role of what is poured from.
        pour_into: role of what is poured into.
    """
    mouth = mouth_of_motion(motion, pour_from, pour_into)
    rim = rim_radius(motion.task.scene.objects[motion.task.binding[pour_into]])
    pouring = mouth.may_flow
    values = {"largest tilt [deg]": float(np.rad2deg(mouth.tilt.max()))}
    problems = []
    if not pouring.any():
        problems.append(f"never tilted beyond 60 degrees (at most {values['largest tilt [deg]']:.0f})")
    else:
        step = float(np.diff(motion.time[:2])[0])
        farthest = 1e3 * mouth.aside[pouring].max()
        low, high = 1e3 * mouth.above[pouring].min(), 1e3 * mouth.above[pouring].max()
        values["tilted for [s]"] = float(pouring.sum() * step)
        values["tilted beside the cup for [s]"] = float((pouring & (mouth.aside > rim)).sum() * step)
        values["mouth aside, worst [mm]"] = float(farthest)
        values["mouth above, least [mm]"] = float(low)
        values["mouth above, most [mm]"] = float(high)
        if farthest > 1e3 * rim:
            problems.append(f"mouth {farthest:.0f} mm aside while tilted (rim {1e3 * rim:.0f} mm)")
        if low < 1e3 * POUR_HEIGHT[0] or high > 1e3 * POUR_HEIGHT[1]:
            problems.append(f"mouth {low:.0f} to {high:.0f} mm above the rim while tilted")
    return GeometryResult(not problems, values, tuple(problems))
