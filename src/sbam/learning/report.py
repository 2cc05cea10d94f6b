"""What there is to say about a model, as plain numbers and words; keys: docs, "Reports"."""

from __future__ import annotations

from typing import Any

import numpy as np

from sbam.learning.generalization import GeneralizedChange
from sbam.learning.model import ActionModel
from sbam.learning.relevance import PairRelevance, rank_pairs


def model_report(model: ActionModel) -> dict[str, Any]:
    """Roles, pairs (the most relevant first), anchors, holds and keypoints of a model."""
    changes = {change.pair: change for change in model.changes}
    return {
        "name": model.name,
        "constraint": model.constraint,
        "mode": model.mode,
        "synthetic": model.synthetic,
        "duration": model.duration,
        "demonstrations": [
            {
                "name": sketch.name,
                "duration": sketch.duration,
                "synthetic": sketch.synthetic,
                "objects": {role.role: role.object for role in sketch.roles},
            }
            for sketch in model.demonstrations
        ],
        "roles": [
            {
                "name": role.name,
                "affordances": list(role.affordances),
                "moves": role.moves,
                "demonstrated": list(role.demonstrated),
            }
            for role in model.roles
        ],
        "pairs": [_pair(changes[relevance.pair], relevance) for relevance in rank_pairs(model)],
        "anchors": [{"kind": anchor.kind, "role": anchor.role, "time": anchor.time} for anchor in model.anchors],
        "holds": [
            {
                "role": hold.role,
                "hand": hold.hand,
                "grasp": hold.grasp,
                "release": hold.release,
                "observations": len(hold.hand_position),
            }
            for hold in model.holds
        ],
        "keypoints": model.keypoint_times.tolist(),
        "notes": list(model.notes),
    }


def _pair(change: GeneralizedChange, relevance: PairRelevance) -> dict[str, Any]:
    return {
        "pair": str(change.pair),
        "constraint": change.constraint,
        "precision": relevance.precision,
        "best_time": relevance.best_time,
        "spread": relevance.spread,
        "layout_spread": relevance.layout_spread,
        "fixed": relevance.fixed,
        "channels": [
            {
                "name": channel.name,
                "unit": channel.unit,
                "keypoints": len(channel.time),
                "smallest_std": float(channel.std.min()),
                "mean_std": float(np.mean(channel.std)),
            }
            for channel in change.channels
        ],
    }
