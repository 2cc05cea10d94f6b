"""Objects that other distributions register, and what is wrong with some of them."""

import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest

from sbam.errors import ExtensionError, SbamError
from sbam.extensions import _installed, names, registered

GROUP = "sbam.shapes"
SOURCE = """
class Shape:
    sides = 4

class Broken(Shape):
    def __init__(self):
        raise ValueError("no sides")

square = Shape()
"""


@pytest.fixture
def install(distribution, monkeypatch) -> Iterator[Callable[..., Mapping[str, Any]]]:
    """``install(name, source, objects)``: registers objects of a new distribution; returns the group."""

    def build(name: str, source: str, objects: Mapping[str, str]) -> Mapping[str, Any]:
        monkeypatch.delitem(sys.modules, name.replace("-", "_"), raising=False)
        monkeypatch.syspath_prepend(distribution(name, source, {GROUP: objects}))
        _installed.cache_clear()
        registered.cache_clear()
        return registered(GROUP)

    yield build
    _installed.cache_clear()
    registered.cache_clear()


def test_a_group_without_objects_is_empty() -> None:
    assert dict(registered("sbam.nothing")) == {}
    assert names("sbam.nothing") == ()


def test_objects_are_found_by_name_and_loaded_once(install) -> None:
    shapes = install("shapes-one", SOURCE, {"square": "square", "class": "Shape"})
    assert names(GROUP) == ("class", "square") == tuple(shapes)
    assert "square" in shapes and "circle" not in shapes
    assert shapes["square"].sides == 4 and shapes["square"] is shapes["square"]
    assert shapes.get("circle") is None


def test_a_class_of_the_kind_is_called(install) -> None:
    kind = type(install("shapes-two", SOURCE, {"class": "Shape"})["class"]())
    assert isinstance(registered(GROUP, kind)["class"], kind)


@pytest.mark.parametrize(
    ("source", "value", "said"),
    [
        ("import nowhere_at_all", "shape", "ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("1 / 0", "shape", "ZeroDivisionError"),
        ("", "shape", "AttributeError"),
        (SOURCE, "Broken.sides", "is 4, expected Mapping"),
    ],
)
def test_what_cannot_be_used_says_whose_it_is(install, source: str, value: str, said: str) -> None:
    install("shapes-three", source, {"shape": value})
    assert names(GROUP) == ("shape",)
    with pytest.raises(ExtensionError) as raised:
        registered(GROUP, Mapping)["shape"]
    message = str(raised.value)
    assert isinstance(raised.value, SbamError)
    for part in (said, "shapes-three 1.0", GROUP, "'shape'", value):
        assert part in message


def test_a_name_that_two_register_is_refused_and_the_others_stay(install) -> None:
    install("shapes-four", SOURCE, {"square": "square"})
    shapes = install("shapes-five", SOURCE, {"square": "square", "other": "square"})
    assert shapes["other"].sides == 4
    with pytest.raises(ExtensionError) as raised:
        shapes["square"]
    assert "shapes-four 1.0" in str(raised.value) and "shapes-five 1.0" in str(raised.value)
