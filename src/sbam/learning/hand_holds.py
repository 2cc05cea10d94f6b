"""Holds of the action: what each hand holds when, over all demonstrations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from sbam.demonstrations.demonstration import Hand
from sbam.learning.anchors import AnchorSet, warp
from sbam.learning.model import HandHold
from sbam.learning.sketch import DemonstrationSketch, SketchedHold


def hand_holds(
    sketches: Sequence[DemonstrationSketch], anchors: AnchorSet, model_times: Float[np.ndarray, " anchors"]
) -> tuple[HandHold, ...]:
    """Mean holds on the model's time axis, in order of their grasps.

    A hold belongs to the action if more than half of the demonstrations show it. Where recordings hold no hands, an
    object is held by the hand on whose side it is grasped, the right one if it is in the middle. A grasp is never later
    than its object's mean lift, a release never earlier than its mean place.

    Args:
        sketches: D demonstrations.
        anchors: their anchors.
        model_times: the anchors on the model's time axis, s.
    """
    free_hand = _hands_by_side(sketches)
    found: dict[tuple[str, Hand], list[tuple[float, float, Float[np.ndarray, " 3"] | None]]] = {}
    for own, sketch in zip(anchors.times, sketches, strict=True):
        spans: dict[tuple[str, Hand], list[SketchedHold]] = {}
        for hold in sketch.holds:
            spans.setdefault((hold.role, hold.hand or free_hand[hold.role]), []).append(hold)
        for key, holds in spans.items():
            grasp, release = min(hold.grasp for hold in holds), max(hold.release for hold in holds)
            lift, place = sketch.event_time("lift", key[0]), sketch.event_time("place", key[0])
            grasp = grasp if lift is None else min(grasp, lift)
            release = release if place is None else max(release, place)
            longest = max(holds, key=lambda hold: hold.release - hold.grasp)
            found.setdefault(key, []).append(
                (*warp(np.array([grasp, release]), own, model_times).tolist(), longest.hand_position)
            )
    anchor_time = dict(zip(zip(anchors.kinds, anchors.roles, strict=True), model_times.tolist(), strict=True))
    result = [
        HandHold(
            role=role,
            hand=hand,
            grasp=min(float(np.mean([grasp for grasp, _, _ in seen])), anchor_time.get(("lift", role), np.inf)),
            release=max(float(np.mean([release for _, release, _ in seen])), anchor_time.get(("place", role), 0.0)),
            hand_position=np.array([position for _, _, position in seen if position is not None]).reshape(-1, 3),
        )
        for (role, hand), seen in found.items()
        if 2 * len(seen) > len(sketches)
    ]
    return tuple(sorted(result, key=lambda hold: (hold.grasp, hold.role, hold.hand)))


def _hands_by_side(sketches: Sequence[DemonstrationSketch]) -> dict[str, Hand]:
    """The hand for each role that is held without hands in the recording."""
    sides: dict[str, list[float]] = {}
    for sketch in sketches:
        for hold in sketch.holds:
            sides.setdefault(hold.role, []).append(hold.side)
    return {role: "left" if np.median(values) < 0.0 else "right" for role, values in sides.items()}
