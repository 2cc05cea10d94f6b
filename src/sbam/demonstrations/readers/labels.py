"""Hand-made annotations in and beside MMM files: the ``Segment`` element and the ``.json`` of the same name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from sbam.demonstrations.demonstration import Hand, Label
from sbam.errors import FileFormatError

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

HANDS: tuple[Hand, Hand] = ("left", "right")
"""In the order in which MMM files annotate them."""


def labels_of_xml(root: Element, path: Path) -> tuple[tuple[Label, ...], list[str]]:
    """Labels in ``Segment/Segmentation``, the first of the left hand, the second of the right.

    Returns:
        Labels in the time of the file, and notes.

    Raises:
        FileFormatError: if a segment's start or end is not a number.
    """
    labels: list[Label] = []
    for hand, segmentation in zip(HANDS, root.findall("Segment/Segmentation"), strict=False):
        for segment in segmentation.iterfind("Segment"):
            try:
                start, end = float(segment.get("start", "")), float(segment.get("end", ""))
            except ValueError as error:
                raise FileFormatError(path, f"labels of the {hand} hand", str(error), "start and end in s") from error
            for annotation in segment.iterfind("Annotation"):
                target = annotation.get("target") or annotation.get("main") or ""
                labels.append(Label(hand, start, end, (annotation.text or "").strip(), target))
    return tuple(labels), []


def labels_of_json(path: Path) -> tuple[tuple[Label, ...], list[str]]:
    """Labels in a file of one id per frame and hand (``frames_s``, ``lhand_ids``, ``rhand_ids``, ``id_names``).

    Labels are no input of the learning: a file that is damaged gives a note and no labels.
    """
    import msgspec

    if not path.is_file():
        return (), []
    try:
        data = msgspec.json.decode(path.read_bytes())
        labels = [
            label
            for hand, key in zip(HANDS, ("lhand_ids", "rhand_ids"), strict=True)
            for label in _runs_of_ids(hand, data["frames_s"], data[key], data["id_names"])
        ]
    except (OSError, msgspec.DecodeError, KeyError, TypeError, ValueError) as error:
        return (), [f"labels in {path.name} could not be read: {type(error).__name__} {error}"]
    return tuple(labels), []


def _runs_of_ids(hand: Hand, times: list[float], ids: list[int], names: dict[str, Any]) -> list[Label]:
    """One label for each run of equal ids; it ends where the next begins."""
    if len(times) != len(ids):
        raise ValueError(f"{len(ids)} labels of the {hand} hand for {len(times)} frames")
    starts = [k for k in range(len(ids)) if k == 0 or ids[k] != ids[k - 1]]
    ends = [*starts[1:], len(ids) - 1]
    return [
        Label(hand, float(times[start]), float(times[end]), str(names[str(ids[start])]))
        for start, end in zip(starts, ends, strict=True)
    ]
