"""Objective terms, one a file: residual and derivative over all keypoints at once."""

from collections.abc import Mapping

from sbam.extensions import registered
from sbam.planning.keypoints.terms.base import EXACT, Smoothing, Term
from sbam.planning.keypoints.terms.clearance import Clearance
from sbam.planning.keypoints.terms.context import TermContext, TermFactory
from sbam.planning.keypoints.terms.damping import Damping
from sbam.planning.keypoints.terms.human_likeness import HumanLikeness
from sbam.planning.keypoints.terms.natural_joints import JointHumanLikeness
from sbam.planning.keypoints.terms.requirements import Closure, Resting
from sbam.planning.keypoints.terms.rows import NormalEquations, Rows
from sbam.planning.keypoints.terms.similarity import Similarity
from sbam.planning.keypoints.terms.smoothness import Smoothness

TERMS: Mapping[str, TermFactory] = registered("sbam.terms", TermFactory)
"""What makes the terms of a problem, by name: the built-in ones, and what other distributions register."""

__all__ = [
    "EXACT",
    "TERMS",
    "Clearance",
    "Closure",
    "Damping",
    "HumanLikeness",
    "JointHumanLikeness",
    "NormalEquations",
    "Resting",
    "Rows",
    "Similarity",
    "Smoothing",
    "Smoothness",
    "Term",
    "TermContext",
    "TermFactory",
]
