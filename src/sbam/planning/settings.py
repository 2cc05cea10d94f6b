"""Settings of the planner; every deviation from the paper is one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class PlanSettings:
    """How to plan.

    Attributes:
        solver: ``default`` (all keypoints at once) or ``paper`` (Nelder-Mead over end-effector poses, keypoint by
            keypoint, joints interpolated linearly).
        human_likeness: weight lambda_h of t_h; None takes the robot's default (0 where it says so).
        damping: t_d in mode ``default``: constant weight, 1/m.
        smoothness: coefficient of the squared joint steps between keypoints, 1/rad^2.
        slide_supports: in mode ``default``, whether pairs against a support (``place onto``) start from wherever the
            object stands on it instead of from the support's centre.
        proximity: in mode ``default``, spread of a pair that is expected before any demonstration, per distance of its
            regions; see `sbam.planning.weights`.
        speed: share of the robot's velocity limits that may be used; accelerations scale with its square.
        sample_rate: samples of the emitted trajectory per second, Hz.
        clearance: distance that arms and carried objects shall keep from what they must not touch, m.
        seed: seed of the random starts.
    """

    solver: Literal["default", "paper"] = "default"
    human_likeness: float | None = None
    damping: float = 10.0
    smoothness: float = 0.05
    slide_supports: bool = True
    proximity: float = 0.2
    speed: float = 0.5
    sample_rate: float = 1000.0
    clearance: float = 0.0
    seed: int = 0
