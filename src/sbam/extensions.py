"""What can be added from outside: objects by name, those built in and those that other distributions register.

A distribution registers an object as an `entry point <https://packaging.python.org/specifications/entry-points/>`_ of
a group, such as ``sbam.constraints``. The built-in objects stand in `BUILT_IN` in the same form and are loaded alike.
Names are known without loading anything; what cannot be loaded is an error only to those who ask for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

from sbam.errors import ExtensionError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

BUILT_IN: Mapping[str, Mapping[str, str]] = {
    "sbam.constraints": {
        "cartesian": "sbam.constraints.cartesian:Cartesian",
        "cylindrical": "sbam.constraints.cylindrical:Cylindrical",
        "symbolic": "sbam.constraints.symbolic:Symbolic",
    },
    "sbam.plan_writers": {
        "npz": "sbam.export.npz:encode",
        "csv": "sbam.export.csv:encode",
        "ros": "sbam.export.ros:encode",
    },
    "sbam.readers": {
        "mmm": "sbam.demonstrations.readers.mmm:FORMAT",
        "mmm-legacy": "sbam.demonstrations.readers.mmm_legacy:FORMAT",
        "csv": "sbam.demonstrations.readers.kit_csv:FORMAT",
        "npz": "sbam.demonstrations.readers.npz:FORMAT",
    },
    "sbam.tasks": {
        "pouring": "sbam.tasks.pouring.physics:Pouring",
        "rolling": "sbam.tasks.rolling.physics:Rolling",
    },
    "sbam.terms": {
        "similarity": "sbam.planning.keypoints.terms.similarity:similarity_terms",
        "damping": "sbam.planning.keypoints.terms.damping:damping_terms",
        "human-likeness": "sbam.planning.keypoints.terms.human_likeness:human_likeness_terms",
        "natural-joints": "sbam.planning.keypoints.terms.natural_joints:natural_joints_terms",
        "resting": "sbam.planning.keypoints.terms.requirements:resting_terms",
        "smoothness": "sbam.planning.keypoints.terms.smoothness:smoothness_terms",
        "closure": "sbam.planning.keypoints.terms.requirements:closure_terms",
    },
    "sbam.writers": {
        "mmm": "sbam.demonstrations.writers.mmm:WRITER",
        "npz": "sbam.demonstrations.writers.npz:WRITER",
        "csv": "sbam.demonstrations.writers.kit_csv:WRITER",
    },
}
"""Group -> name -> ``module:object``; a new object of the project's own is one line here."""


def names(group: str) -> tuple[str, ...]:
    """Names of a group without loading anything, the built-in ones first."""
    return tuple(registered(group))


@cache
def registered(group: str, kind: type = object) -> Mapping[str, Any]:
    """Objects of a group by name; each is loaded when it is first asked for.

    Args:
        group: name of the group, such as ``sbam.constraints``.
        kind: class that the objects must have. A class of that kind is called without arguments.

    Returns:
        Name -> object. Looking one up raises `ExtensionError` if it cannot be loaded, is not of that kind, or has a
        name that is not its alone; iterating over the names never does.
    """
    return _Registered(group, kind)


class _Registered(Mapping[str, Any]):
    """The mapping that `registered` returns."""

    def __init__(self, group: str, kind: type) -> None:
        self._group, self._kind = group, kind
        self._loaded: dict[str, Any] = {}

    @cached_property
    def _points(self) -> Mapping[str, list[EntryPoint]]:
        """Name -> entry points; built-in ones belong to no distribution."""
        from importlib.metadata import EntryPoint

        own = [EntryPoint(name, value, self._group) for name, value in BUILT_IN.get(self._group, {}).items()]
        points: dict[str, list[EntryPoint]] = {}
        for point in (*own, *sorted(_installed().select(group=self._group), key=lambda point: point.name)):
            points.setdefault(point.name, []).append(point)
        return points

    def __getitem__(self, name: str) -> Any:
        if name not in self._loaded:
            self._loaded[name] = self._load(self._points[name])
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._points

    def __iter__(self) -> Iterator[str]:
        return iter(self._points)

    def __len__(self) -> int:
        return len(self._points)

    def _load(self, points: list[EntryPoint]) -> Any:
        *others, point = points
        if others:
            raise self._error(point, f"{_owner(others[0])} has one of that name too", "uninstall or rename one of them")
        try:
            found = point.load()
            # A class that is itself of the kind, as any class is a callable, stays as it is.
            if isinstance(found, type) and not isinstance(found, self._kind) and issubclass(found, self._kind):
                found = found()
        except Exception as error:  # other people's code may raise anything
            raise self._error(point, f"cannot be loaded: {type(error).__name__}: {error}") from error
        if not isinstance(found, self._kind):
            raise self._error(point, f"is {found!r}, expected {self._kind.__name__}")
        return found

    def _error(self, point: EntryPoint, problem: str, remedy: str = "update or uninstall it") -> ExtensionError:
        return ExtensionError(_owner(point), self._group, point.name, point.value, problem, remedy)


@cache
def _installed() -> Any:
    """Entry points of all installed distributions, which takes a while to find."""
    from importlib.metadata import entry_points

    return entry_points()


def _owner(point: EntryPoint) -> str:
    """The distribution that registers an entry point."""
    return f"{point.dist.name} {point.dist.version}" if point.dist else "sbam"
