"""Which pairs of affordance regions a model watches."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, permutations

import numpy as np

from sbam.constraints import CARTESIAN, RegionPair, RegionReference
from sbam.learning.settings import LearningSettings
from sbam.scene.affordance_region import is_support
from sbam.scene.object_model import ObjectModel

_UPRIGHT_COSINE = np.cos(np.radians(30.0))


def candidate_pairs(roles: Mapping[str, ObjectModel], settings: LearningSettings) -> tuple[RegionPair, ...]:
    """Pairs that may matter, from the affordances alone; which objects move is not yet asked.

    Args:
        roles: role -> object that plays it.
        settings: ``pairs`` and ``own_start_pairs``.

    Returns:
        Functional pairs, then same-object pairs, then own-start pairs; or all pairs in the order of the roles.
    """
    pairs = _all_pairs(roles) if settings.pairs == "all" else _functional_pairs(roles) + _same_object_pairs(roles)
    if settings.own_start_pairs:
        pairs += [RegionPair(region, None) for role in _movable(roles) for region in _regions(role, roles[role])]
    return tuple(pairs)


def pairs_that_move(pairs: tuple[RegionPair, ...], moving: set[str]) -> tuple[RegionPair, ...]:
    """The pairs in which something moves, of those that were chosen by function."""
    return tuple(pair for pair in pairs if moving.intersection(pair.roles))


def pair_constraint(
    pair: RegionPair, roles: Mapping[str, ObjectModel], constraint: str, settings: LearningSettings
) -> str:
    """Name of the constraint type for one pair of a model of type ``constraint``.

    Own-start pairs are Cartesian in every model. So are, with ``supports`` "agent", pairs against a support, from whose
    centre no radius and no azimuth should be measured; and, with ``upright_as_cartesian``, same-object pairs along the
    object's upright axis: while it stands their radius is 0 and their azimuth undefined.
    """
    if pair.second is None:
        return CARTESIAN
    if against_support(pair, roles, settings):
        return CARTESIAN
    if constraint != CARTESIAN and pair.is_same_object and settings.upright_as_cartesian:
        model = roles[pair.first.role]
        vector = model.region(pair.first.affordance).center - model.region(pair.second.affordance).center
        if abs(vector @ model.up) >= _UPRIGHT_COSINE * np.linalg.norm(vector):
            return CARTESIAN
    return constraint


def against_support(pair: RegionPair, roles: Mapping[str, ObjectModel], settings: LearningSettings) -> bool:
    """Whether a pair is one against what cannot be moved and is placed onto, to be measured from the agent."""
    second = pair.second
    if settings.supports == "center" or second is None:
        return False
    return is_support(second.affordance) and not roles[second.role].movable


def _movable(roles: Mapping[str, ObjectModel]) -> list[str]:
    return [role for role, model in roles.items() if model.movable]


def _regions(role: str, model: ObjectModel) -> list[RegionReference]:
    """Regions of one object, ``place`` last."""
    affordances = sorted(model.affordances, key=lambda affordance: (affordance == "place", affordance))
    return [RegionReference(role, affordance) for affordance in affordances]


def _serves(affordance: str, other: str) -> bool:
    """Whether the names belong together: ``pour from`` and ``pour into``, ``place`` and ``place onto``."""
    if affordance.endswith(" from"):
        return other == affordance.removesuffix(" from") + " into"
    return other == affordance + " onto"


def _functional_pairs(roles: Mapping[str, ObjectModel]) -> list[RegionPair]:
    pairs = []
    for first, second in permutations(roles, 2):
        if not (roles[first].movable or roles[second].movable):
            continue
        for one in _regions(first, roles[first]):
            for other in _regions(second, roles[second]):
                if _serves(one.affordance, other.affordance):
                    pairs.append(RegionPair(one, other))
    paired = {role for pair in pairs for role in pair.roles}
    surfaces = [
        region for role, model in roles.items() for region in _regions(role, model) if is_support(region.affordance)
    ]
    for role in _movable(roles):
        if role not in paired:
            pairs += [
                RegionPair(region, surface)
                for region in _regions(role, roles[role])
                for surface in surfaces
                if surface.role != role
            ]
    return pairs


def _same_object_pairs(roles: Mapping[str, ObjectModel]) -> list[RegionPair]:
    return [
        RegionPair(first, second)
        for role in _movable(roles)
        for first, second in combinations(_regions(role, roles[role]), 2)
    ]


def _all_pairs(roles: Mapping[str, ObjectModel]) -> list[RegionPair]:
    """All unordered pairs of regions, what can be moved first (paper, section III-A)."""
    order = sorted(roles, key=lambda role: (not roles[role].movable, role))
    regions = [region for role in order for region in _regions(role, roles[role])]
    return [
        RegionPair(first, second)
        for first, second in combinations(regions, 2)
        if roles[first.role].movable or roles[second.role].movable
    ]
