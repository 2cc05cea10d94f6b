"""Rolling: dough shall be as thin where the pin went as was planned, and as in the demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from sbam.robots.composition import OBJECT_PREFIX
from sbam.tasks.action import Action
from sbam.tasks.physics_task import PhysicsTask, Values
from sbam.tasks.record import Record
from sbam.tasks.rolling.dough import THICKNESS, add_dough, lay_dough
from sbam.tasks.rolling.geometry import turning_points

if TYPE_CHECKING:
    import mujoco

OFF_PLAN = 1.0  # mm: how far the thickness may be off what the pin's planned path leaves
THICKER = 2.0  # mm: how much thicker than in the demonstrations it may be on average
THINNED_ALONE = 0.8  # of its first thickness, where there is no demonstration to compare with
STROKES = 0.8  # of the half-strokes of the demonstrations
FINE = 0.002  # s between the poses whose lowest counts: a pin at 0.5 m/s moves 1 mm
PRESSING = 1.0  # N: beyond it the pin counts as pressing


class Rolling(PhysicsTask):
    """A pin with ``handle left`` and ``handle right`` rolls over dough that lies where it shall roll."""

    name = "rolling"
    affordances = ("handle left", "handle right")

    def build(self, spec: mujoco.MjSpec, action: Action) -> None:
        """Add the dough."""
        add_dough(spec, lay_dough(action, action.object_with("handle left")))

    def observe(self, model: mujoco.MjModel, data: mujoco.MjData, action: Action) -> dict[str, Float[np.ndarray, ...]]:
        """Thickness of every column, m, and the vertical force of the pin on the dough, N."""
        import mujoco

        columns = sum(model.body(body).name.startswith("dough/") for body in range(model.nbody))
        address = int(model.joint("dough/0").qposadr[0])
        first = int(model.body("dough/0").id)
        pin = int(model.body(OBJECT_PREFIX + action.object_with("handle left")).id)
        force, total = np.zeros(6), 0.0
        bodies = model.geom_bodyid[data.contact.geom] if data.ncon else np.zeros((0, 2), dtype=int)
        dough = (bodies >= first) & (bodies < first + columns)
        for index in np.flatnonzero(dough.any(axis=1) & (bodies == pin).any(axis=1)):
            mujoco.mj_contactForce(model, data, int(index), force)
            normal = data.contact.frame[index].reshape(3, 3)[0]
            total += abs(float(force[0] * normal[2]))
        return {
            "thickness": THICKNESS + data.qpos[address : address + columns].copy(),
            "force": np.array(total),
        }

    def measure(self, action: Action, record: Record) -> Values:
        """Final thickness and how far it is off the plan, force, strokes, closure of the two-handed grasp."""
        pin = action.object_with("handle left")
        dough = lay_dough(action, pin)
        wanted = dough.pressed_by(action.poses(pin, np.arange(0.0, action.duration, FINE)))
        rolled = wanted < THICKNESS - 1e-4
        final = record.measured["thickness"][-1]
        force = record.measured["force"]
        pressing = force[force > PRESSING]
        middle = record.T_world_object[pin].translation
        turns = turning_points(middle)
        lengths = np.linalg.norm(np.diff(middle[turns, :2], axis=0), axis=1)
        values: dict[str, float] = {
            "force is largest [s]": float(record.time[np.argmax(force)]),
            "thickness, mean [mm]": float(1e3 * final.mean()),
            "thickness, least [mm]": float(1e3 * final.min()),
            "thickness, most [mm]": float(1e3 * final.max()),
            "planned thickness, mean [mm]": float(1e3 * np.minimum(wanted, THICKNESS).mean()),
            "rolled share": float(rolled.mean()),
            "half-strokes": float(max(len(turns) - 1, 0)),
            "force, most [N]": float(force.max()),
            "force while pressing, mean [N]": float(pressing.mean()) if len(pressing) else 0.0,
            "hands slip on the pin, most [mm]": 1e3 * max((slip.most for slip in record.slip.values()), default=0.0),
        }
        if len(lengths):
            values["half-stroke, mean [mm]"] = float(1e3 * lengths.mean())
        if rolled.any():
            off = 1e3 * np.abs(final - wanted)[rolled]
            values["off the planned thickness, mean [mm]"] = float(off.mean())
            values["off the planned thickness, 95 % [mm]"] = float(np.percentile(off, 95))
        return {
            **values,
            "profile": {
                "along the pin [m]": dough.grid[:, 0].tolist(),
                "along the strokes [m]": dough.grid[:, 1].tolist(),
                "thickness [m]": final.tolist(),
                "planned thickness [m]": np.minimum(wanted, THICKNESS).tolist(),
            },
            "series": {"time [s]": record.time.tolist(), "force [N]": force.tolist()},
        }

    def moment(self, values: Values) -> float | None:
        """When the pin pressed most."""
        return values["force is largest [s]"]

    def judge(self, values: Values, yardstick: Values | None) -> list[str]:
        """Thickness within 1 mm of the plan, at most 2 mm more than demonstrated, and no stroke left out."""
        problems = []
        off = values.get("off the planned thickness, 95 % [mm]", 0.0)
        if off > OFF_PLAN:
            problems.append(f"the dough is up to {off:.1f} mm off its planned thickness ({OFF_PLAN:g} mm allowed)")
        thickness = values["thickness, mean [mm]"]
        limit = yardstick["thickness, mean [mm]"] + THICKER if yardstick else 1e3 * THINNED_ALONE * THICKNESS
        if thickness > limit:
            problems.append(f"the dough stays {thickness:.2f} mm thick, at most {limit:.2f} mm needed")
        if yardstick and values["half-strokes"] < STROKES * yardstick["half-strokes"]:
            problems.append(f"{values['half-strokes']:.0f} half-strokes instead of {yardstick['half-strokes']:.0f}")
        return problems
