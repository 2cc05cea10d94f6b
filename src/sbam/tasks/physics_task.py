"""What a task is to physics: what it adds to the world, what it measures, and what must be true."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from sbam.tasks.action import Action
from sbam.tasks.record import Record

if TYPE_CHECKING:
    import mujoco

Values = Mapping[str, Any]
"""Name with unit -> number, or lists of plain data for the report."""


class PhysicsTask(ABC):
    """Base of all tasks as physics tries them: a task of your own needs only `measure` and `judge`.

    Attributes:
        name: what it is called on the command line.
        affordances: affordances that a scene's objects bear if this task can be tried with them.
    """

    name: str = ""
    affordances: Sequence[str] = ()

    def build(self, spec: mujoco.MjSpec, action: Action) -> None:
        """Add to the world what the objects alone do not hold: spheres, dough. Nothing by default."""
        return

    def start(self, model: mujoco.MjModel, data: mujoco.MjData, action: Action) -> None:
        """Put what was added where it is at the start. Nothing by default."""
        return

    def observe(self, model: mujoco.MjModel, data: mujoco.MjData, action: Action) -> dict[str, Float[np.ndarray, ...]]:
        """What to record in every frame beside poses and spheres. Nothing by default."""
        return {}

    @abstractmethod
    def measure(self, action: Action, record: Record) -> Values:
        """Numbers of the report, from what happened."""

    def moment(self, values: Values) -> float | None:
        """When a failure shows best, s; None, the default, for the middle of the action."""
        return None

    @abstractmethod
    def judge(self, values: Values, yardstick: Values | None) -> list[str]:
        """A sentence for each thing that is not as it must be; none means success.

        Args:
            values: what `measure` returned.
            yardstick: means of the numbers over the demonstrations' replays, or None where there are none.
        """

    def fits(self, action: Action) -> bool:
        """Whether the scene holds objects for this task."""
        borne = {affordance for model in action.scene.objects.values() for affordance in model.affordances}
        return set(self.affordances) <= borne
