"""What several verbs take, and how it is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from sbam.console.running import usage_error

if TYPE_CHECKING:
    from sbam.scene.object_library import ObjectLibrary

Constraints = Literal["cartesian", "cylindrical", "symbolic"]
Mode = Literal["default", "paper"]
Format = Literal["npz", "csv", "ros"]
Recordings = Annotated[
    tuple[str, ...],
    arg(
        metavar="RECORDING...",
        help="Files, folders of files, or built-in:pouring, built-in:rolling.",
        help_behavior_hint="",
    ),
]
Scene = Annotated[
    str, arg(metavar="SCENE|RECORDING", help="A scene file, built-in:NAME, or a recording, of which the first frame.")
]
ModelFile = Annotated[Path, arg(metavar="MODEL", help="A model file.")]
Roles = Annotated[
    tuple[str, ...],
    arg(
        metavar="ROLE=OBJECT...",
        help="Which object plays which role, where it is not clear.",
        help_behavior_hint="",
    ),
]
Objects = Annotated[Path | None, arg(metavar="FOLDER", help="Folder with object files of your own.")]


@dataclass(frozen=True, kw_only=True)
class VerbOptions:
    """What every verb takes."""

    json: Annotated[str | None, arg(metavar="FILE", help="Write the report as JSON; - for standard output.")] = None


@dataclass(frozen=True, kw_only=True)
class RecordingsOptions(VerbOptions):
    """What a verb takes that is about recordings."""

    recordings: Positional[Recordings]

    def __post_init__(self) -> None:
        if not self.recordings:
            raise usage_error("give one or more recordings: files, folders, or built-in:pouring, built-in:rolling")


def library_of(folder: Path | None) -> ObjectLibrary:
    """The built-in objects, and those of a folder."""
    from sbam.scene.object_library import ObjectLibrary

    return ObjectLibrary.built_in().with_folder(folder) if folder else ObjectLibrary.built_in()


def pairs(option: str, form: str, texts: Sequence[str]) -> dict[str, str]:
    """Read ``NAME=VALUE`` texts; wrong usage if one is not of the form."""
    parts = [text.partition("=") for text in texts]
    for text, (name, equals, value) in zip(texts, parts, strict=True):
        if not (name and equals and value):
            raise usage_error(f"--{option} {text!r} is not of the form {form}")
    return {name: value for name, _, value in parts}


def number(option: str, text: str) -> float:
    """Read a number; wrong usage if it is none."""
    try:
        return float(text)
    except ValueError:
        raise usage_error(f"--{option}: {text!r} is not a number") from None
