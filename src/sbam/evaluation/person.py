"""The person's motion in a demonstration, on the time axis of a model that was not learned from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import Event, find_events
from sbam.learning.anchors import align_events, locate_anchors, warp
from sbam.learning.model import ActionModel
from sbam.learning.roles import bind_roles
from sbam.learning.settings import AlignmentEvent
from sbam.scene import ObjectLibrary, ObjectModel


@dataclass(frozen=True)
class Anchors:
    """Recurring events on a model's time axis: kinds, roles and times, s."""

    kinds: tuple[str, ...]
    roles: tuple[str | None, ...]
    times: Float[np.ndarray, " anchors"]


@dataclass(frozen=True)
class PersonMotion:
    """How a person moved the objects that play a model's roles.

    Attributes:
        name: name of the demonstration.
        synthetic: whether the project generated it.
        models: role -> model of the object that plays it.
        time: from the start, s.
        T_agent_role: role -> poses, agent frame.
        own_anchors: when the model's anchors occur, s.
        anchors: the model's anchors.
    """

    name: str
    synthetic: bool
    models: Mapping[str, ObjectModel]
    time: Float[np.ndarray, " samples"]
    T_agent_role: Mapping[str, RigidTransform]
    own_anchors: Float[np.ndarray, " anchors"]
    anchors: Anchors

    def aligned(self, times: Float[np.ndarray, " times"]) -> Float[np.ndarray, " times"]:
        """Own times at which the person was where the model is at ``times``, s, by events."""
        return warp(times, self.anchors.times, self.own_anchors)

    def on_model_axis(self, own: Float[np.ndarray, " times"]) -> Float[np.ndarray, " times"]:
        """The model's times that correspond by events to the person's own times, s."""
        return warp(own, self.own_anchors, self.anchors.times)

    def poses_at(self, own: Float[np.ndarray, " times"]) -> dict[str, RigidTransform]:
        """Role -> poses at the person's own times, s; clamped to the recording."""
        own = np.clip(own, self.time[0], self.time[-1])
        return {role: _interpolated(self.time, pose, own) for role, pose in self.T_agent_role.items()}


def model_anchors(model: ActionModel) -> Anchors:
    """The events that recur in the demonstrations of a model, at their mean times.

    Models that do not align time by all events (mode ``paper``: by none) know only some of them; theirs are found anew
    in what they keep of the demonstrations, and lie on their axis of seconds.
    """
    settings = model.settings
    if settings.time_alignment == "events" and set(settings.alignment_events) == set(get_args(AlignmentEvent)):
        found = model.anchors
        times = np.array([anchor.time for anchor in found])
        return Anchors(tuple(a.kind for a in found), tuple(a.role for a in found), times)
    sketches = model.demonstrations
    common = align_events([sketch.events for sketch in sketches], [sketch.duration for sketch in sketches])
    return Anchors(common.kinds, common.roles, common.mean_times)


def person_motion(
    demonstration: Demonstration,
    model: ActionModel,
    library: ObjectLibrary,
    anchors: Anchors | None = None,
    events: Sequence[Event] | None = None,
) -> PersonMotion:
    """The motion in a demonstration of the task that a model was learned for.

    Args:
        demonstration: the recording.
        model: learned from others, or from it.
        library: models of its objects.
        anchors: `model_anchors` of the model, if they are known already.
        events: its events by role, if they are known already.

    Raises:
        BindingError: if the demonstration lacks objects that the model needs.
    """
    anchors = anchors or model_anchors(model)
    models = {name: library[name] for name in demonstration.objects if name in library}
    binding = bind_roles(model.roles, models)
    role_of = {name: role for role, name in binding.items()}
    if events is None:
        found = find_events(demonstration, models)
        events = [replace(event, object=role_of[event.object]) for event in found if event.object in role_of]
    T_agent_world = demonstration.T_world_agent.inv()
    return PersonMotion(
        name=demonstration.name,
        synthetic=demonstration.synthetic,
        models={role: models[name] for role, name in binding.items()},
        time=demonstration.time - demonstration.time[0],
        T_agent_role={role: T_agent_world * demonstration.T_world_object[name] for role, name in binding.items()},
        own_anchors=locate_anchors(anchors.kinds, anchors.roles, anchors.times, events, demonstration.duration),
        anchors=anchors,
    )


def _interpolated(
    time: Float[np.ndarray, " samples"], pose: RigidTransform, own: Float[np.ndarray, " times"]
) -> RigidTransform:
    before = np.searchsorted(time, own, side="right").clip(1, len(time) - 1) - 1
    share = ((own - time[before]) / (time[before + 1] - time[before]))[:, None]
    first, second = pose[before], pose[before + 1]
    position = first.translation + share * (second.translation - first.translation)
    turn = (first.rotation.inv() * second.rotation).as_rotvec()
    return RigidTransform.from_components(position, first.rotation * Rotation.from_rotvec(share * turn))
