"""Finding frames that no hand can have made.

Trackers swap markers, lose bodies, and some files were resampled by interpolating Euler angles one by one, which sends
a rotation the long way round where an angle wraps. What remains are jumps. A step between two frames is impossible if

1. its mean speed exceeds `MAX_SPEED` or `MAX_ANGULAR_SPEED`, or
2. it is a jump from rest to rest: the part d of it that the motion before and after does not explain would, starting
   and stopping within the step, take more than `MAX_ACCELERATION` or `MAX_ANGULAR_ACCELERATION` (4 d / dt^2), or
3. it leads to a single frame and back again: the same, with d the distance of that frame from the line through its
   neighbours, if that is farther than they are apart, or
4. it belongs to a turn by more than `FULL_TURN` in one direction that begins and ends abruptly (the long way round).

Rules 1 to 3 count only above `JUMP` and `ANGULAR_JUMP`, so that noise at a high frame rate is no motion. The largest
part of the recording without an impossible step is taken as sound, the frames outside of it as damaged. Measured
margins: docs, "Recording formats".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sbam.demonstrations.recording import Track

Array = NDArray[np.float64]

MAX_SPEED = 5.0
"""Mean speed within a step, m/s. Hands reach 2 to 3 m/s in the fastest aimed movements."""
MAX_ANGULAR_SPEED = 20.0
"""Mean angular speed within a step, rad/s: the peak of the fastest turns of the forearm."""
MAX_ACCELERATION = 50.0
"""For a jump from rest to rest or a single frame, m/s^2. Reaching 0.5 m as fast as people can, in 0.25 s, takes 32."""
MAX_ANGULAR_ACCELERATION = 350.0
"""For a jump from rest to rest or a single frame, rad/s^2. Turning the forearm by 70 degrees in 0.15 s takes 220."""
JUMP = 0.03
"""Steps shorter than this are no jumps, m."""
ANGULAR_JUMP = np.radians(10.0)
"""Steps by less than this are no jumps, rad."""
FULL_TURN = np.radians(270.0)
"""Turn in one direction that no hand makes without letting go, rad."""
FAST_TURN = 7.5
"""Angular speed from which a step may belong to such a turn, rad/s."""
_MAX_PIECES = 400


def find_damaged_frames(track: Track) -> NDArray[np.bool_]:
    """Frames that cannot be where a hand, or an object in a hand, has been.

    Args:
        track: T finite poses of one body.

    Returns:
        (T,) True where damaged. Of two parts that do not fit together the one with fewer frames is damaged.
    """
    damaged = np.zeros(len(track.time), dtype=bool)
    if len(track.time) < 2:
        return damaged
    damaged |= _in_full_turn(track)
    sound = np.flatnonzero(~damaged)
    damaged[sound[~_longest_sound_chain(track.where(~damaged))]] = True
    return damaged


def _steps(track: Track) -> tuple[Array, Array, Array]:
    """Durations (T-1,) s, displacements (T-1, 3) m and rotation vectors (T-1, 3) rad, world, of the steps."""
    before, after = Rotation.from_quat(track.rotation_xyzw[:-1]), Rotation.from_quat(track.rotation_xyzw[1:])
    return np.diff(track.time), np.diff(track.position, axis=0), (after * before.inv()).as_rotvec()


def _too_abrupt(duration: Array, excess: Array, max_acceleration: float, jump: float) -> NDArray[np.bool_]:
    """Whether what exceeds the motion around, (N,) m or rad, takes too much acceleration (rules 2 and 3)."""
    return excess > np.maximum(0.25 * max_acceleration * duration**2, jump)


def _impossible(
    duration: Array, distance: Array, angle: Array, speed_around: Array, angular_speed_around: Array
) -> NDArray[np.bool_]:
    """Rules 1 and 2 for steps (N,) by a distance (m) and an angle (rad), and the mean speed right before and after."""
    excess, angular_excess = distance - speed_around * duration, angle - angular_speed_around * duration
    return (
        (distance > np.maximum(MAX_SPEED * duration, JUMP))
        | (angle > np.maximum(MAX_ANGULAR_SPEED * duration, ANGULAR_JUMP))
        | _too_abrupt(duration, excess, MAX_ACCELERATION, JUMP)
        | _too_abrupt(duration, angular_excess, MAX_ANGULAR_ACCELERATION, ANGULAR_JUMP)
    )


def _mean_around(speed: Array, width: int) -> Array:
    """Mean of the speeds (N,) right before and after each run of ``width`` steps, (N - width + 1,).

    At the ends, where one of them is not known, the other; without any, the run's own.
    """
    count = len(speed) - width + 1
    if count < 2:
        return speed[:count]
    before, after = speed[: count - 1], speed[width:]
    return 0.5 * (np.append(after[:1], before) + np.append(after, before[-1:]))


def _single_outliers(duration: Array, step: Array, max_acceleration: float, jump: float) -> NDArray[np.bool_]:
    """Rule 3 for the inner frames (T-2,), from the steps (T-1, 3) m or rad."""
    before, after = duration[:-1, None], duration[1:, None]
    from_line = np.linalg.norm(step[:-1] * after - step[1:] * before, axis=1) / (before + after)[:, 0]
    speed = np.linalg.norm(step, axis=1) / duration
    mean_duration = 0.5 * (duration[:-1] + duration[1:])
    excess = from_line - _mean_around(speed, 2) * mean_duration
    goes_back = from_line > np.linalg.norm(step[:-1] + step[1:], axis=1)
    return goes_back & _too_abrupt(mean_duration, excess, max_acceleration, jump)


def _longest_sound_chain(track: Track) -> NDArray[np.bool_]:
    """Frames of the chain of pieces with the most frames in which no step is impossible."""
    duration, displacement, turn = _steps(track)
    distance, angle = np.linalg.norm(displacement, axis=1), np.linalg.norm(turn, axis=1)
    speed, angular_speed = distance / duration, angle / duration
    impossible = _impossible(duration, distance, angle, _mean_around(speed, 1), _mean_around(angular_speed, 1))
    if len(duration) > 2:
        outlier = _single_outliers(duration, displacement, MAX_ACCELERATION, JUMP)
        outlier |= _single_outliers(duration, turn, MAX_ANGULAR_ACCELERATION, ANGULAR_JUMP)
        impossible[:-1] |= outlier
        impossible[1:] |= outlier
    broken = np.flatnonzero(impossible)
    sound = np.ones(len(track.time), dtype=bool)
    if not len(broken):
        return sound
    first, last = np.append(0, broken + 1), np.append(broken, len(track.time) - 1)
    if len(first) > _MAX_PIECES:
        return ~sound
    # Speeds at the ends of the pieces; those of single frames are not known and taken as rest.
    alone = first == last
    leaving, entering = np.maximum(last - 1, 0), np.minimum(first, len(speed) - 1)
    frames = (last - first + 1).astype(float)
    previous = np.full(len(first), -1)
    for j in range(1, len(first)):

        def around(values: Array, j: int = j) -> Array:
            return 0.5 * (np.where(alone, 0.0, values[leaving])[:j] + np.where(alone, 0.0, values[entering])[j])

        cosine = np.abs(track.rotation_xyzw[last[:j]] @ track.rotation_xyzw[first[j]])
        possible = ~_impossible(
            track.time[first[j]] - track.time[last[:j]],
            np.linalg.norm(track.position[last[:j]] - track.position[first[j]], axis=1),
            2.0 * np.arccos(np.minimum(cosine, 1.0)),
            around(speed),
            around(angular_speed),
        )
        # Neighbouring pieces are known to be apart.
        possible[-1] = False
        if possible.any():
            previous[j] = int(np.argmax(np.where(possible, frames[:j], 0.0)))
            frames[j] += frames[previous[j]]
    sound[:] = False
    piece = int(np.argmax(frames))
    while piece >= 0:
        sound[first[piece] : last[piece] + 1] = True
        piece = int(previous[piece])
    return sound


def _in_full_turn(track: Track) -> NDArray[np.bool_]:
    """Rule 4: the frames inside of turns the long way round."""
    duration, _, turn = _steps(track)
    speed = np.linalg.norm(turn, axis=1) / duration
    inside = np.zeros(len(track.time), dtype=bool)
    for first, last in runs_of(speed > FAST_TURN):
        winding = float(np.linalg.norm(turn[first : last + 1].sum(axis=0)))
        around = max(speed[first - 1] if first > 0 else 0.0, speed[last + 1] if last + 1 < len(speed) else 0.0)
        if winding > FULL_TURN and around < 0.25 * speed[first : last + 1].mean():
            inside[first + 1 : last + 1] = True
    return inside


def runs_of(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(start), int(stop) - 1) for start, stop in edges.reshape(-1, 2)]
