"""Every error that a user can meet.

Each class builds its own message: what was wrong, where, what was expected and what would be valid.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class SbamError(Exception):
    """Base of all errors that are a user's to mend; the command line prints them without a traceback."""


class UnknownNameError(SbamError):
    """A name that is not known; lists the names that are."""

    def __init__(self, kind: str, name: str, known: Iterable[str], where: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        place = f" in {where}" if where else ""
        valid = ", ".join(repr(k) for k in self.known) or "none"
        super().__init__(f"unknown {kind} {name!r}{place}; known: {valid}")


class ExtensionError(SbamError):
    """Something that an installed distribution adds and that cannot be used; says which distribution and why."""

    def __init__(self, distribution: str, group: str, name: str, value: str, problem: str, remedy: str) -> None:
        self.distribution, self.group, self.name, self.problem = distribution, group, name, problem
        super().__init__(f"{name!r} of {group} ({value}, from {distribution}): {problem}; {remedy}")


class FileFormatError(SbamError):
    """A file that cannot be used; says the file, the place inside it and what was expected."""

    def __init__(self, path: str | Path, where: str, problem: str, expected: str = "") -> None:
        self.path, self.where, self.problem, self.expected = Path(path), where, problem, expected
        place = f" at {where}" if where else ""
        hint = f" (expected {expected})" if expected else ""
        super().__init__(f"{path}{place}: {problem}{hint}")


class FileVersionError(SbamError):
    """A file written by a later version of the format."""

    def __init__(self, path: str | Path, found: int, supported: int) -> None:
        super().__init__(
            f"{path}: format version {found} is later than {supported}, the latest that this installation reads; "
            "update it with `pip install --upgrade sbam`"
        )


class DemonstrationError(SbamError):
    """A demonstration that cannot be learned from."""

    def __init__(self, name: str, problem: str, remedy: str = "") -> None:
        super().__init__(f"demonstration {name!r}: {problem}" + (f"; {remedy}" if remedy else ""))


class BindingError(SbamError):
    """The scene lacks an object with the affordances that a role of the model needs."""


class UnreachableError(SbamError):
    """No configuration of the robot satisfies what is wanted; names keypoint, term and joint."""


class TrajectoryError(SbamError):
    """A trajectory that a receiver would reject."""


class OutputError(SbamError):
    """A file that could not be written; nothing half-written is left behind."""

    def __init__(self, path: str | Path, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"cannot write {path}: {problem}; nothing was left at that place")


class ConfigurationError(SbamError):
    """Joint configurations that do not fit the robot: wrong shape or not finite."""

    def __init__(self, robot: str, problem: str, expected: str = "") -> None:
        hint = f" (expected {expected})" if expected else ""
        super().__init__(f"configurations of robot {robot!r}: {problem}{hint}")


class SettingsError(SbamError):
    """A setting that makes no sense."""

    def __init__(self, name: str, value: object, expected: str) -> None:
        self.name, self.value, self.expected = name, value, expected
        super().__init__(f"setting {name!r} is {value!r}; expected {expected}")


class RenderingError(SbamError):
    """Pictures cannot be made on this machine."""

    def __init__(self, problem: str) -> None:
        super().__init__(
            f"pictures cannot be drawn: {problem}; they need OpenGL without a screen (EGL), on Debian "
            "`apt install libegl1 libegl-mesa0 libgl1-mesa-dri`"
        )


class SimulationError(SbamError):
    """A motion that cannot be tried in physics: an object, a profile or a task that does not fit."""


class ClusterError(SbamError):
    """A cluster that does not do the work."""

    def __init__(self, address: str, problem: str, remedy: str) -> None:
        super().__init__(f"cluster {address}: {problem}; {remedy}")


class MissingExtraError(SbamError):
    """Something that needs a library which is not installed by default."""

    def __init__(self, purpose: str, library: str, extra: str) -> None:
        super().__init__(f"{purpose} need {library}, which is not installed: `pip install 'sbam[{extra}]'`")
