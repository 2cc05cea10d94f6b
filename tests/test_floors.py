"""The house has floors: a room imports only from the rooms below it, and no two files import each other in a circle."""

import ast
import textwrap
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from sbam.batch.fingerprint import SHARED

PACKAGE = Path(__file__).parents[1] / "src" / "sbam"

BASE = {"errors", "extensions", "files", "schema", "plain"}
LEARNING = BASE | {"constraints", "scene", "demonstrations", "learning"}
PLANNING = LEARNING | {"robots", "planning"}
ALL = PLANNING | {"tasks", "batch", "simulation", "evaluation", "viewer", "export", "plots"}

BELOW: Mapping[str, set[str]] = {
    "errors": set(),
    "extensions": {"errors"},
    "files": {"errors"},
    "schema": {"errors"},
    "plain": set(),
    "constraints": BASE,
    "scene": BASE | {"constraints"},
    "demonstrations": BASE | {"constraints", "scene"},
    "learning": LEARNING - {"learning"},
    "robots": BASE | {"scene"},
    "planning": PLANNING - {"planning"},
    "tasks": PLANNING,
    "batch": BASE | {"robots"},
    "simulation": PLANNING | {"tasks", "batch", "viewer", "export"},
    "evaluation": PLANNING | {"tasks", "batch"},
    "viewer": PLANNING,
    "export": PLANNING,
    "plots": PLANNING,
    "results": ALL,
    "demo": ALL | {"results"},
    "": ALL,  # sbam/__init__.py, the public API on one screen
    "console": {"errors", "files"},
    "cli": ALL | {"", "results", "demo", "console"},
    "__main__": {"cli"},
}
"""Room (folder or file directly in the package) -> the rooms that it may import from, beside itself."""

TASK = {"settings", "task"}
STAGES = {"grasping", "keypoints", "motion", "trajectory"}

BELOW_IN_PLANNING: Mapping[str, set[str]] = {
    "": set(),
    "settings": set(),
    "stopwatch": set(),
    "start": set(),
    "variant": set(),
    "task": {"settings"},
    "bind": TASK,
    "grasping": TASK,
    "keypoints": TASK,
    "motion": TASK | {"grasping", "keypoints"},
    "trajectory": TASK | {"grasping", "motion"},
    "search": TASK | STAGES | {"stopwatch"},
    "plan": TASK | STAGES | {"stopwatch", "start", "variant", "bind", "search"},
    "report": TASK | STAGES | {"plan"},
    "placement": TASK | STAGES | {"start", "variant", "bind", "plan"},
}
"""The same for the rooms of planning."""


