"""Hollow vessels: shells of boxes along a profile, and the spheres that fill them."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial.transform import Rotation

from sbam.scene import ObjectModel, VesselProfile, upright_rotation
from sbam.tasks.materials import PARTICLE, SHELL, add_sphere, physics_options

if TYPE_CHECKING:
    import mujoco

SIDES = 12
SPHERE_RADIUS = 0.006  # m
PACKING = 0.56  # share of a vessel's volume that loose spheres take
MOST_SPHERES = 40
OPACITY = 0.35
PLAIN = np.full(3, 0.7)


def sphere_count(model: ObjectModel) -> int:
    """How many spheres fill a vessel to its level; at most `MOST_SPHERES`."""
    single = 4.0 / 3.0 * np.pi * SPHERE_RADIUS**3
    assert model.profile is not None
    return min(MOST_SPHERES, round(PACKING * model.profile.fill_volume / single))


def add_shell(
    body: mujoco.MjsBody,
    profile: VesselProfile,
    up: Float[np.ndarray, " 3"],
    bits: tuple[int, int],
    rgb: Float[np.ndarray, " 3"] = PLAIN,
) -> None:
    """Add the walls and the floor of a vessel to its body.

    Every stretch of the profile becomes `SIDES` boxes whose inner faces touch the cone from outside at mid-face, so
    that the hollow is never narrower than the profile; neighbours overlap at the corners.

    Args:
        body: the vessel's body.
        profile: its hollow.
        up: axis of the profile in the body's frame.
        bits: MuJoCo's contype and conaffinity of the boxes.
        rgb: colour.
    """
    import mujoco

    stand = upright_rotation(up, 0.0).inv()  # from "z up" into the body's frame

    def add(
        kind: mujoco.mjtGeom, center: Float[np.ndarray, " 3"], rotation: Rotation, size: Float[np.ndarray, " 3"]
    ) -> None:
        body.add_geom(
            type=kind,
            pos=stand.apply(center),
            quat=(stand * rotation).as_quat(scalar_first=True),
            size=size,
            rgba=[*rgb[:3], OPACITY],
            contype=bits[0],
            conaffinity=bits[1],
            mass=0.0,
        )

    half = 0.5 * profile.wall
    for low, high, inner, outer in zip(
        profile.heights[:-1], profile.heights[1:], profile.radii[:-1], profile.radii[1:], strict=True
    ):
        slope = np.arctan2(outer - inner, high - low)
        length = float(np.hypot(high - low, outer - inner))
        width = (max(inner, outer) + profile.wall) * np.tan(np.pi / SIDES)
        for side in range(SIDES):
            around = Rotation.from_euler("z", 2.0 * np.pi * side / SIDES)
            leaning = around * Rotation.from_euler("y", slope)
            middle = np.array([0.5 * (inner + outer), 0.0, 0.5 * (low + high)])
            center = around.apply(middle) + leaning.apply([half, 0.0, 0.0])
            add(mujoco.mjtGeom.mjGEOM_BOX, center, leaning, np.array([half, width, 0.5 * length]))
    radius = float(profile.radii[0]) + profile.wall
    floor = np.array([0.0, 0.0, profile.heights[0] - half])
    add(mujoco.mjtGeom.mjGEOM_CYLINDER, floor, Rotation.identity(), np.array([radius, half, 0.0]))


def inside(model: ObjectModel, local: Float[np.ndarray, "*batch 3"]) -> Bool[np.ndarray, "*batch"]:
    """Whether points in an object's frame are within its hollow, walls included."""
    assert model.profile is not None
    profile = model.profile
    height = local @ model.up
    aside = np.linalg.norm(local - height[..., None] * model.up, axis=-1)
    radius = np.interp(height, profile.heights, profile.radii) / np.cos(np.pi / SIDES) + profile.wall
    return (height > profile.heights[0] - profile.wall) & (height < profile.heights[-1]) & (aside < radius)


def settled_spheres(model: ObjectModel, count: int) -> Float[np.ndarray, "spheres 3"]:
    """Where spheres come to rest in an upright vessel, in the object's frame, m."""
    assert model.profile is not None
    profile = model.profile
    key = tuple(profile.heights.tolist()), tuple(profile.radii.tolist()), profile.wall, count
    return upright_rotation(model.up, 0.0).inv().apply(_settle(*key).copy())


@lru_cache(maxsize=32)
def _settle(
    heights: tuple[float, ...], radii: tuple[float, ...], wall: float, count: int
) -> Float[np.ndarray, "spheres 3"]:
    """Spheres fall one after the other into a vessel that stands still; z up."""
    import mujoco

    profile = VesselProfile(np.array(heights), np.array(radii), wall)
    spec = mujoco.MjSpec()
    physics_options(spec)
    add_shell(spec.worldbody.add_body(name="vessel"), profile, np.array([0.0, 0.0, 1.0]), SHELL)
    for index in range(count):
        add_sphere(spec, index, SPHERE_RADIUS, *PARTICLE)
    model = spec.compile()
    data = mujoco.MjData(model)
    generator = np.random.default_rng(count)
    position = data.qpos.reshape(count, 7)
    velocity = data.qvel.reshape(count, 6)
    position[:, :3] = np.column_stack([np.arange(count) * 0.05 + 1.0, np.zeros(count), np.full(count, 5.0)])
    waiting = position.copy()
    every = round(0.06 / model.opt.timestep)
    for step in range(every * count + round(0.6 / model.opt.timestep)):
        landed = min(step // every + 1, count)
        if step % every == 0 and step // every < count:
            top = max(position[: landed - 1, 2].max(initial=heights[0]) + 2.0 * SPHERE_RADIUS, heights[0] + 0.02)
            room = max(float(np.interp(top, heights, radii)) - SPHERE_RADIUS, 0.0)
            angle, share = generator.uniform(0.0, 2.0 * np.pi), generator.uniform(0.0, 0.9)
            position[landed - 1, :3] = room * share * np.cos(angle), room * share * np.sin(angle), top
            velocity[landed - 1] = 0.0
        position[landed:], velocity[landed:] = waiting[landed:], 0.0
        mujoco.mj_step(model, data)
    result = position[:, :3].copy()
    result.setflags(write=False)
    return result
