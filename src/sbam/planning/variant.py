"""Choose what of a model a scene is planned from: the variant whose order fits, without the pairs that are pruned."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from sbam.constraints import RegionReference
from sbam.learning.model import ActionModel
from sbam.learning.relevance import pruned
from sbam.learning.roles import bind_roles
from sbam.learning.variants import nearest_layout
from sbam.scene import Scene


def choose_variant(
    model: ActionModel, scene: Scene, roles: Mapping[str, str] | None = None, prune: float | None = None
) -> tuple[ActionModel, tuple[str, ...]]:
    """The variant of an action whose demonstrations take their objects in the order that fits a scene.

    Args:
        model: the action model; it is not changed.
        scene: the scene.
        roles: role -> object name, where the choice shall not be left to the affordances.
        prune: least relative precision of the pairs that are used (`sbam.learning.relevance.pruned`); None uses all.

    Returns:
        The variant as a model of its own, or the model itself if its demonstrations agree on the order; and a sentence
        for what was left out.

    Raises:
        BindingError: if a role finds no object, or more than one that fit equally well.
    """
    chosen, notes = model, ()
    nearest = nearest_layout(model.demonstrations, _region_starts(model, scene, roles)) if model.variants else None
    if nearest is not None:
        chosen = model.variant_of(nearest)
        notes = (
            f"{len(chosen.demonstrations)} of {len(model.demonstrations)} demonstrations take their objects in the "
            f"order that fits this scene (nearest: {model.demonstrations[nearest].name}); the others are left out",
        )
    kept = chosen if prune is None else pruned(chosen, prune)
    dropped = sorted({str(change.pair) for change in chosen.changes} - {str(change.pair) for change in kept.changes})
    if dropped:
        notes = (*notes, f"{len(dropped)} of {len(chosen.changes)} pairs pruned: {', '.join(dropped)}")
    return kept, notes


def _region_starts(
    model: ActionModel, scene: Scene, roles: Mapping[str, str] | None
) -> dict[RegionReference, Float[np.ndarray, " 3"]]:
    """Region -> its centre in the scene at the start, agent frame, m."""
    binding = bind_roles(model.roles, scene.objects, chosen=roles)
    T_agent_world = scene.T_world_agent.inv()
    starts = {}
    for role in model.roles:
        name = binding[role.name]
        for affordance in role.affordances:
            center = scene.objects[name].region(affordance).center
            starts[RegionReference(role.name, affordance)] = T_agent_world.apply(
                scene.T_world_object[name].apply(center)
            )
    return starts
