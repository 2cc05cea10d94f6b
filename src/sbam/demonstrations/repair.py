"""Damaged frames: motions that no hand can make are found, mended where short, and always reported.

Trackers swap markers, lose bodies, and some files were resampled by interpolating Euler angles one by one, which sends
a rotation the long way round where an angle wraps. What remains are jumps. A step between two frames is impossible if

1. its mean speed exceeds `MAX_SPEED` or `MAX_ANGULAR_SPEED`, or
2. it is a jump from rest to rest: covering what it exceeds the motion before and after by would, starting and stopping
   within the step, take more than `MAX_ACCELERATION` or `MAX_ANGULAR_ACCELERATION` (4 d / dt^2), or
3. it belongs to a turn by more than `FULL_TURN` in one direction that begins and ends abruptly (the long way round).

Rules 1 and 2 count only above `JUMP` and `ANGULAR_JUMP`, so that noise at a high frame rate is no motion. The largest
part of the recording without an impossible step is taken as sound, the frames outside of it as damaged. What is
damaged or was not seen is interpolated (positions linearly, rotations by slerp; held at both ends of the recording) up
to `MAX_GAP`; longer gaps are refused.

Margins on the clean recordings at hand (KIT at 10 Hz, MMLfD at 100 Hz): largest speeds 1.4 m/s and 8.8 rad/s; largest
accelerations of rule 2: see the table in docs/recording_formats.md.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.recording import Track
from sbam.demonstrations.resampling import interpolate_poses
from sbam.errors import DemonstrationError

Array = NDArray[np.float64]

MAX_SPEED = 5.0
"""Mean speed within a step, m/s. Hands reach 2 to 3 m/s in the fastest aimed movements."""
MAX_ANGULAR_SPEED = 20.0
"""Mean angular speed within a step, rad/s: the peak of the fastest turns of the forearm."""
MAX_ACCELERATION = 60.0
"""For a jump from rest to rest, m/s^2. Reaching 0.5 m as fast as people can, in 0.25 s, takes 32."""
MAX_ANGULAR_ACCELERATION = 350.0
"""For a jump from rest to rest, rad/s^2. Turning the forearm by 70 degrees in 0.15 s takes 220."""
JUMP = 0.03
"""Steps shorter than this are no jumps, m."""
ANGULAR_JUMP = np.radians(10.0)
"""Steps by less than this are no jumps, rad."""
FULL_TURN = np.radians(270.0)
"""Turn in one direction that no hand makes without letting go, rad."""
FAST_TURN = 7.5
"""Angular speed from which a step may belong to such a turn, rad/s."""
MAX_GAP = 0.6
"""Longest time between sound frames that is bridged, s; within it a hand seldom starts and ends a movement."""
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


def repair_track(track: Track, body: str, demonstration: str) -> tuple[Track, tuple[str, ...]]:
    """Mend the damaged and unseen frames of one body.

    Args:
        track: the body's poses; NaN where it was not seen.
        body: what it is called in notes and errors.
        demonstration: name of the demonstration, for errors.

    Returns:
        The track with finite poses at all its time stamps, and a sentence for each repair.

    Raises:
        DemonstrationError: if a gap is longer than `MAX_GAP` or no frame is sound.
    """
    seen = track.seen
    if not seen.any():
        raise DemonstrationError(demonstration, f"{body} was never seen: all its poses are missing or NaN")
    damaged = np.zeros(len(seen), dtype=bool)
    damaged[seen] = find_damaged_frames(track.where(seen))
    sound = seen & ~damaged
    if sound.all():
        return track, ()
    notes = tuple(
        _judge_gap(track.time, first, last, damaged[first : last + 1], body, demonstration)
        for first, last in _runs(~sound)
    )
    mended = interpolate_poses(track.time[sound], track.where(sound).poses, track.time)
    position, rotation_xyzw = track.position.copy(), track.rotation_xyzw.copy()
    position[~sound] = mended.translation[~sound]
    rotation_xyzw[~sound] = mended.rotation.as_quat()[~sound]
    return Track(track.time, position, rotation_xyzw), notes


def repair_demonstration(demonstration: Demonstration) -> Demonstration:
    """Mend the damaged frames of a demonstration made in Python; what the readers return is mended already.

    Raises:
        DemonstrationError: as `repair_track`.
    """
    notes: list[str] = []

    def mend(body: str, poses: RigidTransform) -> RigidTransform:
        track = Track(demonstration.time, poses.translation, poses.rotation.as_quat())
        mended, found = repair_track(track, body, demonstration.name)
        notes.extend(found)
        return mended.poses if found else poses

    T_world_object = {name: mend(name, poses) for name, poses in demonstration.T_world_object.items()}
    T_world_hand = {hand: mend(f"{hand} hand", poses) for hand, poses in demonstration.T_world_hand.items()}
    if not notes:
        return demonstration
    return replace(
        demonstration,
        T_world_object=T_world_object,
        T_world_hand=T_world_hand,
        notes=(*demonstration.notes, *notes),
    )


def _judge_gap(time: Array, first: int, last: int, damaged: NDArray[np.bool_], body: str, demonstration: str) -> str:
    """The note on the repair of frames ``first`` to ``last``; raises if they are too many to be mended."""
    start, end = time[max(first - 1, 0)], time[min(last + 1, len(time) - 1)]
    what = "damaged" if damaged.all() else "missing" if not damaged.any() else "damaged or missing"
    count = last - first + 1
    frames = f"frame {first}" if count == 1 else f"frames {first} to {last}"
    place = f"{frames} ({time[first]:.2f} to {time[last]:.2f} s) of {body} {'is' if count == 1 else 'are'} {what}"
    # Rounding of time stamps must not decide.
    if end - start > MAX_GAP + 1e-6:
        raise DemonstrationError(
            demonstration,
            f"{place}; {end - start:.2f} s without a sound pose is too long to interpolate (at most {MAX_GAP:g} s)",
            "cut the recording there or track it again",
        )
    at_the_edge = first == 0 or last == len(time) - 1
    return f"{place}; " + ("held the nearest sound pose" if at_the_edge else "interpolated")


def _steps(track: Track) -> tuple[Array, Array, Array]:
    """Durations (T-1,) s, displacements (T-1, 3) m and rotation vectors (T-1, 3) rad, world, of the steps."""
    before, after = Rotation.from_quat(track.rotation_xyzw[:-1]), Rotation.from_quat(track.rotation_xyzw[1:])
    return np.diff(track.time), np.diff(track.position, axis=0), (after * before.inv()).as_rotvec()


def _impossible(
    duration: Array, size: Array, speed_around: Array, max_speed: float, max_acceleration: float, jump: float
) -> NDArray[np.bool_]:
    """Rules 1 and 2 for steps (N,) of a ``size`` (m or rad), given the mean of the speeds right before and after."""
    too_fast = size > np.maximum(max_speed * duration, jump)
    too_abrupt = size - speed_around * duration > np.maximum(0.25 * max_acceleration * duration**2, jump)
    return too_fast | too_abrupt


def _impossible_between(
    duration: Array, distance: Array, angle: Array, speed_around: Array, angular_speed_around: Array
) -> NDArray[np.bool_]:
    """Rules 1 and 2 for steps (N,) by a distance (m) and an angle (rad)."""
    return _impossible(duration, distance, speed_around, MAX_SPEED, MAX_ACCELERATION, JUMP) | _impossible(
        duration, angle, angular_speed_around, MAX_ANGULAR_SPEED, MAX_ANGULAR_ACCELERATION, ANGULAR_JUMP
    )


def _mean_of_neighbours(speed: Array) -> Array:
    """Mean of the steps before and after each step; at the ends the one there is."""
    if len(speed) == 1:
        return speed
    before = np.concatenate([speed[1:2], speed[:-1]])
    after = np.concatenate([speed[1:], speed[-2:-1]])
    return 0.5 * (before + after)


def _longest_sound_chain(track: Track) -> NDArray[np.bool_]:
    """Frames of the chain of pieces with the most frames in which no step is impossible."""
    duration, displacement, turn = _steps(track)
    distance, angle = np.linalg.norm(displacement, axis=1), np.linalg.norm(turn, axis=1)
    speed, angular_speed = distance / duration, angle / duration
    around, angular_around = _mean_of_neighbours(speed), _mean_of_neighbours(angular_speed)
    broken = np.flatnonzero(_impossible_between(duration, distance, angle, around, angular_around))
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

        def mean_around(values: Array, j: int = j) -> Array:
            return 0.5 * (np.where(alone, 0.0, values[leaving])[:j] + np.where(alone, 0.0, values[entering])[j])

        cosine = np.abs(track.rotation_xyzw[last[:j]] @ track.rotation_xyzw[first[j]])
        possible = ~_impossible_between(
            track.time[first[j]] - track.time[last[:j]],
            np.linalg.norm(track.position[last[:j]] - track.position[first[j]], axis=1),
            2.0 * np.arccos(np.minimum(cosine, 1.0)),
            mean_around(speed),
            mean_around(angular_speed),
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
    """Rule 3: the frames inside of turns the long way round."""
    duration, _, turn = _steps(track)
    speed = np.linalg.norm(turn, axis=1) / duration
    inside = np.zeros(len(track.time), dtype=bool)
    for first, last in _runs(speed > FAST_TURN):
        winding = float(np.linalg.norm(turn[first : last + 1].sum(axis=0)))
        around = max(speed[first - 1] if first > 0 else 0.0, speed[last + 1] if last + 1 < len(speed) else 0.0)
        if winding > FULL_TURN and around < 0.25 * speed[first : last + 1].mean():
            inside[first + 1 : last + 1] = True
    return inside


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(start), int(stop) - 1) for start, stop in edges.reshape(-1, 2)]
