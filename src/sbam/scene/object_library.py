"""Object library: the object models that scenes and recordings refer to by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path

from sbam.errors import FileFormatError, UnknownNameError
from sbam.scene.object_file import load_object
from sbam.scene.object_model import ObjectModel


class ObjectLibrary:
    """Object models by name; immutable.

    Example:
        >>> ObjectLibrary.built_in()["cup_small"].affordances
        ('place', 'pour into')
    """

    def __init__(self, models: Mapping[str, ObjectModel]) -> None:
        self._models = dict(models)

    @classmethod
    def built_in(cls) -> ObjectLibrary:
        """The objects that come with SBAM."""
        return _built_in()

    def with_folder(self, folder: str | Path) -> ObjectLibrary:
        """A library that also holds the objects of a folder of YAML files (``*.yaml``, ``*.yml``).

        An object of the folder takes the place of one with the same name in this library.

        Raises:
            FileFormatError: if the folder is missing, holds no YAML file, names an object twice, or a file is wrong.
        """
        folder = Path(folder)
        if not folder.is_dir():
            raise FileFormatError(folder, "", "is not a folder", "a folder of object files (*.yaml)")
        paths = sorted(path for path in folder.iterdir() if path.suffix in (".yaml", ".yml"))
        if not paths:
            raise FileFormatError(folder, "", "holds no object files", "files named *.yaml")
        found: dict[str, tuple[Path, ObjectModel]] = {}
        for path in paths:
            model = load_object(path)
            if model.name in found:
                raise FileFormatError(path, "$.name", f"{model.name!r} is also the name in {found[model.name][0].name}")
            found[model.name] = (path, model)
        return ObjectLibrary({**self._models, **{name: model for name, (_, model) in found.items()}})

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all objects, sorted."""
        return tuple(sorted(self._models))

    def __getitem__(self, name: str) -> ObjectModel:
        """The model of that name; raises `UnknownNameError` that lists the known ones."""
        try:
            return self._models[name]
        except KeyError:
            raise UnknownNameError("object", name, self.names, "the object library") from None

    def __contains__(self, name: object) -> bool:
        return name in self._models

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self._models)


@cache
def _built_in() -> ObjectLibrary:
    with as_file(files("sbam.scene") / "objects") as folder:
        return ObjectLibrary({}).with_folder(folder)
