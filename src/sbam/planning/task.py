"""A task: an action model bound to a scene, and the objects that it moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionReference
from sbam.demonstrations.demonstration import Hand
from sbam.learning.model import ActionModel
from sbam.scene import ObjectModel, Scene


class RoleHand(NamedTuple):
    """A hand, and the role of what it holds: the key of grasps."""

    role: str
    hand: Hand


@dataclass(frozen=True)
class MovedObject:
    """An object that the task moves. Poses are in the agent frame; times on the model's time axis, s.

    Attributes:
        role: role of the action model.
        name: name in the scene.
        model: what is known of it.
        hands: the hands that hold it; the first carries it, a second one closes the loop.
        start: pose at the start.
        put_down: pose at the end.
        lift: when it starts to move.
        place: when it stands still again.
        grasp: when it is grasped.
        release: when it is let go.
        human_grasps: hand -> where people held such objects: from the object's origin, agent axes, m.
    """

    role: str
    name: str
    model: ObjectModel
    hands: tuple[Hand, ...]
    start: RigidTransform
    put_down: RigidTransform
    lift: float
    place: float
    grasp: float
    release: float
    human_grasps: Mapping[Hand, Float[np.ndarray, "demonstrations 3"]]


@dataclass(frozen=True)
class Task:
    """An action model bound to a scene.

    Attributes:
        model: the action model.
        scene: the scene.
        binding: role -> name of the object in the scene.
        T_agent_object: object name -> pose at the start, agent frame.
        moved: the objects that are moved.
    """

    model: ActionModel
    scene: Scene
    binding: Mapping[str, str]
    T_agent_object: Mapping[str, RigidTransform]
    moved: tuple[MovedObject, ...]

    @property
    def holds(self) -> tuple[tuple[MovedObject, RoleHand], ...]:
        """Every moved object with each hand that holds it."""
        return tuple((moved, RoleHand(moved.role, hand)) for moved in self.moved for hand in moved.hands)

    def region_center(self, reference: RegionReference) -> Float[np.ndarray, " 3"]:
        """Centre of a region in its object's frame, m."""
        return self.scene.objects[self.binding[reference.role]].region(reference.affordance).center

    def region_at_start(self, reference: RegionReference) -> Float[np.ndarray, " 3"]:
        """Centre of a region at the start, agent frame, m."""
        return self.T_agent_object[self.binding[reference.role]].apply(self.region_center(reference))
