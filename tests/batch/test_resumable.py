from pathlib import Path

import pytest

from sbam.batch.kept_results import KeptResults, Key
from sbam.batch.resumable import resumed

KEYS = [Key(f"piece {number}", "same") for number in range(4)]


def square(number: int) -> int:
    if number < 0:
        raise KeyboardInterrupt
    return number**2


def test_only_what_is_left_is_done(tmp_path: Path) -> None:
    kept = KeptResults(tmp_path, int)
    kept.keep(KEYS[2], 40)
    asked: list[int] = []

    def piece(index: int):
        asked.append(index)
        return square, (index,)

    counted: list[tuple[int, int]] = []
    steps = [dict(found) for found in resumed(KEYS, piece, kept, 1, progress=lambda *n: counted.append(n))]
    assert steps[0] == {2: 40}
    assert steps[-1] == {0: 0, 1: 1, 2: 40, 3: 9}
    assert asked == [0, 1, 3]
    assert counted == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert [kept.find(key) for key in KEYS] == [0, 1, 40, 9]


def test_what_was_finished_before_an_interruption_is_kept(tmp_path: Path) -> None:
    kept = KeptResults(tmp_path, int)
    with pytest.raises(KeyboardInterrupt):
        list(resumed(KEYS, lambda index: (square, (index if index < 2 else -1,)), kept, 1))
    assert [kept.find(key) for key in KEYS] == [0, 1, None, None]


def test_a_result_may_be_made_of_what_came_back(tmp_path: Path) -> None:
    kept = KeptResults(tmp_path, str)
    *_, results = resumed(
        KEYS, lambda index: (pow, (index, 2)), kept, 2, receive=lambda index, found: f"{index}: {found}"
    )
    assert results[3] == "3: 9" == kept.find(KEYS[3])


def test_no_work_has_no_results() -> None:
    *_, results = resumed([], lambda index: (square, (index,)), KeptResults(None, int), 1)
    assert results == {}
