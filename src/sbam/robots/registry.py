"""The built-in robots, and loading a robot by name or from a description file."""

from __future__ import annotations

from pathlib import Path

from sbam.errors import FileFormatError, UnknownNameError
from sbam.robots.description import read_description
from sbam.robots.model_files import MODEL_SUFFIXES
from sbam.robots.options import split_options, with_options
from sbam.robots.robot import Robot

MODELS = Path(__file__).parent / "models"

ROBOTS: dict[str, Path] = {name: MODELS / f"{name}.yaml" for name in ("panda_dual", "armar6", "armar7")}
"""Built-in robots: name -> description file."""


def load_robot(name_or_path: str | Path, *, base_distance: float | None = None) -> Robot:
    """Load a robot; it stands at its default place in an agent frame that coincides with the world.

    Args:
        name_or_path: name of a built-in robot, or path of a description file (``.yaml``, ``.yml``); options may follow,
            such as ``panda_dual:base_distance=0.9,forward=0.1`` (`sbam.robots.options.with_options`).
        base_distance: for robots of two parts: distance between their bases, m; None keeps the description's.

    Raises:
        UnknownNameError: if it is neither a built-in name nor a path of a YAML file, or an option is not known.
        ConfigurationError: if an option is no finite number.
        FileFormatError: if the description or its model cannot be used.
    """
    name, options = split_options(str(name_or_path))
    if base_distance is not None:
        options["base_distance"] = base_distance
    path = ROBOTS.get(name)
    if path is None:
        path = Path(name)
        if path.suffix in MODEL_SUFFIXES:
            hint = f"a description; make one with: sbam robots new {path} -o {path.with_suffix('.yaml').name}"
            raise FileFormatError(path, "", "a model file says nothing of arms and hands", hint)
        if path.suffix not in (".yaml", ".yml"):
            raise UnknownNameError("robot", name, ROBOTS, "the built-in robots; or give a .yaml file")
    description = with_options(read_description(path), options)
    return Robot(description, description.base_in_agent.transform())
