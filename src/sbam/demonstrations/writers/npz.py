"""Writer of SBAM's own NPZ, see `sbam.demonstrations.readers.npz`."""

from __future__ import annotations

import io
from dataclasses import replace

import msgspec
import numpy as np

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.readers.npz import FORMAT_VERSION, Meta
from sbam.demonstrations.writers.recording_writer import RecordingWriter


def encode(demonstration: Demonstration) -> bytes:
    """The content of the file."""
    arrays: dict[str, np.ndarray] = {
        "format_version": np.array(FORMAT_VERSION),
        "time": demonstration.time,
        "object_names": np.array(list(demonstration.T_world_object), dtype=str),
        "T_world_agent": demonstration.T_world_agent.as_matrix(),
    }
    for prefix, poses in (("", demonstration.T_world_object), ("hand_", demonstration.T_world_hand)):
        if poses:
            arrays[f"{prefix}position"] = np.stack([T.translation for T in poses.values()], axis=1)
            arrays[f"{prefix}rotation_xyzw"] = np.stack([T.rotation.as_quat() for T in poses.values()], axis=1)
    if demonstration.T_world_hand:
        arrays["hand_names"] = np.array(list(demonstration.T_world_hand), dtype=str)
    meta = Meta(
        name=demonstration.name,
        source=demonstration.source,
        synthetic=demonstration.synthetic,
        notes=demonstration.notes,
        labels=tuple(replace(label, start=float(label.start), end=float(label.end)) for label in demonstration.labels),
    )
    arrays["meta"] = np.array(msgspec.json.encode(meta).decode())
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()


WRITER = RecordingWriter(".npz", encode)
