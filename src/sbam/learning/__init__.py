"""Learning action models from demonstrations."""

from sbam.learning.generalization import GeneralizedChange, GeneralizedChannel
from sbam.learning.learn import add_demonstration, learn
from sbam.learning.model import ActionModel, Anchor, HandHold, Role
from sbam.learning.model_file import load_model, save_model
from sbam.learning.relevance import PairRelevance, pruned, rank_pairs
from sbam.learning.roles import bind_roles
from sbam.learning.settings import LearningSettings

__all__ = [
    "ActionModel",
    "Anchor",
    "GeneralizedChange",
    "GeneralizedChannel",
    "HandHold",
    "LearningSettings",
    "PairRelevance",
    "Role",
    "add_demonstration",
    "bind_roles",
    "learn",
    "load_model",
    "pruned",
    "rank_pairs",
    "save_model",
]
