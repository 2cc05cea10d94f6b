"""Writing files: whole or not at all."""

import errno
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from sbam.errors import OutputError
from sbam.files import write_atomically


@pytest.mark.parametrize(("data", "content"), [("Küche\n", "Küche\n".encode()), (b"\x00\xff", b"\x00\xff"), ("", b"")])
def test_text_and_bytes_are_written_into_new_folders(tmp_path: Path, data: str | bytes, content: bytes) -> None:
    path = tmp_path / "new" / "folder" / "file"
    write_atomically(path, data)
    assert path.read_bytes() == content
    assert [entry.name for entry in path.parent.iterdir()] == ["file"]


def test_an_existing_file_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("a long old content")
    write_atomically(path, "new")
    assert path.read_text() == "new"


def test_the_file_has_the_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "usual").write_text("")
    write_atomically(tmp_path / "file", "")
    assert (tmp_path / "file").stat().st_mode == (tmp_path / "usual").stat().st_mode


@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("old", [None, "the old content"])
def test_a_full_disk_leaves_everything_as_it_was(tmp_path: Path, monkeypatch, call: str, old: str | None) -> None:
    path = tmp_path / "file"
    if old is not None:
        path.write_text(old)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, call, full)
    with pytest.raises(OutputError, match=r"cannot write .*file: No space left on device"):
        write_atomically(path, "new")
    assert [entry.read_text() for entry in tmp_path.iterdir()] == ([] if old is None else [old])


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes are POSIX")
def test_a_write_that_the_system_cuts_off_leaves_nothing(tmp_path: Path) -> None:
    """A real failure in the middle of a write: the system allows files of 64 KiB only."""
    program = textwrap.dedent(
        """
        import resource, sys
        from sbam.errors import OutputError
        from sbam.files import write_atomically
        resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))
        write_atomically(sys.argv[1] + "/small", b"x" * 65536)
        try:
            write_atomically(sys.argv[1] + "/large", b"x" * 200_000)
        except OutputError as error:
            print(error)
        """
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, timeout=60, check=True
    )
    assert "cannot write" in done.stdout
    assert "File too large" in done.stdout
    assert [entry.name for entry in tmp_path.iterdir()] == ["small"]


def test_an_interrupt_leaves_nothing(tmp_path: Path, monkeypatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "file", "new")
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"cannot write .*beneath"):
        write_atomically(tmp_path / "file" / "beneath", "new")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OutputError, match=r"cannot write .*folder: Is a directory"):
        write_atomically(tmp_path / "folder", "new")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["file", "folder"]
