"""Writer of MMM 2.0 XML that `sbam.demonstrations.readers.mmm` reads back unchanged.

Objects are motions of type ``object`` with a ``ModelPose``; hands are motions ``left_hand`` and ``right_hand`` of type
``hand``; labels are ``Segment`` annotations. The element ``SBAM``, which other readers ignore, carries the rest: name,
source, whether it is synthetic, notes and the agent frame. Numbers are written with all digits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration, Label
from sbam.demonstrations.readers.labels import HANDS
from sbam.demonstrations.readers.mmm import FORMAT_VERSION, HAND_MOTIONS
from sbam.demonstrations.writers.recording_writer import RecordingWriter

Array = NDArray[np.float64]


def encode(demonstration: Demonstration) -> bytes:
    """The content of the file, UTF-8."""
    return "\n".join(_document(demonstration)).encode()


def roll_pitch_yaw(rotation: Rotation) -> Array:
    """Angles (T, 3) rad with R = Rz(y) Ry(p) Rx(r), exact also where the pitch is near a right angle.

    Each angle is read after the ones before it were turned back, so that they always multiply to the rotation, which
    the textbook formulas do only up to 1e-8 near the singularity.
    """
    matrix = rotation.as_matrix()
    yaw = np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])
    matrix = (Rotation.from_euler("z", -yaw[:, None]) * rotation).as_matrix()
    pitch = np.arctan2(-matrix[:, 2, 0], matrix[:, 0, 0])
    matrix = (Rotation.from_euler("y", -pitch[:, None]) * Rotation.from_matrix(matrix)).as_matrix()
    roll = np.arctan2(matrix[:, 2, 1], matrix[:, 1, 1])
    return np.stack([roll, pitch, yaw], axis=-1)


def _document(demonstration: Demonstration) -> Iterator[str]:
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield f'<MMM version="2.0" name={_quote(demonstration.name)}>'
    yield from _own(demonstration)
    times = [repr(float(t)) for t in demonstration.time]
    for name, poses in demonstration.T_world_object.items():
        yield from _motion(name, "object", times, poses)
    for name, hand in HAND_MOTIONS.items():
        if hand in demonstration.T_world_hand:
            yield from _motion(name, "hand", times, demonstration.T_world_hand[hand])
    if demonstration.labels:
        yield from _labels(demonstration.labels)
    yield "</MMM>\n"


def _own(demonstration: Demonstration) -> Iterator[str]:
    yield (
        f'\t<SBAM format_version="{FORMAT_VERSION}" name={_quote(demonstration.name)} '
        f'source={_quote(demonstration.source)} synthetic="{str(demonstration.synthetic).lower()}">'
    )
    agent = demonstration.T_world_agent
    position, angles = _pose_texts(agent.translation[None], Rotation.from_quat(agent.rotation.as_quat()[None]))
    yield f"\t\t<Agent>{position[0]}{angles[0]}</Agent>"
    yield from (f"\t\t<Note>{escape(note)}</Note>" for note in demonstration.notes)
    yield "\t</SBAM>"


def _motion(name: str, kind: str, times: Iterable[str], poses: RigidTransform) -> Iterator[str]:
    yield f"\t<Motion name={_quote(name)} type={_quote(kind)}>"
    if kind == "object":
        yield f"\t\t<Model path={_quote(f'Model/Objects/{name}/{name}.xml')}/>"
    yield '\t\t<Sensors>\n\t\t\t<Sensor type="ModelPose" version="1.0">\n\t\t\t\t<Configuration/>\n\t\t\t\t<Data>'
    positions, angles = _pose_texts(poses.translation, poses.rotation)
    for time, position, angle in zip(times, positions, angles, strict=True):
        yield f'\t\t\t\t\t<Measurement timestep="{time}">{position}{angle}</Measurement>'
    yield "\t\t\t\t</Data>\n\t\t\t</Sensor>\n\t\t</Sensors>\n\t</Motion>"


def _pose_texts(position: Array, rotation: Rotation) -> tuple[list[str], list[str]]:
    """Elements of positions (T, 3) m, written in mm, and of rotations."""
    return (
        [f"<RootPosition>{x!r} {y!r} {z!r}</RootPosition>" for x, y, z in (position * 1e3).tolist()],
        [f"<RootRotation>{r!r} {p!r} {y!r}</RootRotation>" for r, p, y in roll_pitch_yaw(rotation).tolist()],
    )


def _labels(labels: tuple[Label, ...]) -> Iterator[str]:
    yield "\t<Segment>"
    for hand in HANDS:
        yield "\t\t<Segmentation>"
        for label in labels:
            if label.hand == hand:
                yield (
                    f'\t\t\t<Segment start="{float(label.start)!r}" end="{float(label.end)!r}">'
                    f"<Annotation target={_quote(label.target)}>{escape(label.action)}</Annotation></Segment>"
                )
        yield "\t\t</Segmentation>"
    yield "\t</Segment>"


def _quote(text: str) -> str:
    # Line breaks in attributes would be read back as blanks.
    return quoteattr(text, {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


WRITER = RecordingWriter(".xml", encode)
