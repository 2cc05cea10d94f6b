"""Demonstration: what a tracker saw of the objects and the hands while a person did a task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.plain import html_summary

Hand = Literal["left", "right"]


@dataclass(frozen=True)
class Label:
    """A hand-made annotation: what one hand did from ``start`` to ``end`` (s)."""

    hand: Hand
    start: float
    end: float
    action: str
    target: str = ""


@dataclass(frozen=True)
class Demonstration:
    """Object and hand poses on one time axis.

    Attributes:
        name: unique name, usually the file's stem.
        time: (T,) s, strictly increasing, starts at 0.
        T_world_object: object name -> T poses. World z is up, m.
        T_world_hand: hand -> T poses; empty where the recording holds no hands. The hand frame is any frame fixed in
            the palm; what counts is that it is the same throughout a recording.
        T_world_agent: the agent frame (see `sbam.scene.Scene`).
        labels: annotations, where present. Never an input of the learning, only its test.
        synthetic: True where the project generated it.
        source: file or generator, with its seed.
        notes: what the reader found and repaired, a sentence each.
    """

    name: str
    time: NDArray[np.float64]
    T_world_object: Mapping[str, RigidTransform]
    T_world_hand: Mapping[Hand, RigidTransform]
    T_world_agent: RigidTransform
    labels: tuple[Label, ...] = ()
    synthetic: bool = False
    source: str = ""
    notes: tuple[str, ...] = field(default=())

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the tracked objects."""
        return tuple(self.T_world_object)

    def __repr__(self) -> str:
        length = f"{self.duration:.2f} s, {len(self.time)} frames"
        hands = " and ".join(self.T_world_hand) or "no"
        return f"<Demonstration {self.name!r}: {length}, {', '.join(self.objects)}; {hands} hands>"

    def _repr_html_(self) -> str:
        rows = {
            "duration": f"{self.duration:.2f} s, {len(self.time)} frames",
            "objects": ", ".join(self.objects),
            "hands": ", ".join(self.T_world_hand) or "none",
            "synthetic": self.synthetic,
            "source": self.source,
            "notes": "; ".join(self.notes),
        }
        return html_summary(f"Demonstration {self.name}", rows)
