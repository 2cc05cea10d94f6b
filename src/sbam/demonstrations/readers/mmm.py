"""Reader of MMM 2.0 XML, the format of the KIT motion databases; quirks and their handling: docs, "Recording formats".

Positions are in mm, angles in rad with R = Rz(y) Ry(p) Rx(r) for ``<RootRotation>r p y``, world z is up.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Hand
from sbam.demonstrations.hands import HAND_MARKERS, fit_hand
from sbam.demonstrations.readers.checks import check_time, parse_xml
from sbam.demonstrations.readers.labels import labels_of_json, labels_of_xml
from sbam.demonstrations.readers.recording_format import RecordingFormat
from sbam.demonstrations.recording import Recording, Track
from sbam.errors import FileFormatError, FileVersionError

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Array = NDArray[np.float64]

FORMAT_VERSION = 1
"""Latest version of the ``SBAM`` element."""
HAND_MOTIONS: dict[str, Hand] = {"left_hand": "left", "right_hand": "right"}
_MAX_ANGLE = 20.0
_NAN3 = "nan nan nan"


def recognises(content: bytes) -> bool:
    """Whether it is MMM 2.0: an ``MMM`` element of version 2, or with sensors."""
    return bool(re.search(rb"<MMM[^>]*\bversion\s*=\s*[\"']2", content[:4096])) or (
        b"<MMM" in content[:4096] and b"<Sensors" in content
    )


def read(content: bytes, path: Path) -> Recording:
    """Read a file's content.

    Raises:
        FileFormatError: if it is not MMM 2.0, holds no object motion, or a pose or time stamp is wrong.
    """
    root = parse_xml(content, path)
    if root.tag != "MMM":
        raise FileFormatError(path, f"<{root.tag}>", "not an MMM file", "<MMM version='2.0'> as root element")
    found = _Found()
    for motion in root.iter("Motion"):
        _read_motion(motion, path, found)
    if not found.objects:
        motions = ", ".join(repr(m.get("name", "")) for m in root.iter("Motion")) or "none"
        raise FileFormatError(
            path, "", f"no object motion with poses (motions: {motions})", "a <Motion type='object'> with a ModelPose"
        )
    notes = found.all_notes()
    labels, label_notes = labels_of_xml(root, path)
    if not labels:
        labels, more = labels_of_json(path.with_suffix(".json"))
        label_notes += more
    own = _read_own(root, path)
    return Recording(
        name=own.name or path.stem,
        objects=found.objects,
        hands=found.hands,
        person=found.person,
        T_world_agent=own.T_world_agent,
        labels=labels,
        synthetic=own.synthetic,
        source=own.source,
        notes=(*own.notes, *notes, *label_notes),
    )


@dataclass
class _Found:
    """What the motions hold."""

    objects: dict[str, Track] = field(default_factory=dict)
    hands: dict[Hand, Track] = field(default_factory=dict)
    person: Track | None = None
    predicted: list[str] = field(default_factory=list)
    without_pose: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def all_notes(self) -> list[str]:
        notes = []
        if self.predicted:
            notes.append(f"ignored predicted motions (a network's output): {', '.join(self.predicted)}")
        if self.without_pose:
            notes.append(f"ignored motions without poses: {', '.join(self.without_pose)}")
        return notes + self.notes


def _read_motion(motion: Element, path: Path, found: _Found) -> None:
    name = motion.get("name", "").strip()
    if name.startswith("pred_"):
        found.predicted.append(name)
        return
    name = name.removeprefix("true_")
    where = f"motion {name!r}"
    pose = _read_pose(motion, path, where)
    if is_person(motion, name):
        found.person = pose if found.person is None else found.person
        found.notes += _read_hands(motion, path, where, found)
    elif pose is None:
        found.without_pose.append(name)
    elif name in HAND_MOTIONS:
        found.hands[HAND_MOTIONS[name]] = pose
    elif not name:
        raise FileFormatError(path, "<Motion>", "motion has poses but no name", "name='...'")
    elif name in found.objects:
        raise FileFormatError(path, where, "occurs twice", "one motion per object")
    else:
        found.objects[name] = pose


def is_person(motion: Element, name: str) -> bool:
    """Whether the motion is the person's, which files also call an object."""
    config, model = motion.find("ModelProcessorConfig"), motion.find("Model")
    model_path = "" if model is None else (model.get("path") or model.findtext("File") or "")
    return (
        (config is not None and config.get("type", "").lower() == "winter")
        or motion.get("type", "").lower() in ("mmm", "human")
        or Path(model_path.replace("\\", "/")).name.lower() == "mmm.xml"
        or name.isdigit()
    )


def _measurements(motion: Element, kind: str) -> Sequence[Element]:
    """The measurements of the first sensor of a kind that has any."""
    for sensor in motion.iter("Sensor"):
        if sensor.get("type") == kind and (found := sensor.findall("Data/Measurement")):
            return found
    return ()


