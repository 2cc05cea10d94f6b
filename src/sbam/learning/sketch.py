"""Sketch of a demonstration: all that the learning needs of it, small enough to be kept in the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionPair, RegionReference, constraint_type
from sbam.demonstrations.demonstration import Demonstration, Hand
from sbam.demonstrations.events import Event, find_events
from sbam.demonstrations.holds import find_holds
from sbam.learning.generalization import pair_vector
from sbam.learning.movement_primitive import SketchedPath, sketch_path
from sbam.learning.pairs import against_support, candidate_pairs, pair_constraint
from sbam.learning.segmentation import segment
from sbam.learning.settings import LearningSettings
from sbam.scene.object_model import ObjectModel

_SAME_TIME = 1e-6
"""A sample this close to an event gives way to it, s."""


@dataclass(frozen=True)
class SketchedRole:
    """Who played a role in one demonstration.

    Attributes:
        role: name of the role.
        object: name of the object model.
        affordances: those of its affordances that appear in the watched pairs.
        moves: whether it was moved.
        start: where the centres of its regions were at the start, rows as ``affordances``, agent frame, m; None
            in models of earlier versions.
    """

    role: str
    object: str
    affordances: tuple[str, ...]
    moves: bool
    start: Float[np.ndarray, "regions 3"] | None = None


@dataclass(frozen=True)
class SketchedHold:
    """A hold in one demonstration.

    Attributes:
        role: what was held.
        hand: by which hand; None if the recording has no hands.
        grasp: s from the start of the demonstration.
        release: s from the start of the demonstration.
        hand_position: from the object's origin to the hand at the grasp, agent axes, m; None without hands.
        side: x of the object in the agent frame at the grasp, m: negative is to the agent's left.
    """

    role: str
    hand: Hand | None
    grasp: float
    release: float
    hand_position: Float[np.ndarray, " 3"] | None
    side: float


@dataclass(frozen=True)
class ChannelCandidates:
    """Keypoint candidates of one channel: times from the start of the demonstration, s, and values."""

    time: Float[np.ndarray, " candidates"]
    value: Float[np.ndarray, " candidates"]


@dataclass(frozen=True)
class PairCandidates:
    """Keypoint candidates of one pair, a polyline for every channel of its constraint type.

    ``from_agent`` is as in `sbam.learning.generalization.GeneralizedChange`.
    """

    pair: RegionPair
    constraint: str
    channels: tuple[ChannelCandidates, ...]
    from_agent: bool = False


@dataclass(frozen=True)
class DemonstrationSketch:
    """What the learning keeps of one demonstration.

    Attributes:
        name: name of the demonstration.
        duration: s.
        synthetic: whether the project generated it.
        roles: who played which role.
        events: what the objects did; `Event.object` is the role.
        holds: who held what.
        candidates: keypoint candidates of every pair; empty where a model only keeps generalised changes.
        notes: what was left out and why, a sentence each.
        paths: how what was moved went; empty in models of earlier versions.
    """

    name: str
    duration: float
    synthetic: bool
    roles: tuple[SketchedRole, ...]
    events: tuple[Event, ...]
    holds: tuple[SketchedHold, ...]
    candidates: tuple[PairCandidates, ...]
    notes: tuple[str, ...] = ()
    paths: tuple[SketchedPath, ...] = ()

    def without_candidates(self) -> DemonstrationSketch:
        """The same without the keypoint candidates."""
        return replace(self, candidates=())

    def region_at_start(self, region: RegionReference) -> Float[np.ndarray, " 3"] | None:
        """Where the centre of a region was at the start, m, agent frame; None if it was not kept."""
        role = next((role for role in self.roles if role.role == region.role), None)
        if role is None or role.start is None or region.affordance not in role.affordances:
            return None
        return role.start[role.affordances.index(region.affordance)]

    def event_time(self, kind: str, role: str) -> float | None:
        """Time of a role's first event of that kind, s, or None."""
        return next((event.time for event in self.events if event.kind == kind and event.object == role), None)


def sketch_demonstration(
    demonstration: Demonstration,
    objects: Mapping[str, str],
    models: Mapping[str, ObjectModel],
    constraint: str,
    settings: LearningSettings,
) -> DemonstrationSketch:
    """Reduce a demonstration to what the learning needs.

    Args:
        demonstration: the recording.
        objects: role -> name of the object in the recording.
        models: object name -> model.
        constraint: constraint type of the model.
        settings: pairs and segmentation.
    """
    role_of = {name: role for role, name in objects.items()}
    role_models = {role: models[name] for role, name in objects.items()}
    events = tuple(
        replace(event, object=role_of[event.object])
        for event in find_events(demonstration, models)
        if event.object in role_of
    )
    pairs = candidate_pairs(role_models, settings)
    regions = {region for pair in pairs for region in (pair.first, pair.second) if region is not None}
    moving = {event.object for event in events}
    T_agent_world = demonstration.T_world_agent.inv()
    return DemonstrationSketch(
        name=demonstration.name,
        duration=demonstration.duration,
        synthetic=demonstration.synthetic,
        roles=tuple(
            _sketched_role(
                role,
                model,
                tuple(sorted(r.affordance for r in regions if r.role == role)),
                role in moving,
                T_agent_world * demonstration.T_world_object[objects[role]][0],
            )
            for role, model in role_models.items()
        ),
        events=events,
        holds=_holds(demonstration, role_of, models),
        candidates=_candidates(demonstration, objects, role_models, pairs, events, constraint, settings),
        paths=tuple(sketch_path(demonstration, name, role) for role, name in objects.items() if role in moving),
    )


