"""What there is to say about a demonstration, as plain numbers and words; keys: docs, "Reports"."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import find_events
from sbam.demonstrations.holds import find_holds
from sbam.demonstrations.loading import BUILT_IN, load
from sbam.demonstrations.readers import read_demonstration, recordings_in
from sbam.demonstrations.synthetic import BUILT_IN_TASKS
from sbam.errors import FileFormatError, SbamError
from sbam.scene.object_library import ObjectLibrary


def demonstration_summary(demonstration: Demonstration) -> dict[str, Any]:
    """Name, duration, rate, objects and hands; quick."""
    return {
        "name": demonstration.name,
        "source": demonstration.source,
        "synthetic": demonstration.synthetic,
        "duration": demonstration.duration,
        "frames": len(demonstration.time),
        "rate": float(1.0 / np.median(np.diff(demonstration.time))),
        "objects": list(demonstration.objects),
        "hands": list(demonstration.T_world_hand),
        "notes": list(demonstration.notes),
    }


def demonstration_report(demonstration: Demonstration, library: ObjectLibrary | None = None) -> dict[str, Any]:
    """The summary, and what was found in the motion: events, holds, and labels where the recording has them.

    Args:
        demonstration: the recording.
        library: models of its objects; by default the built-in ones. Objects that it lacks are listed as unknown.
    """
    library = library or ObjectLibrary.built_in()
    models = {name: library[name] for name in demonstration.objects if name in library}
    return {
        **demonstration_summary(demonstration),
        "unknown_objects": [name for name in demonstration.objects if name not in library],
        "events": [
            {"kind": event.kind, "object": event.object, "time": event.time, "strength": event.strength}
            for event in find_events(demonstration, models)
        ],
        "holds": [
            {
                "hand": hold.hand,
                "object": hold.object,
                "start": hold.start,
                "end": hold.end,
                "hand_position": None if hold.T_object_hand is None else hold.T_object_hand.translation.tolist(),
                "spread": hold.spread,
            }
            for hold in find_holds(demonstration, models)
        ],
        "labels": [
            {
                "hand": label.hand,
                "start": label.start,
                "end": label.end,
                "action": label.action,
                "target": label.target,
            }
            for label in demonstration.labels
        ],
    }


def list_recordings(folder: str | Path | None = None) -> dict[str, Any]:
    """The built-in recordings, or those directly in a folder, with what cannot be used there.

    Args:
        folder: where to look; None: the built-in ones.

    Returns:
        ``where``, ``recordings`` (summaries, each with the ``file`` to give to other verbs) and ``unusable`` (a
        sentence each).

    Raises:
        FileFormatError: if there is no such folder, or it holds no recordings.
    """
    if folder is None:
        found = [(f"{BUILT_IN}{task}", one) for task in BUILT_IN_TASKS for one in load(f"{BUILT_IN}{task}")]
        summaries = [{"file": source, **demonstration_summary(one)} for source, one in found]
        return {"where": "built-in:pouring and built-in:rolling", "recordings": summaries, "unusable": []}
    folder = Path(folder)
    if not folder.is_dir():
        raise FileFormatError(folder, "", "is not a folder", "a folder of recordings")
    summaries, unusable = [], []
    for file in recordings_in(folder):
        try:
            summaries.append({"file": str(file), **demonstration_summary(read_demonstration(file))})
        except SbamError as error:
            unusable.append(str(error))
    return {"where": str(folder), "recordings": summaries, "unusable": unusable}
