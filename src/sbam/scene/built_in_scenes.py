"""The scenes that come with SBAM, by name."""

from __future__ import annotations

from importlib.resources import as_file, files
from typing import Any

from sbam.errors import UnknownNameError
from sbam.scene.scene import Scene
from sbam.scene.scene_file import load_scene


def built_in_scene(name: str) -> Scene:
    """A scene that comes with SBAM, with an arrangement of objects that no built-in demonstration shows.

    Args:
        name: one of `built_in_scene_names`.

    Raises:
        UnknownNameError: if there is no such scene; lists the known ones.
    """
    if name not in built_in_scene_names():
        raise UnknownNameError("built-in scene", name, built_in_scene_names())
    with as_file(files("sbam.scene") / "scenes" / f"{name}.yaml") as path:
        return load_scene(path)


def built_in_scene_names() -> tuple[str, ...]:
    """Names of all built-in scenes, sorted."""
    folder = files("sbam.scene") / "scenes"
    return tuple(sorted(file.name.removesuffix(".yaml") for file in folder.iterdir() if file.name.endswith(".yaml")))


def scene_summaries() -> list[dict[str, Any]]:
    """Name, title, objects and robot of every built-in scene; keys: docs, "Reports"."""
    scenes = {name: built_in_scene(name) for name in built_in_scene_names()}
    return [
        {"name": name, "title": scene.name, "objects": list(scene.objects), "robot": scene.robot}
        for name, scene in scenes.items()
    ]