def _read_pose(motion: Element, path: Path, where: str) -> Track | None:
    measurements = _measurements(motion, "ModelPose")
    if not measurements:
        return None
    time = _read_time(measurements, path, where)
    position = read_vectors([m.findtext("RootPosition") for m in measurements], path, f"{where}, RootPosition")
    angles = read_vectors([m.findtext("RootRotation") for m in measurements], path, f"{where}, RootRotation")
    return track_of_angles(time, position, angles, path, where)


def track_of_angles(time: Array, position_mm: Array, roll_pitch_yaw: Array, path: Path, where: str) -> Track:
    """A track of positions (S, 3) in mm and angles (S, 3) in rad, R = Rz(y) Ry(p) Rx(r)."""
    if np.nanmax(np.abs(roll_pitch_yaw), initial=0.0) > _MAX_ANGLE:
        k = int(np.nanargmax(np.abs(roll_pitch_yaw).max(axis=1)))
        raise FileFormatError(
            path, f"{where}, frame {k}", f"angle {np.abs(roll_pitch_yaw[k]).max():.4g} is implausible", "radians"
        )
    rotation_xyzw = np.full((len(time), 4), np.nan)
    seen = np.isfinite(roll_pitch_yaw).all(axis=1)
    if seen.any():
        rotation_xyzw[seen] = Rotation.from_euler("xyz", roll_pitch_yaw[seen]).as_quat()
    return Track(time, position_mm * 1e-3, rotation_xyzw)


def _read_time(measurements: Sequence[Element], path: Path, where: str) -> Array:
    try:
        time = np.array([m.get("timestep", "missing") for m in measurements], dtype=float)
    except ValueError as error:
        raise FileFormatError(path, where, f"time stamp is not a number: {error}", "timestep='seconds'") from error
    check_time(time, path, where)
    return time


def read_vectors(texts: Sequence[str | None], path: Path, where: str) -> Array:
    """Three numbers from each text, (S, 3); NaN where there is no text (a missing pose)."""
    split = [(text if text and text.strip() else _NAN3).split() for text in texts]
    for k, parts in enumerate(split):
        if len(parts) != 3:
            raise FileFormatError(path, f"{where}, frame {k}", f"{' '.join(parts)!r}", "three numbers")
    try:
        values = np.array(split, dtype=float)
    except ValueError as error:
        raise FileFormatError(path, where, str(error), "three numbers") from error
    values[~np.isfinite(values)] = np.nan
    return values


def _read_hands(motion: Element, path: Path, where: str, found: _Found) -> list[str]:
    """Fit the hands to the person's markers; notes on what is lacking."""
    measurements = _measurements(motion, "MoCapMarker")
    if not measurements:
        return []
    time = _read_time(measurements, path, where)
    texts: dict[str, list[str | None]] = {name: [None] * len(time) for hand in HAND_MARKERS.values() for name in hand}
    for k, measurement in enumerate(measurements):
        for marker in measurement:
            if (column := texts.get(marker.get("name", ""))) is not None:
                column[k] = marker.text
    markers = {
        name: read_vectors(column, path, f"{where}, marker {name}") * 1e-3
        for name, column in texts.items()
        if any(column)
    }
    for points in markers.values():
        # Trackers write a marker that they lost at the world's origin.
        points[np.all(points == 0.0, axis=1)] = np.nan
    notes = []
    for hand, names in HAND_MARKERS.items():
        if missing := [name for name in names if name not in markers]:
            notes.append(f"no pose of the {hand} hand: markers {', '.join(missing)} are missing")
            continue
        position, rotation_xyzw = fit_hand(markers, hand)
        found.hands.setdefault(hand, Track(time, position, rotation_xyzw))
    return notes


@dataclass(frozen=True)
class _Own:
    """What the project's own writer adds in the element ``SBAM``, which other readers ignore."""

    name: str = ""
    source: str = ""
    synthetic: bool = False
    T_world_agent: RigidTransform | None = None
    notes: tuple[str, ...] = ()


def _read_own(root: Element, path: Path) -> _Own:
    element = root.find("SBAM")
    if element is None:
        return _Own()
    try:
        version = int(element.get("format_version", "1"))
    except ValueError as error:
        raise FileFormatError(path, "<SBAM>", "format_version is not a number", "format_version='1'") from error
    if version > FORMAT_VERSION:
        raise FileVersionError(path, version, FORMAT_VERSION)
    T_world_agent = None
    agent = element.find("Agent")
    if agent is not None:
        position = read_vectors([agent.findtext("RootPosition")], path, "<Agent>, RootPosition")
        angles = read_vectors([agent.findtext("RootRotation")], path, "<Agent>, RootRotation")
        track = track_of_angles(np.zeros(1), position, angles, path, "<Agent>")
        if not track.seen.all():
            raise FileFormatError(path, "<Agent>", "its pose is not complete", "RootPosition and RootRotation")
        T_world_agent = track.poses[0]
    return _Own(
        name=element.get("name", ""),
        source=element.get("source", ""),
        synthetic=element.get("synthetic", "false") == "true",
        T_world_agent=T_world_agent,
        notes=_texts(element.iterfind("Note")),
    )


def _texts(elements: Iterable[Element]) -> tuple[str, ...]:
    return tuple(element.text for element in elements if element.text)


FORMAT = RecordingFormat("MMM 2.0", ".xml", recognises, read)
