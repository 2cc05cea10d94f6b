"""How near what is found in a recording comes to what a person labelled in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.holds import find_holds
from sbam.learning.learn import learn
from sbam.scene import ObjectLibrary

HAND_FREE = ("idle", "approach", "retreat")
"""Actions during which a hand holds nothing."""


@dataclass(frozen=True)
class KeyEventErrors:
    """Distances in time between labels and what was found.

    Attributes:
        name: of the recording.
        grasps: found minus labelled time of every labelled grasp, s; NaN where none was found.
        releases: the same for releases.
        boundaries: distance from every label boundary inside the recording to the nearest keypoint of a model of
            this recording alone, s.
        spacing: mean distance of such keypoints, s: random boundaries are a quarter of it away from evenly spaced ones.
    """

    name: str
    grasps: Float[np.ndarray, " grasps"]
    releases: Float[np.ndarray, " grasps"]
    boundaries: Float[np.ndarray, " boundaries"]
    spacing: float


def key_event_errors(demonstration: Demonstration, library: ObjectLibrary) -> KeyEventErrors:
    """Compare grasps, releases and segment ends with the hand labels of a recording.

    Args:
        demonstration: a recording with labels.
        library: models of its objects.
    """
    models = {name: library[name] for name in demonstration.objects if name in library}
    holds = find_holds(demonstration, models)
    grasps, releases = [], []
    for hand in ("left", "right"):
        mine = [hold for hold in holds if hold.hand == hand]
        for start, end in labelled_holds(demonstration, hand):
            nearest = min(
                mine, key=lambda hold, start=start, end=end: abs(hold.start - start) + abs(hold.end - end), default=None
            )
            grasps.append(nearest.start - start if nearest else np.nan)
            releases.append(nearest.end - end if nearest else np.nan)
    keypoints = learn([demonstration], library=library).keypoint_times
    inside = sorted({t for label in demonstration.labels for t in (label.start, label.end)})
    edges = np.array([time for time in inside if 0.0 < time < demonstration.duration - 1e-6])
    return KeyEventErrors(
        name=demonstration.name,
        grasps=np.array(grasps),
        releases=np.array(releases),
        boundaries=np.abs(edges[:, None] - keypoints).min(axis=1),
        spacing=float(np.diff(keypoints).mean()),
    )


def labelled_holds(demonstration: Demonstration, hand: str) -> list[tuple[float, float]]:
    """Stretches (s) in which a hand's labels say that it holds something: neither idle, approaching nor retreating."""
    held = [label for label in demonstration.labels if label.hand == hand and label.action.lower() not in HAND_FREE]
    stretches: list[tuple[float, float]] = []
    for label in sorted(held, key=lambda label: label.start):
        if stretches and label.start - stretches[-1][1] < 0.05:
            stretches[-1] = (stretches[-1][0], label.end)
        else:
            stretches.append((label.start, label.end))
    return stretches


def pooled(errors: Sequence[KeyEventErrors]) -> dict[str, tuple[float, float, int]]:
    """Kind -> median and 90 % quantile of the absolute errors over all recordings, s, and their number."""
    kinds = {
        "grasps": np.concatenate([error.grasps for error in errors]),
        "releases": np.concatenate([error.releases for error in errors]),
        "label boundaries to keypoints": np.concatenate([error.boundaries for error in errors]),
    }
    result = {}
    for kind, values in kinds.items():
        found = np.abs(values[np.isfinite(values)])
        if len(found):
            result[kind] = (float(np.median(found)), float(np.quantile(found, 0.9)), len(found))
    return result
