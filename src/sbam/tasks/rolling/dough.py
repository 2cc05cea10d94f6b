"""Dough as plastic columns that a pin presses down and that stay down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import SimulationError
from sbam.scene import ObjectModel, support_height
from sbam.tasks.action import Action
from sbam.tasks.materials import DOUGH

if TYPE_CHECKING:
    import mujoco

THICKNESS = 0.010  # m, before it is rolled
THINNEST = 0.001  # m
ACROSS, ALONG = 16, 10  # columns along the pin and along the strokes
WIDTH = 0.26  # m along the pin
LENGTH = (0.08, 0.15)  # m along the strokes, least and most
YIELD = 2.0  # N that a column withstands
STOPPING = 0.006  # s in which friction stops a column; a softer one lets columns glide on below the pin
COLUMN_MASS = 0.002  # kg
TIP = 0.012  # m: radius of a column's round top, so that the pin does not catch at edges
AWAY = 0.08  # m from start and end: nearer, the pin is being picked up or put down
LOW = 0.004  # m above the lowest: higher, the pin is being carried


@dataclass(frozen=True)
class Dough:
    """Where the dough lies.

    Attributes:
        T_world_dough: x along the pin, y along the strokes, z up; origin on the support.
        grid: centres of the columns, m.
        spacing: of the columns, m.
        radius: of the pin, m.
        half_length: of the pin's thick part, m.
        axis: unit vector along the pin, in its frame.
    """

    T_world_dough: RigidTransform
    grid: Float[np.ndarray, "columns 2"]
    spacing: Float[np.ndarray, " 2"]
    radius: float
    half_length: float
    axis: Float[np.ndarray, " 3"]

    def pressed_by(self, pose: RigidTransform) -> Float[np.ndarray, " columns"]:
        """Thickness to which the pin at some poses presses the columns; infinite where it never comes."""
        local = self.T_world_dough.inv() * pose
        direction = local.rotation.apply(self.axis)[:, None]
        center = local.translation[:, None]
        along = ((self.grid[None, :, :] - center[..., :2]) * direction[..., :2]).sum(-1)
        along /= np.square(direction[..., :2]).sum(-1)
        nearest = center + along[..., None] * direction
        aside = np.linalg.norm(self.grid[None] - nearest[..., :2], axis=-1)
        below = nearest[..., 2] - np.sqrt(np.maximum(self.radius**2 - aside**2, 0.0))
        below[(aside >= self.radius) | (np.abs(along) > self.half_length)] = np.inf
        return below.min(axis=0)


def lay_dough(action: Action, pin: str) -> Dough:
    """Put dough where the pin shall roll: where it goes low, away from its start and end.

    Raises:
        SimulationError: if the pin never goes low away from its start and end, or has no round part.
    """
    model = action.scene.objects[pin]
    radius, half_length, axis = _roller(model)
    times = np.arange(0.0, action.duration, 0.02)
    pose = action.poses(pin, times)
    position = pose.translation
    away = np.minimum(*(np.linalg.norm(position[:, :2] - position[i, :2], axis=1) for i in (0, -1))) > AWAY
    if not away.any():
        raise SimulationError(f"{action.name}: {pin} never leaves its place: nothing is rolled")
    low = away & (position[:, 2] < position[away, 2].min() + LOW)
    direction = pose.rotation[low].apply(axis)
    direction = np.mean(direction * np.sign(direction @ direction[0])[:, None], axis=0)
    yaw = float(np.arctan2(direction[1], direction[0]))
    turn = Rotation.from_euler("z", yaw)
    local = turn.inv().apply(position[low])
    first, last = np.percentile(local[:, 1], [10, 90])
    middle = np.array([np.median(local[:, 0]), 0.5 * (first + last), 0.0])
    length = float(np.clip(last - first, *LENGTH))
    origin = turn.apply(middle)
    origin[2] = support_height(action.scene)
    spacing = np.array([WIDTH / ACROSS, length / ALONG])
    x, y = ((np.arange(n) - 0.5 * (n - 1)) * step for n, step in zip((ACROSS, ALONG), spacing, strict=True))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Dough(RigidTransform.from_components(origin, turn), grid, spacing, radius, half_length, axis)


def add_dough(spec: mujoco.MjSpec, dough: Dough) -> None:
    """Add the columns, called ``dough/INDEX``: each slides down against friction and stays where it is pressed to."""
    import mujoco

    quaternion = dough.T_world_dough.rotation.as_quat(scalar_first=True)
    for index, (x, y) in enumerate(dough.grid):
        top = dough.T_world_dough.apply([x, y, THICKNESS])
        body = spec.worldbody.add_body(name=f"dough/{index}", pos=top, quat=quaternion, gravcomp=1.0)
        body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER  # asleep it would not spring back within its limits
        body.add_joint(
            name=f"dough/{index}",
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=[0.0, 0.0, 1.0],
            limited=True,
            range=[THINNEST - THICKNESS, 0.0],
            frictionloss=YIELD,
            solref_friction=[STOPPING, 1.0],
            damping=[5.0, 0.0, 0.0],
        )
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[TIP, 0.0, 0.0],
            pos=[0.0, 0.0, -TIP],
            mass=COLUMN_MASS,
            contype=DOUGH[0],
            conaffinity=DOUGH[1],
            group=3,
        )
        half = 0.5 * THICKNESS
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[*(0.5 * dough.spacing), half],
            pos=[0.0, 0.0, -half],
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=[0.93, 0.86, 0.68, 1.0],
        )


def _roller(model: ObjectModel) -> tuple[float, float, Float[np.ndarray, " 3"]]:
    """Radius, half length and axis of the thickest round part."""
    round_parts = [part for part in model.geometry if part.kind in ("cylinder", "capsule")]
    if not round_parts:
        raise SimulationError(f"object {model.name!r} has no round part to roll with")
    part = max(round_parts, key=lambda one: float(one.size[0]))
    return float(part.size[0]), float(part.size[1]), part.T_object_primitive.rotation.apply([0.0, 0.0, 1.0])
