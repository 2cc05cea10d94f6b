"""Contacts that should not be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Int

from sbam.robots.collision_pairs import hand_bodies
from sbam.robots.composition import OBJECT_PREFIX
from sbam.tasks.action import Action
from sbam.tasks.record import Contact

if TYPE_CHECKING:
    import mujoco

DEPTH = 2e-4  # m: shallower contacts are mere touches


class ContactWatch:
    """Collects contacts of the robot with anything it does not hold, and of moved objects with other objects.

    Objects may stand on furniture; what a hand holds may touch that hand.
    """

    def __init__(self, model: mujoco.MjModel, action: Action) -> None:
        names = [model.body(body).name for body in range(model.nbody)]
        robot = set(action.arms.robot.frame_names) if action.arms else set()
        self._body = model.geom_bodyid
        self._names = [name.removeprefix(OBJECT_PREFIX) for name in names]
        movable = {OBJECT_PREFIX + name for name, one in action.scene.objects.items() if one.movable}
        fixed = {OBJECT_PREFIX + name for name, one in action.scene.objects.items() if not one.movable}
        kind = np.array([1 if n in robot else 2 if n in movable else 3 if n in fixed else 0 for n in names])
        self._kind = kind[self._body]
        self._allowed = {
            tuple(sorted((names.index(body), names.index(OBJECT_PREFIX + grip.object))))
            for grip in (action.arms.grips if action.arms else ())
            for body in hand_bodies(action.arms.robot, grip.hand)  # pyright: ignore[reportOptionalMemberAccess]
        }
        self._found: dict[tuple[int, int], tuple[float, float, float]] = {}

    def look(self, data: mujoco.MjData, time: float, lasting: float) -> None:
        """Note the contacts of this moment, which stands for a stretch of time, s."""
        count = data.ncon
        if not count:
            return
        geoms: Int[np.ndarray, "contacts 2"] = data.contact.geom
        depth = -data.contact.dist
        kinds = np.sort(self._kind[geoms], axis=1)
        matters = ((kinds[:, 0] == 1) | ((kinds[:, 0] == 2) & (kinds[:, 1] == 2))) & (depth > DEPTH)
        deepest: dict[tuple[int, int], float] = {}
        for index in np.flatnonzero(matters):
            first, second = sorted(int(body) for body in self._body[geoms[index]])
            if (first, second) not in self._allowed:
                deepest[first, second] = max(deepest.get((first, second), 0.0), float(depth[index]))
        for pair, now in deepest.items():
            start, total, worst = self._found.get(pair, (time, 0.0, 0.0))
            self._found[pair] = start, total + lasting, max(worst, now)

    def contacts(self) -> tuple[Contact, ...]:
        """All that were found, the first first."""
        found = sorted(self._found.items(), key=lambda item: item[1][0])
        return tuple(Contact(self._names[a], self._names[b], *values) for (a, b), values in found)
