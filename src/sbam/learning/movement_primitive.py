"""Via-point movement primitives: the shape of a demonstrated motion, bent through given points (Zhou et al. 2019).

A path is y(x) = h(x) + psi(x)^T w: h runs straight from start to end, psi are Gaussians along time, w is normally
distributed over the demonstrations. Conditioning w on via-points gives the path that goes through them and is as near
to the demonstrated shapes as that allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.interpolate import make_interp_spline, pchip_interpolate
from scipy.spatial.transform import Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.signals import even_times, smooth_positions

RATE = 10.0  # Hz: positions are smoothed below 5 Hz before they are sketched
SPACING = 0.15  # s between the centres of the basis functions, and their width
RIDGE = 1e-3  # of the least squares: keeps weights finite where basis functions have no samples
CERTAINTY = 2e-3  # standard deviation with which a via-point is known, in the unit of the path; the rest is a remainder
DIGITS = 6  # of what is kept of a path: micrometres and microradians


@dataclass(frozen=True)
class SketchedPath:
    """How the object of one role moved in one demonstration, sampled evenly from its start to its end.

    Attributes:
        role: name of the role.
        position: of its origin, agent frame, m.
        rotation: rotation vectors from its orientation at the start, agent axes, rad, without jumps.
    """

    role: str
    position: Float[np.ndarray, "samples 3"]
    rotation: Float[np.ndarray, "samples 3"]

    def at(self, time: Float[np.ndarray, " times"], duration: float) -> tuple[Float[np.ndarray, "times 3"], Rotation]:
        """Positions and rotations from the start at times, s, of a demonstration that took ``duration`` s."""
        own = np.linspace(0.0, duration, len(self.position))
        time = np.clip(time, 0.0, duration)
        position, rotation = (make_interp_spline(own, values, k=3)(time) for values in (self.position, self.rotation))
        return position, Rotation.from_rotvec(rotation)


def sketch_path(demonstration: Demonstration, name: str, role: str) -> SketchedPath:
    """What is kept of the path of one object.

    Args:
        demonstration: the recording.
        name: the object in the recording.
        role: the role that it plays.
    """
    time = demonstration.time - demonstration.time[0]
    pose = demonstration.T_world_agent.inv() * demonstration.T_world_object[name]
    turns = (pose.rotation * pose.rotation[0].inv()).as_rotvec()
    grid = even_times(time)
    own = np.linspace(0.0, time[-1], max(4, round(time[-1] * RATE) + 1))
    position = smooth_positions(pose.translation, time, grid)
    rotation = smooth_positions(_continuous(turns), time, grid)
    kept = [make_interp_spline(grid, values, k=1)(own).round(DIGITS) for values in (position, rotation)]
    return SketchedPath(role, *kept)


def _continuous(rotation_vectors: Float[np.ndarray, "samples 3"]) -> Float[np.ndarray, "samples 3"]:
    """The same rotations by vectors that do not jump where an angle passes half a turn."""
    result = rotation_vectors.copy()
    for i in range(1, len(result)):
        angle = float(np.linalg.norm(result[i]))
        along = result[i] if angle > 1e-6 else result[i - 1]  # a full turn has no axis of its own
        length = float(np.linalg.norm(along))
        if length > 1e-6:
            axis = along / length
            turns = round((float(axis @ result[i - 1]) - angle) / (2 * np.pi))
            result[i] += 2 * np.pi * turns * axis
    return result


@dataclass(frozen=True)
class MovementPrimitive:
    """A distribution over paths of C channels from ``start`` to ``end``.

    Attributes:
        start: s.
        end: s.
        mean: of the weights.
        covariance: of the weights.
    """

    start: float
    end: float
    mean: Float[np.ndarray, "weights channels"]
    covariance: Float[np.ndarray, "channels weights weights"]

    def through(
        self,
        via_time: Float[np.ndarray, " points"],
        via: Float[np.ndarray, "points channels"],
        time: Float[np.ndarray, " times"],
    ) -> Float[np.ndarray, "times channels"]:
        """The most likely path through via-points.

        Args:
            via_time: strictly increasing from ``start`` to ``end``, s.
            via: where the path shall be then.
            time: within them, s.

        Returns:
            The path at these times. Via-points that the basis cannot reach are met by an interpolated remainder.
        """
        basis, at_via = self._basis(time), self._basis(via_time)
        straight, straight_via = (self._straight(t, via[0], via[-1]) for t in (time, via_time))
        missing = via - straight_via - at_via @ self.mean
        result, reached = straight + basis @ self.mean, straight_via + at_via @ self.mean
        for channel in range(via.shape[1]):
            gain = self.covariance[channel] @ at_via.T
            known = at_via @ gain + CERTAINTY**2 * np.eye(len(via_time))
            change = gain @ np.linalg.solve(known, missing[:, channel])
            result[:, channel] += basis @ change
            reached[:, channel] += at_via @ change
        return result + pchip_interpolate(via_time, via - reached, time)

    def _straight(
        self,
        time: Float[np.ndarray, " times"],
        first: Float[np.ndarray, " channels"],
        last: Float[np.ndarray, " channels"],
    ) -> Float[np.ndarray, "times channels"]:
        return first + (last - first) * ((time - self.start) / (self.end - self.start))[:, None]

    def _basis(self, time: Float[np.ndarray, " times"]) -> Float[np.ndarray, "times weights"]:
        return _basis(time, self.start, self.end)


def learn_primitive(
    time: Float[np.ndarray, " times"], paths: Sequence[Float[np.ndarray, "times channels"]], spread: float
) -> MovementPrimitive:
    """Learn from D demonstrated paths on one time axis.

    Args:
        time: s, even.
        paths: D paths.
        spread: standard deviation of the weights beyond what the demonstrations show, in the unit of the paths: how
            readily their shape is left for a via-point, alike everywhere.
    """
    start, end = float(time[0]), float(time[-1])
    basis = _basis(time, start, end)
    normal = basis.T @ basis + RIDGE * np.eye(basis.shape[1])
    share = ((time - start) / (end - start))[:, None]
    shapes = [path - path[0] - share * (path[-1] - path[0]) for path in paths]
    weights = np.array([np.linalg.solve(normal, basis.T @ shape) for shape in shapes])  # (D, N, C)
    mean = weights.mean(axis=0)
    away = np.moveaxis(weights - mean, 2, 0)  # (C, D, N)
    covariance = np.swapaxes(away, 1, 2) @ away / max(len(paths) - 1, 1)
    return MovementPrimitive(start, end, mean, covariance + spread**2 * np.eye(basis.shape[1]))


def _basis(time: Float[np.ndarray, " times"], start: float, end: float) -> Float[np.ndarray, "times weights"]:
    """Normalised Gaussians, evenly spaced from start to end."""
    count = max(4, round((end - start) / SPACING) + 1)
    centers = np.linspace(start, end, count)
    width = (end - start) / (count - 1)
    basis = np.exp(-0.5 * np.square((np.asarray(time)[:, None] - centers) / width))
    return basis / basis.sum(axis=1, keepdims=True)
