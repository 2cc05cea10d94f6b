"""Stirring: the tip of the spoon stays in the cup while it stirs, and the cup stays where it is.

Used as `sbam simulate PLAN --task examples/tasks/stirring.py`. The spoon bears `stir with` at its tip, the cup bears
`stir in` at its rim.
"""

import numpy as np

from sbam.tasks import PhysicsTask
from sbam.tasks.vessel import inside

TURNS = 1.0  # that are needed
SHOVED = 0.02  # m that the cup may be shoved


class Stirring(PhysicsTask):
    """Judges where the tip of the spoon goes."""

    name = "stirring"
    affordances = ("stir with", "stir in")

    def measure(self, action, record):
        """How long the tip is in the cup, how often it goes round, and how far the cup is shoved."""
        spoon, cup = action.object_with("stir with"), action.object_with("stir in")
        vessel = action.scene.objects[cup]
        tip = record.T_world_object[spoon].apply(action.scene.objects[spoon].region("stir with").center)
        T_world_cup = record.T_world_object[cup]
        local = np.stack([pose.inv().apply(point) for pose, point in zip(T_world_cup, tip, strict=True)])
        within = inside(vessel, local)
        entered = np.flatnonzero(within)
        during = slice(entered[0], entered[-1] + 1) if len(entered) else slice(0, 0)
        around = (tip - T_world_cup.translation)[during]
        angle = np.unwrap(np.arctan2(around[:, 1], around[:, 0]))
        shoved = np.linalg.norm((T_world_cup.translation - T_world_cup.translation[0])[:, :2], axis=1)
        return {
            "in the cup [s]": float(within.sum() * np.diff(record.time).mean()),
            "left the cup while stirring": float((~within[during]).sum()),
            "turns": float(np.abs(angle[-1] - angle[0]) / (2 * np.pi)) if len(angle) else 0.0,
            "cup shoved, most [m]": float(shoved.max()),
        }

    def judge(self, values, yardstick):
        """The tip stays in the cup, goes round often enough, and the cup stays."""
        turns = 0.9 * yardstick["turns"] if yardstick else TURNS
        problems = []
        if values["left the cup while stirring"]:
            problems.append("the spoon leaves the cup while it stirs")
        if values["turns"] < turns:
            problems.append(f"{values['turns']:.1f} turns, {turns:.1f} needed")
        if values["cup shoved, most [m]"] > SHOVED:
            problems.append(f"the cup is shoved by {1e3 * values['cup shoved, most [m]']:.0f} mm")
        return problems


TASK = Stirring()
