"""Which pairs matter when: precision relative to the spread that the scene layouts alone would give."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from sbam.constraints import RegionPair, constraint_type
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.keypoints import keypoint_histogram, keypoint_times
from sbam.learning.model import ActionModel

FIXED = 0.1
"""A pair whose spread falls below this part of the layouts' spread is fixed at that time (K-VIL)."""
_SAMPLES = 200
"""Times at which spreads are compared."""


@dataclass(frozen=True)
class PairRelevance:
    """How much a pair says about the action.

    Attributes:
        pair: the pair.
        best_time: when its spread is least while one of its objects is in motion, s on the model's time axis.
        spread: its spread then, in units of `layout_spread`.
        layout_spread: spread of the pairs between two objects before anything moves, in the `spread_unit` of the
            constraint type (m, or log units), the same for all pairs of one unit.
        precision: 1 / spread relative to the most precise pair between two objects, at most 1 (TAPAS).
        fixed: whether the spread falls below `FIXED`.
    """

    pair: RegionPair
    best_time: float
    spread: float
    layout_spread: float
    precision: float
    fixed: bool


def rank_pairs(model: ActionModel) -> tuple[PairRelevance, ...]:
    """All pairs of a model, the most relevant first.

    The spread of a pair at one time is that of its constraint type (`ConstraintType.spread`: angles as arcs). What the
    layouts alone would give is the mean spread of the pairs between two objects at the start, where nothing has been
    done yet. Spreads below the floor of the weights (5 mm, 0.05 log units) count as that. An own-start pair, which is
    precise by definition before the object moves, is judged after the object was farthest away.

    Args:
        model: learned from two or more demonstrations; with one, or with a single layout, all pairs are equal.
    """
    time = np.linspace(0.0, model.duration, _SAMPLES)
    layouts = _layout_spreads(model)
    found = []
    for change in model.changes:
        kind = constraint_type(change.constraint)
        layout = layouts[kind.spread_unit]
        spread = np.maximum(_spread(change, time), kind.spread_floor) / layout
        during = _motion(model, change, time)
        best = np.flatnonzero(during)[spread[during].argmin()]
        found.append((change, float(time[best]), float(spread[best]), layout))
    between = [spread for change, _, spread, _ in found if len(change.pair.roles) == 2]
    least = min(between or [spread for _, _, spread, _ in found])
    ranked = [
        PairRelevance(change.pair, best_time, spread, layout, min(least / spread, 1.0), spread < FIXED)
        for change, best_time, spread, layout in found
    ]
    return tuple(sorted(ranked, key=lambda relevance: (relevance.spread, str(relevance.pair))))


def pruned(model: ActionModel, precision: float = 0.6) -> ActionModel:
    """The model without the pairs between two objects whose relative precision is below a threshold.

    Same-object and own-start pairs stay: they carry orientation and hold objects until their turn.

    Args:
        model: it is not changed.
        precision: least `PairRelevance.precision`, 0 to 1; TAPAS keeps above 0.6 to 0.75.
    """
    relevance = {entry.pair: entry.precision for entry in rank_pairs(model)}
    changes = tuple(
        change for change in model.changes if len(change.pair.roles) == 1 or relevance[change.pair] >= precision
    )
    histogram = keypoint_histogram(changes, model.duration, model.settings)
    anchors = np.array([anchor.time for anchor in model.anchors])
    return replace(model, changes=changes, keypoint_times=keypoint_times(histogram, anchors))


def _spread(change: GeneralizedChange, time: Float[np.ndarray, " times"]) -> Float[np.ndarray, " times"]:
    """Spread of a pair, in the unit of its type."""
    mean, std = change.at(time)
    return constraint_type(change.constraint).spread(std, mean)


def _layout_spreads(model: ActionModel) -> dict[str, float]:
    """Spread at the start between two objects, by the unit of spreads; at least the floor.

    Where no such pair has the unit (own-start pairs in a symbolic model), the largest spread of any pair with it.
    """
    time = np.linspace(0.0, model.duration, _SAMPLES)
    by_unit: dict[str, list[GeneralizedChange]] = {}
    for change in model.changes:
        by_unit.setdefault(constraint_type(change.constraint).spread_unit, []).append(change)
    result = {}
    for unit, changes in by_unit.items():
        at_start = [_spread(change, time[:1])[0] for change in changes if len(change.pair.roles) == 2]
        spread = np.mean(at_start) if at_start else max(_spread(change, time).max() for change in changes)
        result[unit] = max(float(spread), constraint_type(changes[0].constraint).spread_floor)
    return result


def _motion(
    model: ActionModel, change: GeneralizedChange, time: Float[np.ndarray, " times"]
) -> Bool[np.ndarray, " times"]:
    """When one of the pair's objects is held; always, if none is."""
    during = np.zeros(len(time), dtype=bool)
    for hold in model.holds:
        if hold.role in change.pair.roles:
            during |= (time >= hold.grasp) & (time <= hold.release)
    if not during.any():
        during[:] = True
    if change.pair.is_own_start:
        vector = constraint_type(change.constraint).vector(change.at(time)[0])
        farthest = np.linalg.norm(vector, axis=1).argmax()
        during &= time >= time[min(farthest, np.flatnonzero(during)[-1])]
    return during
