from dataclasses import dataclass
from pathlib import Path

import pytest

from sbam.batch.kept_results import KeptResults, Key


@dataclass(frozen=True)
class Measured:
    name: str
    values: tuple[float, ...]


RESULT = Measured("one", (0.1, 1.0 / 3.0))
KEY = Key("one", "abc")


def test_a_kept_result_is_found_again(tmp_path: Path) -> None:
    kept = KeptResults(tmp_path / "new", Measured)
    assert kept.find(KEY) is None
    kept.keep(KEY, RESULT)
    assert kept.find(KEY) == RESULT
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["one.json"]


def test_a_result_that_depended_on_something_else_is_not_found(tmp_path: Path) -> None:
    kept = KeptResults(tmp_path, Measured)
    kept.keep(Key("one", "before"), RESULT)
    assert kept.find(KEY) is None
    assert KeptResults(tmp_path, Measured, any_fingerprint=True).find(KEY) == RESULT
    assert kept.find(Key("other", "before")) is None


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: content[:-10],
        lambda content: b"",
        lambda content: b"\xff" + content,
        lambda content: content.replace(b'"values"', b'"numbers"'),
        lambda content: b"[]",
    ],
)
def test_a_damaged_result_is_not_found(tmp_path: Path, damage) -> None:
    kept = KeptResults(tmp_path, Measured)
    kept.keep(KEY, RESULT)
    file = tmp_path / "one.json"
    file.write_bytes(damage(file.read_bytes()))
    assert kept.find(KEY) is None
    kept.keep(KEY, RESULT)
    assert kept.find(KEY) == RESULT


def test_without_a_folder_nothing_is_kept() -> None:
    kept = KeptResults(None, Measured)
    kept.keep(KEY, RESULT)
    assert kept.find(KEY) is None
