"""What several verbs take, and how it is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from sbam.console.running import usage_error
from sbam.extensions import BUILT_IN, names

if TYPE_CHECKING:
    from sbam.scene.object_library import ObjectLibrary

Mode = Literal["default", "paper"]
BUILT_IN_CONSTRAINTS = tuple(BUILT_IN["sbam.constraints"])


def one_of(group: str, default: str, about: str) -> Any:
    """An option that takes one of a group's names; they are looked up when the verb is parsed, not before."""

    def choices() -> Any:
        return Literal[names(group)]

    return arg(constructor_factory=choices, help=about, help_behavior_hint=f"(default: {default})")


def some_of(group: str, default: Sequence[str], about: str) -> Any:
    """An option that takes any number of a group's names, as `one_of`."""

    def choices() -> Any:
        return tuple[Literal[names(group)], ...]

    return arg(constructor_factory=choices, help=about, help_behavior_hint=f"(default: {' '.join(default)})")


def some_added_to(group: str, about: str) -> Any:
    """An option that takes any number of the names that extensions add to a group; free text if there are none."""

    def choices() -> Any:
        added = names(group)[len(BUILT_IN[group]) :]
        return tuple[Literal[added] if added else str, ...]

    return arg(constructor_factory=choices, help=about, help_behavior_hint="")


Constraints = Annotated[str, one_of("sbam.constraints", "cartesian", "How the vector between two regions is seen.")]
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
