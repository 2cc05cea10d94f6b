"""Reading YAML: what is no YAML, and what YAML would quietly get wrong."""

from typing import Literal

import msgspec
import pytest

from sbam.errors import FileFormatError
from sbam.schema import convert, read_yaml


class Part(msgspec.Struct, forbid_unknown_fields=True):
    kind: Literal["a", "b"]
    size: float | None = None


class Whole(msgspec.Struct, forbid_unknown_fields=True):
    parts: list[Part]
    main: Part | None = None


def write(tmp_path, content: str | bytes):
    path = tmp_path / "file.yaml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("a: [1, 2", "line 1.*is not valid YAML"),
        ("a: 1\nb: 2\na: 3", r"line 3, column 1.*'a' is given twice"),
        ("a: !!python/object/apply:os.getcwd []", "is not valid YAML"),
        (b"a: \xff", "byte 3.*UTF-8"),
        ("a: {b: [1.0, .inf]}", r"\$\.a\.b\[1\]: is inf"),
        ("a: .nan", r"\$\.a: is nan"),
        ("a: 2024-13-45", "is not valid YAML"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, content, says) -> None:
    with pytest.raises(FileFormatError, match=says):
        read_yaml(write(tmp_path, content))


def test_a_missing_file_is_named(tmp_path) -> None:
    with pytest.raises(FileFormatError, match=r"absent\.yaml: cannot be read: No such file"):
        read_yaml(tmp_path / "absent.yaml")


def test_exponents_without_a_point_are_numbers(tmp_path) -> None:
    assert read_yaml(write(tmp_path, "[1e-3, -2E5, 1.5e+2, 1e, 12]")) == [1e-3, -2e5, 150.0, "1e", 12]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"parts": [{"kind": "c"}]}, r"\$\.x\.parts\[0\]\.kind.*'c' \(expected one of a, b\)"),
        ({"parts": [{"kind": "a", "siz": 1}]}, r"\$\.x\.parts\[0\]: .*`siz` \(expected one of kind, size\)"),
        ({"parts": [], "main": {"kind": "c"}}, r"\$\.x\.main\.kind.*a, b"),
        ({"parts": [], "mian": 1}, r"\$\.x: .*`mian` \(expected one of parts, main\)"),
        ({"parts": 1}, r"\$\.x\.parts: expected `array`, got `int`$"),
    ],
)
def test_conversion_says_where_and_what_is_valid(content, says) -> None:
    with pytest.raises(FileFormatError, match=says):
        convert(content, Whole, "file.yaml", "$.x")
