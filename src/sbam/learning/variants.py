"""Variants of an action: demonstrations that take or put back their objects in different orders.

With the bottle beyond the cup people fetch it first, else they start with the cup. No monotone map brings both to one
time, and the mean of both is neither. A scene is therefore planned from the demonstrations of one order: that of the
demonstration whose layout is nearest to the scene's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from jaxtyping import Float, Int

from sbam.constraints import RegionReference
from sbam.learning.sketch import DemonstrationSketch

CLEAR = 0.5
"""Two events are swapped if no demonstration lies in this gap between one order and the other, s."""
LEAST_MEMBERS = 2
"""An order that fewer demonstrations show is an exception, not a variant."""


def order_groups(sketches: Sequence[DemonstrationSketch]) -> Int[np.ndarray, " demonstrations"]:
    """Group of each demonstration, 0...; all 0 if lifts and places follow each other in the same order.

    Args:
        sketches: D demonstrations. Only objects that are lifted and placed in each of them count.
    """
    roles = sorted({event.object for sketch in sketches for event in sketch.events})
    splits = []
    for kind in ("lift", "place"):
        for first, second in combinations(roles, 2):
            times = [(sketch.event_time(kind, first), sketch.event_time(kind, second)) for sketch in sketches]
            lags = np.array([np.nan if a is None or b is None else b - a for a, b in times])
            before = lags < 0.0
            if not np.isfinite(lags).all() or min(before.sum(), (~before).sum()) < LEAST_MEMBERS:
                continue
            if lags[~before].min() - lags[before].max() > CLEAR:
                splits.append(before)
    if not splits:
        return np.zeros(len(sketches), dtype=int)
    groups = np.unique(np.array(splits), axis=1, return_inverse=True)[1].reshape(-1)
    return groups if np.bincount(groups).min() >= LEAST_MEMBERS else np.zeros(len(sketches), dtype=int)


def nearest_layout(
    sketches: Sequence[DemonstrationSketch], starts: Mapping[RegionReference, Float[np.ndarray, " 3"]]
) -> int | None:
    """The demonstration in which the moved objects stood most as in a scene, relative to each other.

    Args:
        sketches: D demonstrations.
        starts: region -> its centre in the scene at the start, agent frame, m.

    Returns:
        Its index; None if fewer than two objects can be compared.
    """
    moved = {role.role for sketch in sketches for role in sketch.roles if role.moves}
    places: dict[str, list[Float[np.ndarray, " 3"]]] = {}
    for region, start in sorted(starts.items()):
        known = [sketch.region_at_start(region) for sketch in sketches]
        if region.role in moved and region.role not in places and not any(found is None for found in known):
            places[region.role] = [start, *(found for found in known if found is not None)]
    if len(places) < 2:
        return None
    layouts = np.concatenate(
        [np.array(places[second]) - np.array(places[first]) for first, second in combinations(sorted(places), 2)],
        axis=1,
    )
    return int(np.linalg.norm(layouts[1:] - layouts[0], axis=1).argmin())
