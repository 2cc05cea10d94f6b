"""YAML files checked against a schema, with errors that say where and what would be valid."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import yaml
from msgspec import inspect

from sbam.errors import FileFormatError

T = TypeVar("T")


class _Loader(yaml.SafeLoader):
    """Safe loader that reads ``1e-3`` as a number (YAML 1.2) and refuses a key that is given twice."""


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    keys = [loader.construct_object(key, deep=True) for key, _ in node.value]
    for position, key in enumerate(keys):
        if key in keys[:position]:
            mark = node.value[position][0].start_mark
            raise yaml.constructor.ConstructorError(None, None, f"key {key!r} is given twice", mark)
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def read_yaml(path: str | Path) -> Any:
    """Plain content of a YAML file.

    Args:
        path: the file, UTF-8.

    Returns:
        Dictionaries, lists, strings, numbers; every number finite.

    Raises:
        FileFormatError: if the file is missing, is no YAML, gives a key twice or holds a number that is not finite.
    """
    path = Path(path)
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as error:
        raise FileFormatError(path, "", f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise FileFormatError(path, f"byte {error.start}", "is not UTF-8 text", "a YAML file") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise FileFormatError(path, where, f"is not valid YAML: {error.problem or error.context}") from error
    except yaml.YAMLError as error:
        raise FileFormatError(path, "", f"is not valid YAML: {error}") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise FileFormatError(path, "", f"is not valid YAML: {error}") from error
    for where, value in _numbers(content, "$"):
        if not math.isfinite(value):
            raise FileFormatError(path, where, f"is {value}", "a finite number")
    return content


def convert(content: Any, schema: type[T], path: str | Path, where: str = "$") -> T:
    """Content of a file as a typed object; nothing is coerced, nothing unknown is accepted.

    Args:
        content: plain content, as `read_yaml` gives it.
        schema: a `msgspec.Struct` or any type that msgspec knows.
        path: the file, for messages.
        where: place of ``content`` inside the file, for messages.

    Raises:
        FileFormatError: with the place inside the file, what was expected and the valid names.
    """
    try:
        return msgspec.convert(content, schema, strict=True)
    except msgspec.ValidationError as error:
        problem, _, inside = str(error).partition(" - at `")
        inside = inside.rstrip("`").removeprefix("key in ").removeprefix("$")
        valid = _valid_names(schema, content, inside, problem)
        expected = f"one of {', '.join(valid)}" if valid else ""
        raise FileFormatError(path, where + inside, problem[:1].lower() + problem[1:], expected) from error


def _numbers(content: Any, where: str) -> Iterator[tuple[str, float]]:
    if isinstance(content, float):
        yield where, content
    elif isinstance(content, Mapping):
        for key, value in content.items():
            yield from _numbers(value, f"{where}.{key}")
    elif isinstance(content, list):
        for index, value in enumerate(content):
            yield from _numbers(value, f"{where}[{index}]")


def _valid_names(schema: type, content: Any, inside: str, problem: str) -> list[str]:
    """Field names or literal values that would have been valid at that place; empty where the message says enough."""
    if not problem.startswith(("Object contains unknown field", "Invalid enum value", "Invalid value")):
        return []
    node = inspect.type_info(schema)
    steps = re.findall(r"\.(\w+)|\[(\d+|\.\.\.)\]", inside)
    for field_name, index in steps:
        node = _choose(node, content)
        if isinstance(node, _Tags):
            return list(node.tags)
        if field_name and isinstance(node, inspect.StructType):
            fields = {field.encode_name: field.type for field in node.fields}
            if field_name == node.tag_field:
                return [str(node.tag)]
            if field_name not in fields:
                return []
            node = fields[field_name]
            content = content.get(field_name) if isinstance(content, Mapping) else None
        elif index and isinstance(node, inspect.ListType | inspect.VarTupleType):
            node = node.item_type
            content = content[int(index)] if index != "..." and isinstance(content, list) else None
        else:
            return []
    node = _choose(node, content)
    if isinstance(node, _Tags):
        return list(node.tags)
    if isinstance(node, inspect.LiteralType):
        return [str(value) for value in node.values]
    if isinstance(node, inspect.StructType):
        tag = [node.tag_field] if node.tag_field else []
        return tag + [field.encode_name for field in node.fields]
    return []


class _Tags:
    """The tags of a union of structs whose tag in the file fits none of them."""

    def __init__(self, tags: tuple[str, ...]) -> None:
        self.tags = tags


def _choose(node: Any, content: Any) -> Any:
    """The member of a union that the content means."""
    if not isinstance(node, inspect.UnionType):
        return node
    members = [member for member in node.types if not isinstance(member, inspect.NoneType)]
    structs = [member for member in members if isinstance(member, inspect.StructType)]
    if len(members) == 1 or not structs:
        return members[0]
    for member in structs:
        if isinstance(content, Mapping) and member.tag_field and content.get(member.tag_field) == member.tag:
            return member
    return _Tags(tuple(str(member.tag) for member in structs))
