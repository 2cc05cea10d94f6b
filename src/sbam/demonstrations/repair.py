"""Mending damaged and missing frames: interpolated where short, refused where long, always reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.damage import find_damaged_frames, runs_of
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.recording import Track
from sbam.demonstrations.resampling import interpolate_poses
from sbam.errors import DemonstrationError

Array = NDArray[np.float64]

MAX_GAP = 0.6
"""Longest time between sound frames that is bridged, s; within it a hand seldom starts and ends a movement."""


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
        for first, last in runs_of(~sound)
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
