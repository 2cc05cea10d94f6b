"""Recording: what a file holds, before it is put on one time axis and judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand, Label

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Track:
    """Poses of one body at its own time stamps.

    Attributes:
        time: (S,) s, strictly increasing.
        position: (S, 3) m, world; NaN where the body was not seen.
        rotation_xyzw: (S, 4) unit quaternions; NaN where the body was not seen.
    """

    time: Array
    position: Array
    rotation_xyzw: Array

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(S,) whether the pose is finite."""
        return np.isfinite(np.hstack([self.position, self.rotation_xyzw])).min(axis=1)

    @property
    def poses(self) -> RigidTransform:
        """All poses; they must have been seen."""
        return RigidTransform.from_components(self.position, Rotation.from_quat(self.rotation_xyzw))

    def where(self, mask: NDArray[np.bool_]) -> Track:
        """The frames at which ``mask`` (S,) is true."""
        return Track(self.time[mask], self.position[mask], self.rotation_xyzw[mask])


@dataclass(frozen=True)
class Recording:
    """Everything that a reader finds in a file.

    Attributes:
        name: name of the demonstration.
        objects: object name -> track.
        hands: hand -> track.
        person: track of the person's root, y forward; None where there is none.
        T_world_agent: the agent frame where the file says it.
        labels: annotations, on the time axis of the tracks.
        synthetic: True where the file says that the project generated it.
        source: where it comes from.
        notes: what was found while reading, a sentence each.
    """

    name: str
    objects: Mapping[str, Track]
    hands: Mapping[Hand, Track] = field(default_factory=dict)
    person: Track | None = None
    T_world_agent: RigidTransform | None = None
    labels: tuple[Label, ...] = ()
    synthetic: bool = False
    source: str = ""
    notes: tuple[str, ...] = ()
