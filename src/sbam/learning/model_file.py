"""Model file: an action model as versioned JSON that people can read.

The fields are those of `ActionModel` and what it holds, by the same names; one line per array. Numbers are written so
that they are read back unchanged.
"""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from jaxtyping import Float, Shaped

from sbam.constraints import CONSTRAINT_TYPES, constraint_type
from sbam.errors import FileFormatError
from sbam.files import write_atomically
from sbam.learning.generalization import GeneralizedChange
from sbam.learning.learn import with_variants
from sbam.learning.model import ActionModel, Variant
from sbam.scene.object_file import check_version
from sbam.schema import convert

FORMAT = "sbam action model"
FORMAT_VERSION = 2
"""Version 1 had no variants; they are learned anew from what it keeps of the demonstrations."""

_LINE = 110
"""What fits into this many characters is written on one line."""


def save_model(model: ActionModel, path: str | Path) -> None:
    """Write a model; raises `OutputError` if that is impossible, and then leaves nothing behind."""
    content = {"format": FORMAT, "format_version": FORMAT_VERSION, **_plain(model)}
    write_atomically(path, _pretty(content, "") + "\n")


def load_model(path: str | Path) -> ActionModel:
    """Read a model.

    Raises:
        FileFormatError: with the place inside the file, what was expected and the valid names.
        FileVersionError: if the file was written for a later version of the format.
    """
    path = Path(path)
    try:
        content = msgspec.json.decode(path.read_bytes())
    except OSError as error:
        raise FileFormatError(path, "", f"cannot be read: {error.strerror or error}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FileFormatError(path, "", f"is not valid JSON: {error}", "a model written by SBAM") from error
    check_version(content, path, FORMAT_VERSION)
    found = content.pop("format", None)
    if found != FORMAT:
        raise FileFormatError(path, "$.format", f"is {found!r}", repr(FORMAT))
    if "format_version" not in content:
        raise FileFormatError(path, "$.format_version", "is missing", f"1 to {FORMAT_VERSION}")
    if not isinstance(content["format_version"], int):
        raise FileFormatError(path, "$.format_version", f"is {content['format_version']!r}", "a whole number")
    version = content.pop("format_version")
    model: ActionModel = _typed(ActionModel, convert(content, _schema(ActionModel), path))
    _check(model, path)
    return with_variants(model) if version == 1 else model


def as_model(model: ActionModel | str | Path) -> ActionModel:
    """A model as it is, or the one in a file (`load_model`)."""
    return model if isinstance(model, ActionModel) else load_model(model)


def _plain(value: Any) -> Any:
    """Dictionaries, lists and numbers for a dataclass of arrays."""
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


def _pretty(value: Any, indent: str) -> str:
    """JSON with one line for every array of numbers and for whatever is short."""
    flat = json.dumps(value, ensure_ascii=False, allow_nan=False)
    numbers = isinstance(value, list) and not any(isinstance(item, dict | list | str) for item in value)
    if len(flat) <= _LINE or numbers or not isinstance(value, dict | list):
        return flat
    deeper = indent + " "
    if isinstance(value, dict):
        parts = [f"{deeper}{json.dumps(key)}: {_pretty(item, deeper)}" for key, item in value.items()]
        return "{\n" + ",\n".join(parts) + f"\n{indent}}}"
    return "[\n" + ",\n".join(deeper + _pretty(item, deeper) for item in value) + f"\n{indent}]"


@cache
def _schema(hint: Any) -> Any:
    """The schema of a type: a struct that refuses unknown fields for every dataclass, lists for arrays."""
    if is_dataclass(hint) and isinstance(hint, type):
        hints = get_type_hints(hint)
        parts = []
        for field in fields(hint):
            kind = _schema(hints[field.name])
            default = () if field.default is MISSING else (field.default,)
            parts.append((field.name, kind, *default))
        return msgspec.defstruct(hint.__name__, parts, forbid_unknown_fields=True, kw_only=True)
    dtype = _array_dtype(hint)
    if dtype is not None:
        number = int if issubclass(dtype, np.integer) else float
        return list[tuple[float, float, float]] if _has_rows_of_three(hint) else list[number]
    if get_origin(hint) is tuple:
        return tuple[_schema(get_args(hint)[0]), ...]
    if get_origin(hint) in (Union, UnionType):
        return Union[tuple(_schema(option) for option in get_args(hint))]  # noqa: UP007
    return hint


def _array_dtype(hint: Any) -> type[np.generic] | None:
    """The type of the numbers in an array, None if the hint is that of something else."""
    if getattr(hint, "array_type", None) is np.ndarray:  # jaxtyping's Float[np.ndarray, "..."] and its kin
        return np.float64 if "float64" in hint.dtypes else np.int64
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is np.ndarray:
        return get_args(arguments[1])[0]
    if hasattr(origin, "__value__"):  # a type alias, as NDArray is one since numpy 2.5
        return _array_dtype(origin.__value__[arguments])
    return None


def _has_rows_of_three(hint: Any) -> bool:
    """Whether an array is one of rows of three, as its shape says; all other arrays have one axis."""
    *rows, last = getattr(hint, "dim_str", "").split() or [""]
    return len(rows) == 1 and last == "3"


def _typed(hint: Any, value: Any) -> Any:
    """The dataclass, tuple or array that a checked plain value stands for."""
    if is_dataclass(hint) and isinstance(hint, type):
        hints = get_type_hints(hint)
        content = {field.name: _typed(hints[field.name], getattr(value, field.name)) for field in fields(hint)}
        return hint(**content)
    dtype = _array_dtype(hint)
    if dtype is not None:
        array = np.array(value, dtype=dtype)
        return array.reshape(-1, 3) if _has_rows_of_three(hint) else array
    if get_origin(hint) is tuple:
        return tuple(_typed(get_args(hint)[0], item) for item in value)
    if get_origin(hint) in (Union, UnionType) and value is not None:
        return _typed(next(option for option in get_args(hint) if option is not type(None)), value)
    return value


def _check(model: ActionModel, path: Path) -> None:
    """What the types cannot say."""
    if model.constraint not in CONSTRAINT_TYPES:
        raise FileFormatError(path, "$.constraint", f"is {model.constraint!r}", f"one of {', '.join(CONSTRAINT_TYPES)}")
    roles = {role.name for role in model.roles}
    _check_learned(model, roles, path, "$")
    for index, variant in enumerate(model.variants):
        where = f"$.variants[{index}]"
        _check_learned(variant, roles, path, where)
        known = range(len(model.demonstrations))
        if not len(variant.demonstrations) or not all(one in known for one in variant.demonstrations.tolist()):
            raise FileFormatError(path, f"{where}.demonstrations", "names others", f"indices below {len(known)}")
    for index, sketch in enumerate(model.demonstrations):
        for number, candidate in enumerate(sketch.candidates):
            for position, channel in enumerate(candidate.channels):
                place = f"$.demonstrations[{index}].candidates[{number}].channels[{position}]"
                _increasing(channel.time, 2, path, f"{place}.time")
                _same_length(channel.value, channel.time, path, f"{place}.value")


def _check_learned(learned: ActionModel | Variant, roles: set[str], path: Path, where: str) -> None:
    """Check what a model and each of its variants hold; ``where`` is the place of that in the file."""
    _increasing(learned.keypoint_times, 2, path, f"{where}.keypoint_times")
    duration = float(learned.keypoint_times[-1])
    for index, hold in enumerate(learned.holds):
        if hold.role not in roles:
            place = f"{where}.holds[{index}].role"
            raise FileFormatError(path, place, f"is {hold.role!r}", f"one of {', '.join(roles)}")
    for index, change in enumerate(learned.changes):
        _check_change(change, duration, roles, path, f"{where}.changes[{index}]")


def _check_change(change: GeneralizedChange, duration: float, roles: set[str], path: Path, where: str) -> None:
    for role in change.pair.roles:
        if role not in roles:
            raise FileFormatError(path, f"{where}.pair", f"names {role!r}", f"one of {', '.join(roles)}")
    if change.constraint not in CONSTRAINT_TYPES:
        expected = f"one of {', '.join(CONSTRAINT_TYPES)}"
        raise FileFormatError(path, f"{where}.constraint", f"is {change.constraint!r}", expected)
    names = constraint_type(change.constraint).channel_names
    if tuple(channel.name for channel in change.channels) != names:
        raise FileFormatError(path, f"{where}.channels", "are not those of the type", ", ".join(names))
    for position, channel in enumerate(change.channels):
        place = f"{where}.channels[{position}]"
        _increasing(channel.time, 2, path, f"{place}.time")
        if channel.time[0] != 0.0 or not math.isclose(channel.time[-1], duration, abs_tol=1e-6):
            raise FileFormatError(path, f"{place}.time", "does not span the action", f"0 to {duration:g}")
        for name in ("mean", "std", "count"):
            _same_length(getattr(channel, name), channel.time, path, f"{place}.{name}")
        if (channel.std < 0).any():
            raise FileFormatError(path, f"{place}.std", "has a negative number", "0 or more")


def _increasing(values: Float[np.ndarray, " times"], least: int, path: Path, where: str) -> None:
    if len(values) < least or not np.all(np.diff(values) > 0):
        raise FileFormatError(path, where, "does not increase", f"{least} or more times in order")


def _same_length(
    values: Shaped[np.ndarray, " values"], time: Float[np.ndarray, " times"], path: Path, where: str
) -> None:
    if len(values) != len(time):
        raise FileFormatError(path, where, f"has {len(values)} numbers", f"{len(time)}, one for each time")
