"""What happened in physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform


@dataclass(frozen=True)
class Contact:
    """A contact between things that should not touch.

    Attributes:
        first: a body of the robot or an object.
        second: another.
        time: when it was first seen, s.
        seconds: how long it lasted in total, s.
        depth: largest penetration, m.
    """

    first: str
    second: str
    time: float
    seconds: float
    depth: float


@dataclass(frozen=True)
class Slip:
    """How far an object moved in a hand while it was held.

    Attributes:
        time: s.
        distance: of the grasp in the hand, m.
        angle: of the object in the hand, rad.
    """

    time: Float[np.ndarray, " frames"]
    distance: Float[np.ndarray, " frames"]
    angle: Float[np.ndarray, " frames"]

    @property
    def most(self) -> float:
        """Largest distance, m."""
        return float(self.distance.max())

    @property
    def most_angle(self) -> float:
        """Largest angle, rad."""
        return float(self.angle.max())


@dataclass(frozen=True)
class Record:
    """What happened.

    Attributes:
        time: s on the action's time axis; negative while things settle.
        T_world_object: every movable object -> poses in every frame.
        qpos: state of the model, for drawing.
        particles: centres of the spheres, world, m.
        measured: name -> whatever the task measured in every frame.
        contacts: contacts that should not be, the first first.
        tracking_error: joint -> largest distance from its command, rad or m; empty without a robot.
        torque_ratio: joint -> largest torque, share of its limit; empty without a robot.
        worst_tracking: when the largest of these distances was, s.
        slip: (hand, object) -> how far it moved in the hand.
        seconds: processor time of the physics, s.
        simulated: time that was simulated, s.
    """

    time: Float[np.ndarray, " frames"]
    T_world_object: Mapping[str, RigidTransform]
    qpos: Float[np.ndarray, "frames positions"]
    particles: Float[np.ndarray, "frames spheres 3"]
    measured: Mapping[str, Float[np.ndarray, "frames ..."]]
    contacts: tuple[Contact, ...]
    tracking_error: Mapping[str, float]
    torque_ratio: Mapping[str, float]
    worst_tracking: float
    slip: Mapping[tuple[str, str], Slip]
    seconds: float
    simulated: float
