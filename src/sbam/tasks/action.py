"""A motion to be tried in physics: the objects, and the arms that move them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Slerp

from sbam.demonstrations.demonstration import Hand
from sbam.errors import SimulationError
from sbam.planning.trajectory.trajectory import JointTrajectory
from sbam.robots import Robot
from sbam.scene import Scene


@dataclass(frozen=True)
class Grip:
    """One hand's hold of one object, assumed rigid from ``start`` to ``end``.

    Attributes:
        hand: the arm.
        object: name in the scene.
        T_object_tcp: pose of the tool centre point in the object's frame.
        width: opening of the fingers when they hold, m.
        start: when it holds, s: the fingers have closed and the object is about to be lifted.
        end: when it lets go, s: the object stands and the fingers are about to open.
        closing: when the fingers begin to close, s.
        opened: when they are open again, s.
    """

    hand: Hand
    object: str
    T_object_tcp: RigidTransform
    width: float
    start: float
    end: float
    closing: float
    opened: float


@dataclass(frozen=True)
class Arms:
    """A robot that moves the objects.

    Attributes:
        robot: the robot, standing in the scene's world.
        trajectory: the timed joint trajectory.
        grips: which hand holds what, when.
    """

    robot: Robot
    trajectory: JointTrajectory
    grips: tuple[Grip, ...]


@dataclass(frozen=True)
class Action:
    """A motion to be tried in physics.

    Attributes:
        name: for reports.
        scene: the starting scene.
        roles: role -> object name, as far as known.
        time: s from 0.
        T_world_object: moved object -> poses that are wanted.
        arms: the robot that moves them; None for objects that are led along their poses, as a demonstration shows them.
    """

    name: str
    scene: Scene
    roles: Mapping[str, str]
    time: Float[np.ndarray, " samples"]
    T_world_object: Mapping[str, RigidTransform]
    arms: Arms | None = None

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(self.time[-1])

    def object_with(self, affordance: str) -> str:
        """Name of the object that plays the role of this affordance.

        Raises:
            SimulationError: if no object or more than one bears it and no role says which.
        """
        role = affordance.replace(" ", "_")
        if role in self.roles:
            return self.roles[role]
        bearing = [name for name, model in self.scene.objects.items() if affordance in model.affordances]
        if len(bearing) != 1:
            found = ", ".join(bearing) or "none"
            raise SimulationError(
                f"{self.name}: one object with affordance {affordance!r} is needed; there are: {found}"
            )
        return bearing[0]

    def poses(self, name: str, times: Float[np.ndarray, " times"]) -> RigidTransform:
        """Wanted poses of a moved object at times, s."""
        pose, times = self.T_world_object[name], np.clip(times, self.time[0], self.time[-1])
        position = np.stack([np.interp(times, self.time, column) for column in pose.translation.T], axis=-1)
        return RigidTransform.from_components(position, Slerp(self.time, pose.rotation)(times))