def _sketched_role(
    role: str, model: ObjectModel, affordances: tuple[str, ...], moves: bool, T_agent_object: RigidTransform
) -> SketchedRole:
    centers = np.array([model.region(affordance).center for affordance in affordances]).reshape(-1, 3)
    return SketchedRole(role, model.name, affordances, moves, T_agent_object.apply(centers))


def _holds(
    demonstration: Demonstration, role_of: Mapping[str, str], models: Mapping[str, ObjectModel]
) -> tuple[SketchedHold, ...]:
    holds = []
    T_agent_world = demonstration.T_world_agent.inv()
    for hold in find_holds(demonstration, models):
        if hold.object in role_of:
            at_grasp = int(np.searchsorted(demonstration.time, hold.start).clip(0, len(demonstration.time) - 1))
            T_agent_object = T_agent_world * demonstration.T_world_object[hold.object][at_grasp]
            position = T_agent_object.translation
            hand_position = None
            if hold.T_object_hand is not None:
                hand_position = T_agent_object.rotation.apply(hold.T_object_hand.translation)
            holds.append(
                SketchedHold(role_of[hold.object], hold.hand, hold.start, hold.end, hand_position, float(position[0]))
            )
    return tuple(holds)


def _candidates(
    demonstration: Demonstration,
    objects: Mapping[str, str],
    role_models: Mapping[str, ObjectModel],
    pairs: tuple[RegionPair, ...],
    events: tuple[Event, ...],
    constraint: str,
    settings: LearningSettings,
) -> tuple[PairCandidates, ...]:
    own_time = demonstration.time - demonstration.time[0]
    knot_times = [] if settings.time_alignment == "seconds" else [event.time for event in events]
    time = _sample_times(own_time, settings.segmentation_rate, knot_times)
    knots = np.flatnonzero(np.isin(time, knot_times))
    T_agent_world = demonstration.T_world_agent.inv()
    position = {}
    for region in {region for pair in pairs for region in (pair.first, pair.second) if region is not None}:
        center = role_models[region.role].region(region.affordance).center
        path = T_agent_world.apply(demonstration.T_world_object[objects[region.role]].apply(center))
        position[region] = np.stack([np.interp(time, own_time, path[:, axis]) for axis in range(3)], axis=-1)
    result = []
    for pair in pairs:
        from_agent = against_support(pair, role_models, settings)
        origin = position[pair.first][0] if pair.second is None else position[pair.second]
        name = pair_constraint(pair, role_models, constraint, settings)
        values = constraint_values(name, pair_vector(position[pair.first], origin, from_agent))
        channels = []
        for unit, value in zip(constraint_type(name).channel_units, values.T, strict=True):
            amplitude = max(float(np.ptp(value)), settings.amplitude_floor(unit))
            threshold = settings.segmentation_epsilon * amplitude * time[-1]
            kept = segment(time, value, threshold, knots)
            channels.append(ChannelCandidates(time[kept], value[kept]))
        result.append(PairCandidates(pair, name, tuple(channels), from_agent))
    return tuple(result)


def constraint_values(constraint: str, d: Float[np.ndarray, "samples 3"]) -> Float[np.ndarray, "samples channels"]:
    """Channels of a vector over time, m; azimuths unwrapped along time."""
    kind = constraint_type(constraint)
    values = kind.channels(d)
    values[:, kind.circular] = np.unwrap(values[:, kind.circular], axis=0)
    return values


def _sample_times(
    own_time: Float[np.ndarray, " frames"], rate: float | None, knot_times: list[float]
) -> Float[np.ndarray, " samples"]:
    """Times at which a demonstration is looked at: thinned to ``rate``, with its events."""
    duration = own_time[-1]
    if rate is not None and len(own_time) - 1 > rate * duration:
        own_time = np.linspace(0.0, duration, max(2, round(rate * duration) + 1))
    inside = [knot for knot in knot_times if _SAME_TIME < knot < duration - _SAME_TIME]
    if inside:
        own_time = own_time[np.abs(own_time[:, None] - inside).min(axis=1) > _SAME_TIME]
    return np.union1d(own_time, inside)
