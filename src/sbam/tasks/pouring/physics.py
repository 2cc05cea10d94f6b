"""Pouring: what leaves the bottle shall be in the cup, and as much shall leave it as in the demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sbam.errors import SimulationError
from sbam.scene import ObjectModel, support_height
from sbam.tasks.action import Action
from sbam.tasks.materials import PARTICLE, add_sphere
from sbam.tasks.physics_task import PhysicsTask, Values
from sbam.tasks.pouring.geometry import mouth_path
from sbam.tasks.record import Record
from sbam.tasks.vessel import SPHERE_RADIUS, inside, settled_spheres, sphere_count

if TYPE_CHECKING:
    import mujoco

POURED = 0.90  # of what the demonstrations pour
SPILLED = 0.02  # of the content, more than the demonstrations spill
POURED_ALONE = 0.5  # of the content, where there is no demonstration to compare with


class Pouring(PhysicsTask):
    """The vessel with ``pour from`` is filled with spheres; they shall end in the one with ``pour into``."""

    name = "pouring"
    affordances = ("pour from", "pour into")

    def build(self, spec: mujoco.MjSpec, action: Action) -> None:
        """Add the spheres that fill the vessel to its level."""
        for index in range(sphere_count(_filled(action)[1])):
            add_sphere(spec, index, SPHERE_RADIUS, *PARTICLE)

    def start(self, model: mujoco.MjModel, data: mujoco.MjData, action: Action) -> None:
        """Put the spheres where they come to rest."""
        name, vessel = _filled(action)
        local = settled_spheres(vessel, sphere_count(vessel))
        for index, position in enumerate(action.scene.T_world_object[name].apply(local)):
            address = int(model.jnt_qposadr[int(model.body(f"particle/{index}").jntadr[0])])
            data.qpos[address : address + 3] = position

    def measure(self, action: Action, record: Record) -> Values:
        """Shares poured, caught and spilled, where and when; tilt and distance of mouth and rim over time."""
        source, vessel = _filled(action)
        target = action.object_with("pour into")
        cup = action.scene.objects[target]
        T_world_bottle, T_world_cup = record.T_world_object[source], record.T_world_object[target]
        count = record.particles.shape[1]
        frames = len(record.time)
        in_bottle, in_cup = (
            np.stack([inside(model, pose[i].inv().apply(record.particles[i])) for i in range(frames)])
            for model, pose in ((vessel, T_world_bottle), (cup, T_world_cup))
        )
        caught = in_cup[-1] & ~in_bottle[-1]
        lost = ~in_bottle[-1] & ~caught
        mouth = mouth_path(vessel, T_world_bottle, T_world_cup.apply(cup.region("pour into").center))
        tilt, aside, above = np.rad2deg(mouth.tilt), 1e3 * mouth.aside, 1e3 * mouth.above
        tilted = mouth.may_flow
        poured = 1.0 - in_bottle.mean(axis=1)
        flowing = np.flatnonzero(np.diff(poured) > 0)
        values = {
            "spheres": float(count),
            "poured": float(poured[-1]),
            "in the cup": float(caught.mean()),
            "spilled": float(lost.mean()),
            "largest tilt [deg]": float(tilt.max()),
            "tilt is largest [s]": float(record.time[np.argmax(tilt)]),
            "tilted for [s]": float(tilted.sum() * np.diff(record.time).mean()),
        }
        if tilted.any():
            values["mouth aside while tilted, most [mm]"] = float(aside[tilted].max())
            values["mouth above while tilted, least [mm]"] = float(above[tilted].min())
        if len(flowing):
            values["flow begins [s]"] = float(record.time[flowing[0]])
            values["flow ends [s]"] = float(record.time[flowing[-1] + 1])
        return {
            **values,
            "spills": [_spill(action, record, in_bottle[:, i], int(i)) for i in np.flatnonzero(lost)],
            "series": {
                "time [s]": record.time.tolist(),
                "tilt [deg]": tilt.tolist(),
                "mouth aside [mm]": aside.tolist(),
                "mouth above [mm]": above.tolist(),
                "poured": poured.tolist(),
                "in the cup": (in_cup & ~in_bottle).mean(axis=1).tolist(),
            },
        }

    def moment(self, values: Values) -> float | None:
        """When the first sphere was spilled, else the largest tilt."""
        return min((spill["time [s]"] for spill in values["spills"]), default=values["tilt is largest [s]"])

    def judge(self, values: Values, yardstick: Values | None) -> list[str]:
        """At least 90 % of what the demonstrations pour, and at most 2 % more spilled than they spill."""
        least = POURED * yardstick["poured"] if yardstick else POURED_ALONE
        most = SPILLED + (yardstick["spilled"] if yardstick else 0.0)
        problems = []
        if values["poured"] < least:
            problems.append(
                f"{values['poured']:.0%} poured, {least:.0%} needed; the largest tilt is "
                f"{values['largest tilt [deg]']:.0f} degrees"
            )
        if values["spilled"] > most:
            where = "; ".join(
                f"at {one['time [s]']:.1f} s, {1e3 * one['aside [m]']:.0f} mm from the cup's axis"
                for one in values["spills"][:3]
            )
            problems.append(f"{values['spilled']:.0%} spilled, {most:.0%} allowed ({where})")
        return problems


def _filled(action: Action) -> tuple[str, ObjectModel]:
    """Name and model of the vessel that is poured from."""
    name = action.object_with("pour from")
    model = action.scene.objects[name]
    cup = action.scene.objects[action.object_with("pour into")]
    for one, filled in ((model, True), (cup, False)):
        if one.profile is None or (filled and one.profile.fill is None):
            wanted = "`profile` with a `fill` level" if filled else "`profile`"
            raise SimulationError(f"object {one.name!r} has no {wanted} in its object file: it cannot be poured with")
    return name, model


def _spill(action: Action, record: Record, in_bottle: np.ndarray, index: int) -> dict[str, object]:
    """When a sphere left the bottle, and where it came down."""
    left = int(np.flatnonzero(in_bottle)[-1]) + 1 if in_bottle.any() else 0
    path = record.particles[left:, index]
    low = np.flatnonzero(path[:, 2] < support_height(action.scene) + 3.0 * SPHERE_RADIUS)
    landed = int(low[0]) if len(low) else len(path) - 1
    cup = record.T_world_object[action.object_with("pour into")][left + landed].translation
    return {
        "time [s]": float(record.time[left]),
        "position in the agent frame [m]": action.scene.T_world_agent.inv().apply(path[landed]).tolist(),
        "aside [m]": float(np.hypot(*(path[landed] - cup)[:2])),
    }
