"""Objective terms, one a file: residual and derivative over all keypoints at once."""

from sbam.planning.terms.base import EXACT, Smoothing, Term
from sbam.planning.terms.clearance import Clearance
from sbam.planning.terms.damping import Damping
from sbam.planning.terms.human_likeness import HumanLikeness
from sbam.planning.terms.natural_joints import NaturalJoints
from sbam.planning.terms.requirements import Closure, Resting
from sbam.planning.terms.rows import NormalEquations, Rows
from sbam.planning.terms.similarity import Similarity
from sbam.planning.terms.smoothness import Smoothness

__all__ = [
    "EXACT",
    "Clearance",
    "Closure",
    "Damping",
    "HumanLikeness",
    "NaturalJoints",
    "NormalEquations",
    "Resting",
    "Rows",
    "Similarity",
    "Smoothing",
    "Smoothness",
    "Term",
]
