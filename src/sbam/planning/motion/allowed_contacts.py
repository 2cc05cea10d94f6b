"""What may touch on purpose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from sbam.planning.motion.timeline import Phase
from sbam.planning.motion.transfer import LINE_TIME
from sbam.planning.task import Task
from sbam.robots import ObjectHand, Robot
from sbam.robots.collision import CollisionModel


def meeting_objects(task: Task) -> list[tuple[str, str]]:
    """Pairs of objects whose regions the model brings together on purpose; they may touch."""
    pairs = {
        tuple(sorted(task.binding[role] for role in change.pair.roles))
        for change in task.model.changes
        if len(change.pair.roles) == 2
    }
    return [(first, second) for first, second in sorted(pairs)]


def collision_model(task: Task, robot: Robot) -> CollisionModel:
    """Shapes of a robot and a task's objects; what the action brings together is not compared."""
    return CollisionModel(robot, task.scene.objects, allowed=meeting_objects(task))


def touching_hands(
    task: Task, phases: Sequence[Phase], clock: Float[np.ndarray, " ticks"]
) -> dict[ObjectHand, Bool[np.ndarray, " ticks"]]:
    """(object, hand) -> when it may touch the object: on the straight ways to and from it, and between."""
    masks = {}
    for moved in task.moved:
        for hand in moved.hands:
            phase = {p.name: p for p in phases if p.role == moved.role and p.hand == hand}
            begin, end = phase["grasp"].start - LINE_TIME, phase["place"].end + LINE_TIME
            masks[ObjectHand(moved.name, hand)] = (clock >= begin) & (clock <= end)
    return masks
