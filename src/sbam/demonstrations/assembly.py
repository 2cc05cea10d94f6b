"""From a recording to a demonstration: mended, on one time axis, with an agent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.agent_frame import find_agent
from sbam.demonstrations.demonstration import Demonstration, Hand, Label
from sbam.demonstrations.recording import Recording, Track
from sbam.demonstrations.repair import MAX_GAP, repair_track
from sbam.demonstrations.resampling import interpolate_poses
from sbam.errors import DemonstrationError, FileFormatError

Array = NDArray[np.float64]

MIN_EXTENT = 0.010
"""All objects of a recording, at all times, within less than this: the unit is wrong, m."""
MAX_EXTENT = 20.0
"""Objects farther apart than this: the unit is wrong, m."""
STILL_POSITION = 0.003
"""A body whose positions all lie within this, and..."""
STILL_ANGLE = np.radians(1.5)
"""...whose rotations within this, stood still; few samples of it suffice, m and rad."""
_SAME_TIME = 1e-9


def to_demonstration(recording: Recording, path: Path) -> Demonstration:
    """Put a recording on one time axis, mended and with an agent.

    The time axis is that of the object with the most poses, from where all moving objects are there; it starts at 0.
    Other tracks are interpolated (rotations by slerp). Hands that cannot be mended are left out, with a note.

    Args:
        recording: what a reader found.
        path: the file, for errors.

    Raises:
        FileFormatError: without any object, or if the unit of length or time is implausible.
        DemonstrationError: one frame only, or an object that was not seen for too long.
    """
    name, notes = recording.name, list(recording.notes)
    if not recording.objects:
        raise FileFormatError(path, "", "no object with poses", "at least one tracked object")
    _check_units(recording.objects, path)
    if max(len(track.time) for track in recording.objects.values()) < 2:
        raise DemonstrationError(name, "has one frame only", "a demonstration needs the motion of its objects")

    tracks: dict[str, Track] = {}
    for body, track in recording.objects.items():
        tracks[body], found = _mend(track, body, name)
        notes += found
    time, cut = _common_time(tracks, name)
    notes += cut
    hands: dict[Hand, Track] = {}
    for hand, track in recording.hands.items():
        try:
            mended, found = _mend(track, f"{hand} hand", name)
            _check_cover(mended, f"{hand} hand", name, time)
        except DemonstrationError as error:
            notes.append(f"{hand} hand left out: {str(error).partition(': ')[2]}")
            continue
        hands[hand] = mended
        notes += found

    def on_common_time(track: Track) -> RigidTransform:
        return interpolate_poses(track.time, track.poses, time)

    T_world_object = {body: on_common_time(track) for body, track in tracks.items()}
    T_world_agent = recording.T_world_agent
    if T_world_agent is None:
        T_world_agent, note = find_agent({body: T[0] for body, T in T_world_object.items()}, recording.person)
        notes.append(note)
    return Demonstration(
        name=name,
        time=time - time[0],
        T_world_object=T_world_object,
        T_world_hand={hand: on_common_time(track) for hand, track in hands.items()},
        T_world_agent=T_world_agent,
        labels=tuple(_shifted(label, -time[0]) for label in recording.labels),
        synthetic=recording.synthetic,
        source=recording.source or str(path),
        notes=tuple(notes),
    )


def _shifted(label: Label, shift: float) -> Label:
    return replace(label, start=label.start + shift, end=label.end + shift) if shift else label


def _stood_still(track: Track) -> bool:
    poses = track.where(track.seen).poses
    spread = np.linalg.norm(poses.translation - poses.translation[0], axis=1).max()
    angle = (poses.rotation * poses.rotation[0].inv()).magnitude().max()
    return bool(spread < STILL_POSITION and angle < STILL_ANGLE)


def _mend(track: Track, body: str, demonstration: str) -> tuple[Track, list[str]]:
    """The track with finite poses only, and notes on what was missing or damaged."""
    seen = track.seen
    if seen.any() and _stood_still(track):
        # Something that never moved needs no interpolation over what was not seen of it.
        missing = int((~seen).sum())
        note = f"{missing} of {len(seen)} poses of {body} are missing; it stood still throughout the others"
        return track.where(seen), [note] if missing else []
    mended, found = repair_track(track, body, demonstration)
    step = np.diff(track.time)
    usual = float(np.median(step))
    notes = list(found)
    if usual > MAX_GAP:
        raise DemonstrationError(
            demonstration,
            f"{body} has one pose every {usual:.3g} s only, while it moves",
            f"record at least one every {MAX_GAP:g} s; time stamps must be in seconds",
        )
    for k in np.flatnonzero(step > 1.5 * usual):
        start, end = track.time[k], track.time[k + 1]
        place = f"poses of {body} between {start:.2f} and {end:.2f} s are missing"
        if step[k] > MAX_GAP + 1e-6:
            raise DemonstrationError(
                demonstration,
                f"{place}; {step[k]:.2f} s is too long to interpolate (at most {MAX_GAP:g} s)",
                "cut the recording there or track it again",
            )
        notes.append(f"{place}; interpolated")
    return mended, notes


def _common_time(tracks: Mapping[str, Track], demonstration: str) -> tuple[Array, list[str]]:
    """The time axis of the track with the most poses, cut to where all moving objects were tracked."""
    moving = {body: track for body, track in tracks.items() if not _stood_still(track)}
    densest = max(moving or tracks, key=lambda body: len(tracks[body].time))
    axis = tracks[densest].time
    start = max((track.time[0] for track in moving.values()), default=axis[0])
    end = min((track.time[-1] for track in moving.values()), default=axis[-1])
    common = axis[(axis >= start - _SAME_TIME) & (axis <= end + _SAME_TIME)]
    if len(common) < 2:
        raise DemonstrationError(demonstration, "its objects were not tracked at the same time", "")
    for body, track in moving.items():
        _check_cover(track, body, demonstration, np.array([axis[0], axis[-1]]))
    notes = []
    if len(common) < len(axis):
        notes.append(f"cut to {common[0]:.2f} to {common[-1]:.2f} s, where all moving objects were tracked")
    others = [
        body for body, t in tracks.items() if len(t.time) != len(axis) or not np.allclose(t.time, axis, atol=_SAME_TIME)
    ]
    if others:
        notes.append(f"brought to the time stamps of {densest}: {', '.join(others)}")
    return common, notes


def _check_cover(track: Track, body: str, demonstration: str, time: Array) -> None:
    """Raise if a moving body lacks more than `MAX_GAP` at either end of ``time``."""
    if _stood_still(track):
        return
    late, early = track.time[0] - time[0], time[-1] - track.time[-1]
    if max(late, early) > MAX_GAP + 1e-6:
        raise DemonstrationError(
            demonstration,
            f"{body} was tracked from {track.time[0]:.2f} to {track.time[-1]:.2f} s only, others from {time[0]:.2f} to "
            f"{time[-1]:.2f} s",
            "cut the recording to where all objects were tracked",
        )


def _check_units(tracks: Mapping[str, Track], path: Path) -> None:
    """Raise if lengths are implausible for objects on a table: metres taken for millimetres or the reverse."""
    positions = np.concatenate([track.position[track.seen] for track in tracks.values()])
    if len(positions) < 2:
        return
    extent = float(np.linalg.norm(np.ptp(positions, axis=0)))
    if extent < MIN_EXTENT:
        raise FileFormatError(
            path,
            "",
            f"all {len(tracks)} objects stay within {extent * 1000:.3g} mm",
            "positions in the unit of the format: MMM and CSV in mm (are these metres?), NPZ in m; and a motion",
        )
    if extent > MAX_EXTENT:
        raise FileFormatError(
            path,
            "",
            f"objects are {extent:.4g} m apart",
            "positions in the unit of the format: NPZ in m (are these millimetres?), MMM and CSV in mm",
        )
