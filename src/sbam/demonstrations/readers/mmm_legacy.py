"""Reader of legacy MMM 1 XML: motions with ``MotionFrames`` instead of sensors; units and angles as in MMM 2.0."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sbam.demonstrations.demonstration import Hand
from sbam.demonstrations.readers.checks import check_time, parse_xml
from sbam.demonstrations.readers.mmm import HAND_MOTIONS, is_person, read_vectors, track_of_angles
from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.demonstrations.recording import Recording, Track
from sbam.errors import FileFormatError


def recognises(content: bytes) -> bool:
    """Whether it is legacy MMM: motion frames, and no later version."""
    return b"<MMM" in content[:4096] and b"<MotionFrames" in content


def read(content: bytes, path: Path) -> Recording:
    """Read a file's content; joint positions are not used.

    Raises:
        FileFormatError: if it holds no object motion, or a pose or time stamp is wrong.
    """
    root = parse_xml(content, path)
    tracks: dict[str, Track] = {}
    person: Track | None = None
    notes: list[str] = []
    for motion in root.iter("Motion"):
        name = motion.get("name", "").strip().removeprefix("true_")
        frames = motion.findall("MotionFrames/MotionFrame")
        where = f"motion {name!r}"
        if name.startswith("pred_"):
            notes.append(f"ignored predicted motion (a network's output): {name}")
            continue
        if not frames:
            notes.append(f"ignored motion without poses: {name}")
            continue
        try:
            time = np.array([frame.findtext("Timestep", "missing").strip() for frame in frames], dtype=float)
        except ValueError as error:
            raise FileFormatError(path, where, f"time stamp is not a number: {error}", "<Timestep>seconds") from error
        check_time(time, path, where)
        position = read_vectors([f.findtext("RootPosition") for f in frames], path, f"{where}, RootPosition")
        angles = read_vectors([f.findtext("RootRotation") for f in frames], path, f"{where}, RootRotation")
        track = track_of_angles(time, position, angles, path, where)
        if is_person(motion, name) or motion.find("JointOrder/Joint") is not None:
            person = track if person is None else person
        elif name in tracks:
            raise FileFormatError(path, where, "occurs twice", "one motion per object")
        else:
            tracks[name] = track
    objects = {name: track for name, track in tracks.items() if name not in HAND_MOTIONS}
    if not objects:
        raise FileFormatError(path, "", "no object motion with poses", "a <Motion> with <MotionFrames>")
    hands: dict[Hand, Track] = {hand: tracks[name] for name, hand in HAND_MOTIONS.items() if name in tracks}
    return Recording(name=path.stem, objects=objects, hands=hands, person=person, notes=tuple(notes))


FORMAT = RecordingFormat("legacy MMM", ".xml", recognises, read)
