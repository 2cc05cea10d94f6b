"""How much each channel of a pair matters at each keypoint."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from sbam.constraints import constraint_type
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.model import ActionModel
from sbam.scene import is_support


def pair_weights(
    model: ActionModel, change: GeneralizedChange, times: Float[np.ndarray, " keypoints"], proximity: float
) -> Float[np.ndarray, "keypoints channels"]:
    """Weights of one pair; in mode ``paper`` 1/(1 + std).

    In mode ``default`` the standard deviation over n demonstrations is joined by a prior that counts as one more:
    regions that are near each other are related more closely than distant ones, sigma = proximity |d|. It decides what
    matters when there is but one demonstration (whose deviations are all zero) and fades with more:

        std'^2 = ((n - 1) std^2 + sigma^2) / n

    Pairs within one object carry an orientation, which no distance tells anything about; they have no prior.

    Args:
        model: the action model.
        change: the pair's generalised change.
        times: on the model's time axis, s.
        proximity: sigma per distance, 0 for none.
    """
    constraint = constraint_type(change.constraint).in_mode(model.mode)
    mean, std = change.at(times)
    if model.mode == "default" and not change.pair.is_same_object:
        count = max(len(model.demonstrations), 1)
        vector = constraint.vector(mean)
        distance = np.linalg.norm(vector - _rest(change, constraint.vector(change.at(np.zeros(1))[0])), axis=-1)
        prior = proximity * distance[:, None] * np.linalg.norm(constraint.jacobian(vector), axis=-1)
        std = np.sqrt(((count - 1) * std**2 + prior**2) / count)
    return constraint.weights(std, mean)


def _rest(change: GeneralizedChange, start: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
    """Where a pair's distance is measured from: on a support from where it stood at the start, else from zero."""
    second = change.pair.second
    if second is not None and is_support(second.affordance):
        return start * np.array([1.0, 1.0, 0.0])
    return np.zeros_like(start)
