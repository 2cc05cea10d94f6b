"""Starting scenes, also from recordings: a demonstration's first frame."""

from __future__ import annotations

from pathlib import Path

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import objects_that_move
from sbam.demonstrations.loading import BUILT_IN, as_demonstration, load
from sbam.errors import DemonstrationError, UnknownNameError
from sbam.scene import ObjectLibrary, Scene, built_in_scene, built_in_scene_names, load_scene

SCENE_SUFFIXES = (".yaml", ".yml")


def scene_from_demonstration(demonstration: Demonstration | str | Path, library: ObjectLibrary | None = None) -> Scene:
    """The scene at the first frame of a demonstration: the robot shall start where the person did.

    Objects that the library lacks are left out if they never move.

    Args:
        demonstration: a demonstration, its file or ``built-in:NAME``; its agent frame becomes that of the scene.
        library: models of its objects; by default the built-in ones.

    Raises:
        UnknownNameError: if the library lacks an object that moves, or all of them; lists the known ones.
    """
    library = library or ObjectLibrary.built_in()
    demonstration = as_demonstration(demonstration)
    known = [name for name in demonstration.objects if name in library]
    moving = objects_that_move(demonstration) if len(known) < len(demonstration.objects) else ()
    for name in demonstration.objects:
        if name not in library and (name in moving or not known):
            raise UnknownNameError("object", name, library.names, f"demonstration {demonstration.name!r}")
    return Scene(
        name=f"start of {demonstration.name}",
        objects={name: library[name] for name in known},
        T_world_object={name: demonstration.T_world_object[name][0] for name in known},
        T_world_agent=demonstration.T_world_agent,
        source=demonstration.source,
    )


def starting_scene(source: str | Path, library: ObjectLibrary | None = None) -> Scene:
    """A scene from a scene file, a built-in scene, or the first frame of a recording.

    Args:
        source: a scene file (``.yaml``, ``.yml``), ``built-in:NAME`` of a scene or a demonstration, or a recording.
        library: models of the objects; by default the built-in ones.

    Raises:
        FileFormatError: if the file cannot be used.
        DemonstrationError: if the recording cannot be used, or there are several.
        UnknownNameError: if there is no such built-in scene or demonstration, or the library lacks an object.
    """
    if Path(source).suffix.lower() in SCENE_SUFFIXES:
        return load_scene(source, library)
    name = str(source).removeprefix(BUILT_IN)
    if name != str(source) and name in built_in_scene_names():
        return built_in_scene(name)
    try:
        demonstrations = load(source)
    except UnknownNameError as error:
        known = tuple(dict.fromkeys((*built_in_scene_names(), *error.known)))
        raise UnknownNameError("built-in scene or demonstration", name, known) from None
    if len(demonstrations) > 1:
        names = ", ".join(one.name for one in demonstrations)
        raise DemonstrationError(str(source), "are several recordings, but a scene is one", f"choose one of {names}")
    return scene_from_demonstration(demonstrations[0], library)


def as_scene(scene: Scene | str | Path) -> Scene:
    """A scene as it is, or the one that a path or a ``built-in:`` name stands for (`starting_scene`)."""
    return scene if isinstance(scene, Scene) else starting_scene(scene)
