"""A folder is written completely or not at all."""

from pathlib import Path

import pytest

from sbam.errors import OutputError
from sbam.results import write_folder


def test_files_arrive_where_they_belong_and_others_stay(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old.txt").write_text("old")
    (tmp_path / "out" / "a.txt").write_text("before")

    def write(draft: Path) -> None:
        (draft / "a.txt").write_text("a")
        (draft / "plots").mkdir()
        (draft / "plots" / "b.png").write_text("b")

    files = write_folder(tmp_path / "out", write)
    assert files == [tmp_path / "out" / "a.txt", tmp_path / "out" / "plots" / "b.png"]
    assert [file.read_text() for file in files] == ["a", "b"]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"old.txt", "a.txt", "plots"}


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), OutputError("draft/b", "disk full")])
def test_nothing_is_left_if_the_second_file_cannot_be_written(tmp_path: Path, error: Exception) -> None:
    def write(draft: Path) -> None:
        (draft / "a.txt").write_text("a")
        raise error

    with pytest.raises(OutputError, match=r"cannot write .*new.*out: (No space left|disk full)"):
        write_folder(tmp_path / "new" / "out", write)
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_leaves_nothing(tmp_path: Path) -> None:
    def write(draft: Path) -> None:
        (draft / "a.txt").write_text("a")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_folder(tmp_path / "out", write)
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    with pytest.raises(OutputError, match="out"):
        write_folder(tmp_path / "out", lambda draft: None)
    assert (tmp_path / "out").read_text() == "a file"
