"""Building blocks of human-like motion: overlapping minimum-jerk sub-movements, tremor and small leans.

People move hands and held objects in bell-shaped sub-movements that overlap and add (Flash and Hogan 1985, the
minimum-jerk law; Flash and Henis 1991, their superposition; Meyer et al. 1988, a fast primary movement followed by a
slower corrective one). Everything here is a function of time alone, vectorised over the samples.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

RATE = 100.0
"""Sampling rate of the built-in demonstrations, Hz."""

UP = np.array([0.0, 0.0, 1.0])
"""Up in the world and in the agent frame."""

PEAK_SPEED_RATIO = 1.875
"""Peak speed of a minimum-jerk movement over its mean speed."""


def sample_times(duration: float) -> NDArray[np.float64]:
    """Sample times at `RATE` from 0 to ``duration`` (s), (T,)."""
    return np.arange(round(duration * RATE) + 1) / RATE


def minimum_jerk(time: NDArray[np.float64], onset: float, duration: float) -> NDArray[np.float64]:
    """Minimum-jerk course from 0 to 1 (Flash and Hogan 1985), exactly at rest outside its time.

    Args:
        time: (T,) s.
        onset: start, s.
        duration: s.

    Returns:
        (T,) from 0 to 1.
    """
    phase = np.clip((time - onset) / duration, 0.0, 1.0)
    return phase**3 * (10.0 - 15.0 * phase + 6.0 * phase**2)


def between(time: NDArray[np.float64], rise: tuple[float, float], fall: tuple[float, float]) -> NDArray[np.float64]:
    """Envelope that rises from 0 to 1 and falls back, each as (onset, duration) in s; (T,)."""
    return minimum_jerk(time, *rise) * (1.0 - minimum_jerk(time, *fall))


@dataclass(frozen=True)
class SubMovement:
    """A displacement with a minimum-jerk course.

    Attributes:
        onset: start, s.
        duration: s.
        displacement: (3,) m.
    """

    onset: float
    duration: float
    displacement: NDArray[np.float64]


def superpose(
    time: NDArray[np.float64], start: NDArray[np.float64], movements: Iterable[SubMovement]
) -> NDArray[np.float64]:
    """Path from ``start`` (3,) along overlapping sub-movements (Flash and Henis 1991); (T, 3) m."""
    path = np.tile(start, (len(time), 1))
    for movement in movements:
        path += minimum_jerk(time, movement.onset, movement.duration)[:, None] * movement.displacement
    return path


def reach(
    rng: np.random.Generator,
    onset: float,
    duration: float,
    displacement: ArrayLike,
    *,
    horizontal: tuple[float, float] = (0.0, 1.0),
    vertical: tuple[float, float] = (0.0, 1.0),
    detour: ArrayLike = (0.0, 0.0, 0.0),
) -> list[SubMovement]:
    """A goal-directed movement: primary and corrective sub-movement, and a detour that closes on itself.

    Args:
        rng: source of the undershoot of the primary movement (2 to 8 % of the way).
        onset: start, s.
        duration: s; all is at rest after it.
        displacement: (3,) m, z up.
        horizontal: when the horizontal part begins and ends, as fractions of the duration.
        vertical: the same for the vertical part; people lift before they carry and lower after.
        detour: (3,) m, largest departure from the straight way.

    Returns:
        Sub-movements that add up to ``displacement``.
    """
    whole = np.asarray(displacement, dtype=float)
    corrective = rng.uniform(0.02, 0.08)
    movements = []
    for axes, (begin, end) in (((1.0, 1.0, 0.0), horizontal), ((0.0, 0.0, 1.0), vertical)):
        first, length = onset + begin * duration, (end - begin) * duration
        part = whole * axes
        movements.append(SubMovement(first, 0.88 * length, (1.0 - corrective) * part))
        movements.append(SubMovement(first + 0.45 * length, 0.55 * length, corrective * part))
    out, half = np.asarray(detour, dtype=float), 0.62 * duration
    if out.any():
        movements.append(SubMovement(onset, half, out))
        movements.append(SubMovement(onset + duration - half, half, -out))
    return movements


def wander(
    rng: np.random.Generator, time: NDArray[np.float64], std: float, band: tuple[float, float], channels: int = 3
) -> NDArray[np.float64]:
    """Band-limited noise: slow drift of posture (below 1 Hz) or physiological tremor (about 6 to 12 Hz).

    Args:
        rng: source of frequencies and phases.
        time: (T,) s.
        std: standard deviation over all time, in the unit wanted.
        band: lowest and highest frequency, Hz.
        channels: number of independent courses C.

    Returns:
        (T, C), a sum of eight sinusoids with random frequencies and phases.
    """
    frequency = rng.uniform(*band, size=(8, channels))
    phase = rng.uniform(0.0, 2.0 * np.pi, size=(8, channels))
    waves = np.sin(2.0 * np.pi * frequency * time[:, None, None] + phase)
    return std * np.sqrt(2.0 / 8.0) * waves.sum(axis=1)


def above_table(noise: NDArray[np.float64], height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Noise (T, 3) m whose vertical part fades as the height (T,) m goes to 0, so that nothing enters the table."""
    height = np.maximum(height, 0.0)
    return noise * np.stack([np.ones_like(height), np.ones_like(height), height / (height + 0.03)], axis=-1)


def upright(up: NDArray[np.float64], yaw: float = 0.0) -> Rotation:
    """Rotation that stands an object up, turned by ``yaw`` (rad) about the vertical.

    Args:
        up: (3,) unit vector of the object's frame that is to point along z.
        yaw: rad; 0 turns the object's frame by the smallest angle that brings ``up`` upright.
    """
    axis = np.cross(up, UP)
    sine, cosine = np.linalg.norm(axis), float(up[2])
    turn = np.arctan2(sine, cosine)
    direction = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    return Rotation.from_rotvec(yaw * UP) * Rotation.from_rotvec(turn * direction)


def lean(direction: ArrayLike, angle: ArrayLike) -> NDArray[np.float64]:
    """Rotation vector that leans the top of something towards a horizontal direction.

    Args:
        direction: azimuth of the lean, rad, broadcast with ``angle``.
        angle: rad, (T,) or scalar.

    Returns:
        (..., 3) rotation vector, rad.
    """
    direction, angle = np.broadcast_arrays(np.asarray(direction, float), np.asarray(angle, float))
    return np.stack([-np.sin(direction) * angle, np.cos(direction) * angle, np.zeros_like(angle)], axis=-1)


def about(axis: Literal["x", "y", "z"], angle: NDArray[np.float64]) -> Rotation:
    """Rotations by ``angle`` (T,) rad about a coordinate axis."""
    return Rotation.from_euler(axis, angle[:, None])


def put_back(rng: np.random.Generator, start: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where something is put back: near where it stood (13 mm standard deviation per horizontal axis); (3,) m."""
    return start + np.clip(rng.normal(0.0, 0.013, 3), -0.03, 0.03) * (1.0, 1.0, 0.0)


def standing_still(pose: RigidTransform, samples: int) -> RigidTransform:
    """The same pose ``samples`` times."""
    return RigidTransform.from_components(
        np.tile(pose.translation, (samples, 1)), Rotation.from_quat(np.tile(pose.rotation.as_quat(), (samples, 1)))
    )
