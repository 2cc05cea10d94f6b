"""The Spatial Bimanual Action Model (SBAM): what was learned from the demonstrations."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from sbam.demonstrations.demonstration import Hand
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.settings import LearningSettings, Mode
from sbam.learning.sketch import DemonstrationSketch
from sbam.plain import html_summary

__all__ = ["ActionModel", "Anchor", "HandHold", "Mode", "Role", "Variant"]


@dataclass(frozen=True)
class Role:
    """A part that any object with these affordances can play.

    Attributes:
        name: the most telling affordance with underscores, such as ``pour_from``.
        affordances: the affordances that an object must bear, sorted.
        moves: whether the object was moved in the demonstrations.
        demonstrated: names of the object models that played it, sorted.
    """

    name: str
    affordances: tuple[str, ...]
    moves: bool
    demonstrated: tuple[str, ...]


@dataclass(frozen=True)
class Anchor:
    """An event that recurs in every demonstration, at its mean time.

    Attributes:
        kind: ``start``, ``lift``, ``place``, ``reversal``, ``tilt`` or ``end``.
        role: the role whose object shows it, or None for start and end.
        time: mean time, s on the model's time axis.
    """

    kind: str
    role: str | None
    time: float


@dataclass(frozen=True)
class HandHold:
    """When one hand holds the object of one role, and where.

    Attributes:
        role: what is held.
        hand: by which hand of the agent.
        grasp: mean time of the grasp, s on the model's time axis.
        release: mean time of the release, s on the model's time axis.
        hand_position: from the object's origin to the hand at the grasp, agent axes, one row per demonstration
            with this hold, m; no row if the recordings hold no hands (then ``hand`` is a choice, not an observation).
    """

    role: str
    hand: Hand
    grasp: float
    release: float
    hand_position: Float[np.ndarray, "demonstrations 3"]


@dataclass(frozen=True)
class Variant:
    """The same action, learned from those demonstrations alone that take and put back their objects in one order.

    Attributes:
        demonstrations: indices of these demonstrations among the model's.
        changes: as in `ActionModel`, of these demonstrations.
        anchors: likewise.
        keypoint_times: likewise.
        holds: likewise.
        notes: likewise.
    """

    demonstrations: Int[np.ndarray, " demonstrations"]
    changes: tuple[GeneralizedChange, ...]
    anchors: tuple[Anchor, ...]
    keypoint_times: Float[np.ndarray, " keypoints"]
    holds: tuple[HandHold, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ActionModel:
    """A Spatial Bimanual Action Model.

    Attributes:
        name: name of the task.
        constraint: name of the constraint type (own-start pairs are Cartesian whatever it is).
        mode: ``default`` or ``paper``.
        roles: the parts objects play.
        changes: one generalised change per region pair.
        anchors: recurring events in order of time; first ``start`` (0), last ``end`` (= duration).
        keypoint_times: s on the model's time axis, strictly increasing, first 0, last the duration.
        holds: who holds what, when.
        synthetic: True if any demonstration was synthetic.
        demonstrations: what is kept of each demonstration, so that more can be added without the recordings.
        settings: how the model was learned.
        notes: what the learning found worth saying, a sentence each.
        variants: the action by the order in which objects are taken and put back; empty if all demonstrations agree.
    """

    name: str
    constraint: str
    mode: Mode
    roles: tuple[Role, ...]
    changes: tuple[GeneralizedChange, ...]
    anchors: tuple[Anchor, ...]
    keypoint_times: Float[np.ndarray, " keypoints"]
    holds: tuple[HandHold, ...]
    synthetic: bool
    demonstrations: tuple[DemonstrationSketch, ...] = ()
    settings: LearningSettings = field(default_factory=LearningSettings)
    notes: tuple[str, ...] = ()
    variants: tuple[Variant, ...] = ()

    def variant_of(self, demonstration: int) -> ActionModel:
        """The variant to which a demonstration belongs, as a model of its own.

        Args:
            demonstration: index of one of the model's demonstrations.
        """
        variant = next(one for one in self.variants if demonstration in one.demonstrations)
        return replace(
            self,
            changes=variant.changes,
            anchors=variant.anchors,
            keypoint_times=variant.keypoint_times,
            holds=variant.holds,
            demonstrations=tuple(self.demonstrations[index] for index in variant.demonstrations),
            notes=variant.notes,
            variants=(),
        )

    @property
    def duration(self) -> float:
        """Duration on the model's time axis, s."""
        return float(self.keypoint_times[-1])

    def __repr__(self) -> str:
        learned = f"{len(self.demonstrations)} demonstrations, {len(self.changes)} pairs"
        return (
            f"<ActionModel {self.name!r}: {self.constraint}, mode {self.mode}, {learned}, "
            f"{len(self.keypoint_times)} keypoints, {self.duration:.1f} s>"
        )

    def _repr_html_(self) -> str:
        rows = {
            "constraint": f"{self.constraint}, mode {self.mode}",
            "demonstrations": f"{len(self.demonstrations)}{' (synthetic)' if self.synthetic else ''}",
            "roles": ", ".join(f"{role.name}{' (moves)' if role.moves else ''}" for role in self.roles),
            "pairs": len(self.changes),
            "keypoints": f"{len(self.keypoint_times)} in {self.duration:.1f} s",
            "notes": "; ".join(self.notes),
        }
        return html_summary(f"Action model {self.name}", rows)
