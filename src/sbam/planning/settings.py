"""Settings of the planner; every deviation from the paper is one of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any, Literal, get_args

from sbam.errors import SettingsError, UnknownNameError
from sbam.extensions import names

Solver = Literal["default", "sequential", "paper"]
Between = Literal["poses", "primitive", "splines", "lines"]
Posture = Literal["directions", "joints"]
SAMPLE_RATES = (10.0, 10_000.0)  # Hz


@dataclass(frozen=True)
class PlanSettings:
    """How to plan.

    Attributes:
        solver: ``default`` (all keypoints at once), ``sequential`` (the same, keypoint by keypoint) or ``paper``
            (Nelder-Mead over end-effector poses, keypoint by keypoint, joints interpolated linearly).
        human_likeness: weight lambda_h of t_h; None takes the robot's default (0 where it says so).
        between: what runs between keypoints: ``poses`` of the objects, the arms follow; the same in the demonstrated
            shape, as a movement ``primitive``; or the joints, by ``splines`` or, as in the paper, by straight
            ``lines``. None takes poses, or with the paper's solver lines.
        posture: what t_h compares with a person's natural posture: ``directions`` of upper arm and forearm (any robot),
            or ``joints``, SOA_q over the first five joints of arms like ARMAR's.
        damping: t_d in mode ``default``: constant weight, 1/m.
        smoothness: coefficient of the squared joint steps between keypoints, 1/rad^2.
        slide_supports: in mode ``default``, whether the places of objects on a support follow where they start as the
            demonstrations tell; see `sbam.planning.keypoints.targets.Placement`.
        rigid_length: in mode ``default``, whether pairs within one object are brought to the object's own length.
        proximity: in mode ``default``, spread of a pair that is expected before any demonstration, per distance of its
            regions; see `sbam.planning.keypoints.weights`.
        speed: share of the robot's velocity limits that may be used; accelerations scale with its square.
        sample_rate: samples of the emitted trajectory per second, Hz.
        clearance: distance that arms and carried objects must keep from what they must not touch, m; it is checked.
        avoid_collisions: whether the keypoints are optimised again where the motion between them comes nearer.
        margin: distance beyond ``clearance`` that is sought then, m.
        prune: least precision, relative to the best, of the pairs between two objects that are used, 0 to 1
            (`sbam.learning.relevance.pruned`); None uses all.
        terms: further terms of the objective: names that distributions register in the group ``sbam.terms``, or
            functions that make them (`sbam.planning.keypoints.terms.TermFactory`).
        seed: seed of the random starts.

    Raises:
        SettingsError: if a value makes no sense; names it and says what is expected.
        UnknownNameError: if no term has that name.
    """

    solver: Solver = "default"
    human_likeness: float | None = None
    between: Between | None = None
    posture: Posture = "directions"
    damping: float = 10.0
    smoothness: float = 0.05
    slide_supports: bool = True
    rigid_length: bool = True
    proximity: float = 0.2
    speed: float = 0.5
    sample_rate: float = 1000.0
    clearance: float = 0.0
    avoid_collisions: bool = True
    margin: float = 0.01
    prune: float | None = None
    terms: tuple[str | Callable[..., Any], ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what makes no sense, before it costs time or lets a trajectory pass that is too fast."""
        if self.solver not in get_args(Solver):
            raise SettingsError("solver", self.solver, " or ".join(map(repr, get_args(Solver))))
        if self.between is not None and self.between not in get_args(Between):
            raise SettingsError("between", self.between, " or ".join(map(repr, get_args(Between))))
        if self.posture not in get_args(Posture):
            raise SettingsError("posture", self.posture, " or ".join(map(repr, get_args(Posture))))
        for name in ("damping", "smoothness", "proximity", "clearance", "margin", "human_likeness"):
            value = getattr(self, name)
            if value is not None and not (isfinite(value) and value >= 0.0):
                raise SettingsError(name, value, "a finite number, 0 or more")
        for term in self.terms:
            if isinstance(term, str) and term not in names("sbam.terms"):
                raise UnknownNameError("term", term, names("sbam.terms"))
            if not (isinstance(term, str) or callable(term)):
                raise SettingsError("terms", term, "names of terms, or functions that make terms")
        if self.prune is not None and not 0.0 <= self.prune <= 1.0:
            raise SettingsError("prune", self.prune, "a share of the best precision, 0 to 1")
        if not 0.0 < self.speed <= 1.0:
            raise SettingsError("speed", self.speed, "a share of the robot's limits, above 0 and at most 1")
        if not SAMPLE_RATES[0] <= self.sample_rate <= SAMPLE_RATES[1]:
            raise SettingsError("sample_rate", self.sample_rate, f"{SAMPLE_RATES[0]:g} to {SAMPLE_RATES[1]:g} Hz")
