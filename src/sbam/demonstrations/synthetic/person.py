"""The person who demonstrates: where they stand, where their hands rest, and how a hand takes and leaves things.

Agent frame: x right, y forward, z up, origin on the table top under the trunk. Hand frame: origin in the middle of the
palm, x from the wrist to the fingers, z out of the palm towards what it holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand
from sbam.demonstrations.synthetic.motion import UP, between, upright, wander
from sbam.scene.object_model import ObjectModel

TABLE = "kitchen_sideboard"


@dataclass(frozen=True)
class Person:
    """A grown-up standing at the table.

    Attributes:
        name: for reports.
        stature: body height, m.
        shoulder_height: of the shoulder joints above the table top, m.
        shoulder_width: distance between the shoulder joints, m.
        arm_length: from the shoulder joint to the palm, m.
        tempo: factor on all durations; above 1 is slower.
    """

    name: str
    stature: float
    shoulder_height: float
    shoulder_width: float
    arm_length: float
    tempo: float

    @property
    def scale(self) -> float:
        """Size relative to a person of 1.75 m."""
        return self.stature / 1.75


PERSONS = (
    Person("tall", 1.79, 0.55, 0.36, 0.64, 1.0),
    Person("short", 1.68, 0.52, 0.33, 0.60, 1.04),
)
"""Two statures, the range of the subjects of the KIT Bimanual Manipulation Dataset."""


@dataclass(frozen=True)
class HandTimes:
    """When one hand does what, s.

    Attributes:
        start: leaves its rest.
        grasp: has reached the object and closes.
        lift: the object leaves the table.
        place: the object stands again.
        leave: lets go and draws back.
        rest: is back at rest.
    """

    start: float
    grasp: float
    lift: float
    place: float
    leave: float
    rest: float


def stand_at_table(rng: np.random.Generator, table: ObjectModel) -> tuple[RigidTransform, RigidTransform]:
    """Where table and person stand: the person at world +x, looking along -x, as in the KIT recordings.

    Args:
        rng: source of their places (a few centimetres).
        table: object with the affordance ``place onto``.

    Returns:
        T_world_table and T_world_agent; the latter's origin lies on the table top.
    """
    T_world_table = RigidTransform.from_components(
        np.array([-0.35, -0.21, 0.855]) + rng.normal(0.0, (0.01, 0.02, 0.0)),
        upright(table.up, -0.5 * np.pi + rng.normal(0.0, 0.02)),
    )
    top = float(T_world_table.apply(table.region("place onto").center)[2])
    spot = np.array([0.19, -0.12, top]) + rng.normal(0.0, (0.02, 0.02, 0.0))
    return T_world_table, RigidTransform.from_components(spot, upright(UP, 0.5 * np.pi))


def rest_pose(rng: np.random.Generator, person: Person, hand: Hand) -> RigidTransform:
    """Hand lying on the table beside the workspace, palm down; agent frame."""
    side = -1.0 if hand == "left" else 1.0
    position = np.array([side * 0.29, 0.27, 0.035]) * (person.scale, person.scale, 1.0)
    inwards = side * np.deg2rad(rng.normal(25.0, 6.0))
    return RigidTransform.from_components(
        position + rng.normal(0.0, (0.015, 0.015, 0.003)), palm_down() * Rotation.from_rotvec((0.0, 0.0, -inwards))
    )


def palm_down() -> Rotation:
    """Palm facing down, fingers pointing forward; agent frame."""
    return Rotation.from_matrix(np.column_stack([(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)]))


def palm_towards(hand: Hand, azimuth: float, fingers_up: float) -> Rotation:
    """Thumb up, palm facing a horizontal direction, as a vessel is held from the side; agent frame.

    Args:
        hand: which hand; the fingers point away from the wrist on its side.
        azimuth: direction that the palm faces, rad from x_agent (right) towards y_agent (forward).
        fingers_up: how far the fingers point up, rad.
    """
    facing = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    side = 1.0 if hand == "left" else -1.0
    fingers = side * np.cross(UP, facing) * np.cos(fingers_up) + np.sin(fingers_up) * UP
    return Rotation.from_matrix(np.column_stack([fingers, np.cross(facing, fingers), facing]))


def take_and_leave(
    rng: np.random.Generator,
    time: NDArray[np.float64],
    times: HandTimes,
    rest: tuple[RigidTransform, RigidTransform],
    T_agent_held: RigidTransform,
    detour: ArrayLike,
) -> RigidTransform:
    """Poses of a hand that reaches for an object, holds it and draws back.

    Args:
        rng: source of the slip in the grasp (1 mm, 0.6 degrees).
        time: (T,) s.
        times: when the hand does what.
        rest: pose at rest before and after.
        T_agent_held: T poses that the hand has while it holds.
        detour: (3,) m, how far the reach and the retreat bulge out, agent frame.

    Returns:
        T poses in the agent frame.
    """
    holding = between(time, (times.start, times.grasp - times.start), (times.leave, times.rest - times.leave))
    early = (time < 0.5 * (times.lift + times.place))[:, None]
    rest_position = np.where(early, rest[0].translation, rest[1].translation)
    rest_turn = Rotation.from_quat(np.where(early, rest[0].rotation.as_quat(), rest[1].rotation.as_quat()))
    slip = wander(rng, time, 0.001, (0.1, 0.6))
    turn_slip = Rotation.from_rotvec(wander(rng, time, np.deg2rad(0.6), (0.1, 0.6)) * holding[:, None])
    weight = holding[:, None]
    position = rest_position + weight * (T_agent_held.translation + slip - rest_position)
    position += 16.0 * weight**2 * (1.0 - weight) ** 2 * np.asarray(detour, dtype=float)
    to_held = (rest_turn.inv() * T_agent_held.rotation * turn_slip).as_rotvec()
    return RigidTransform.from_components(position, rest_turn * Rotation.from_rotvec(weight * to_held))
