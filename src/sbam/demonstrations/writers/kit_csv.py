"""Writer of KIT CSV, see `sbam.demonstrations.readers.kit_csv`.

The agent frame is the body ``agent``; labels are cut to whole frames; source and notes are not kept.
"""

from __future__ import annotations

import csv
import io

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration, Hand
from sbam.demonstrations.readers.kit_csv import AGENT, AXES, HANDS, LABELS, SYNTHETIC, TIME
from sbam.demonstrations.writers.recording_writer import RecordingWriter

ROUNDING = 1e-6  # s by which labels of single precision miss the frames that they mean


def encode(demonstration: Demonstration) -> bytes:
    """The content of the file, UTF-8."""
    count = len(demonstration.time)
    bodies = dict(demonstration.T_world_object)
    bodies |= {
        name: demonstration.T_world_hand[hand] for name, hand in HANDS.items() if hand in demonstration.T_world_hand
    }
    header, columns = [TIME], [[repr(float(t)) for t in demonstration.time]]
    for body, poses in bodies.items():
        header += [f"{body}[{axis}]" for axis in AXES]
        columns += [[repr(value) for value in column] for column in _columns(poses)]
    header += [f"{AGENT}[{axis}]" for axis in AXES]
    columns += [[repr(column[0])] * count for column in _columns(_as_sequence(demonstration.T_world_agent))]
    header.append(SYNTHETIC)
    columns.append(["1" if demonstration.synthetic else "0"] * count)
    if demonstration.labels:
        header += LABELS
        columns += [_label_column(demonstration, hand) for hand in LABELS.values()]
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _as_sequence(pose: RigidTransform) -> RigidTransform:
    return RigidTransform.from_components(pose.translation[None], Rotation.from_quat(pose.rotation.as_quat()[None]))


def _columns(poses: RigidTransform) -> list[list[float]]:
    """Values of the seven columns: position in mm, quaternion wxyz."""
    return np.hstack([poses.translation * 1e3, poses.rotation.as_quat(scalar_first=True)]).T.tolist()


def _label_column(demonstration: Demonstration, hand: Hand) -> list[str]:
    """What the hand does at each frame; the last frame belongs to the label that ends there."""
    cells = [""] * len(demonstration.time)
    for label in demonstration.labels:
        if label.hand == hand:
            text = f"{label.action}:{label.target}" if label.target else label.action
            for k, time in enumerate(demonstration.time):
                ends_here = k == len(cells) - 1 and abs(label.end - time) < ROUNDING
                if label.start - ROUNDING < time < label.end - ROUNDING or ends_here:
                    cells[k] = text
    return cells


WRITER = RecordingWriter(".csv", encode)