def module_name(path: Path, package: Path) -> str:
    """Dotted name of a file relative to the package; the package's own ``__init__`` is the empty name."""
    parts = list(path.relative_to(package).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path: Path, package: Path, modules: set[str]) -> Iterator[tuple[str, int]]:
    """Modules of the package that a file imports, wherever in the file, with the line."""
    own = module_name(path, package)
    folder = own if path.name == "__init__.py" else own.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                ancestors = folder.split(".") if folder else []
                kept = ancestors[: len(ancestors) - node.level + 1]
                base = ".".join(filter(None, [package.name, *kept, node.module]))
            else:
                base = node.module or ""
            names = [f"{base}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            root, _, inside = name.partition(".")
            if root != package.name:
                continue
            while inside and inside not in modules:
                inside = inside.rpartition(".")[0]
            yield inside, node.lineno


def is_within(module: str, room: str) -> bool:
    """Whether a module is a room's own ``__init__`` or inside it."""
    return not room or module == room or module.startswith(f"{room}.")


def room_of(module: str, within: str) -> str:
    """The room of a module among those within another one; empty for an ``__init__``."""
    return module[len(within) :].lstrip(".").partition(".")[0]


def problems(package: Path, below: Mapping[str, set[str]], within: str = "") -> list[str]:
    """Every import that goes upwards, every room without a floor and the first circle, a sentence each.

    Args:
        package: the package's folder.
        below: room -> rooms that it may import from.
        within: the room whose own rooms are meant; none: those of the package.
    """
    files = sorted(package.rglob("*.py"))
    modules = {module_name(path, package) for path in files}
    found: list[str] = []
    graph: dict[str, set[str]] = {}
    for path in files:
        own = module_name(path, package)
        if not is_within(own, within):
            continue
        room = room_of(own, within)
        if room not in below:
            found.append(f"{path.name}: room {room!r} has no floor")
            continue
        for target, line in imports(path, package, modules):
            if not is_within(target, within):
                continue
            other = room_of(target, within)
            if other != room and other not in below[room]:
                found.append(
                    f"{own or package.name}, line {line}: imports {target or package.name}, not below {room!r}"
                )
            graph.setdefault(own, set()).add(target)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found.append(f"circle: {' -> '.join(error.args[1])}")
    return found


def test_every_room_imports_only_from_below() -> None:
    assert problems(PACKAGE, BELOW) == []


def test_the_rooms_of_planning_import_only_from_below() -> None:
    assert problems(PACKAGE, BELOW_IN_PLANNING, "planning") == []


@pytest.mark.parametrize("floors", [BELOW, BELOW_IN_PLANNING], ids=["package", "planning"])
def test_the_floors_themselves_have_no_circle(floors) -> None:
    assert set(TopologicalSorter(floors).static_order()) >= set(floors)


def test_a_fingerprint_covers_all_that_a_result_may_depend_on() -> None:
    assert set(SHARED) == BELOW["evaluation"] == BELOW["simulation"] - {"viewer", "export"}


@pytest.fixture
def house(tmp_path: Path):
    """Builds a small package from file name -> source and returns its problems."""

    def build(within: str = "", **sources: str) -> list[str]:
        package = tmp_path / "sbam"
        for name, source in {"__init__": "", "scene/__init__": "", "learning/__init__": "", **sources}.items():
            path = package / f"{name}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(textwrap.dedent(source))
        return problems(package, BELOW_IN_PLANNING, within) if within else problems(package, BELOW)

    return build


def test_a_house_in_order_has_no_problems(house) -> None:
    sources = {"errors": "", "scene/a": "import sbam.errors\nfrom sbam.scene import b", "scene/b": "import numpy"}
    assert house(**sources, **{"learning/c": "from sbam.scene.a import x\nfrom ..scene import b"}) == []


@pytest.mark.parametrize(
    "source",
    [
        "from sbam.learning import model",
        "import sbam.learning.model as model",
        "from sbam import learning",
        "from ..learning.model import ActionModel",
        "from .. import learning",
        "def late():\n    from sbam.learning.model import ActionModel",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import sbam.learning",
    ],
)
def test_an_upward_import_is_found_however_it_is_written(house, source: str) -> None:
    (problem,) = house(**{"learning/model": "ActionModel = 1", "scene/low": source})
    assert "scene.low, line" in problem
    assert "not below 'scene'" in problem


def test_an_upward_import_within_a_room_is_found(house) -> None:
    sources = {"planning/__init__": "", "planning/task": "from sbam.planning import search", "planning/search": ""}
    (problem,) = house(within="planning", **sources)
    assert problem == "planning.task, line 1: imports planning.search, not below 'task'"


def test_the_public_api_is_not_imported_from_within(house) -> None:
    (problem,) = house(**{"scene/low": "from sbam import learn"})
    assert "imports sbam, not below 'scene'" in problem


def test_a_circle_within_a_room_is_found(house) -> None:
    (problem,) = house(**{"scene/a": "from sbam.scene.b import y", "scene/b": "from sbam.scene import a"})
    assert problem.startswith("circle: ")
    assert "scene.a" in problem


def test_a_new_room_must_be_given_a_floor(house) -> None:
    assert house(attic="") == ["attic.py: room 'attic' has no floor"]
