"""What the tests of the command line share."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from sbam.cli import main

JUICE = "built-in:synthetic_pouring_juice_right_0"


@pytest.fixture(scope="session")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of pouring."""
    path = tmp_path_factory.mktemp("learned") / "pouring.json"
    assert main(["learn", "built-in:pouring", "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording as MMM file."""
    folder = tmp_path_factory.mktemp("recordings")
    assert main(["recordings", "write", JUICE, "-o", str(folder)]) == 0
    return folder / f"{JUICE.removeprefix('built-in:')}.xml"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(here: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a verb that must fail; returns the one line that it says, having left nothing behind."""

    def run(*arguments: str, code: int = 1) -> str:
        before = {path: path.stat().st_mtime_ns for path in here.rglob("*")}
        capsys.readouterr()
        assert main([*arguments, "--json", "-"]) == code
        out, err = capsys.readouterr()
        report = json.loads(out)
        assert report["ok"] is False
        lines = err.strip().splitlines()
        assert [f"sbam: {' '.join(problem.split())}" for problem in report["problems"]] == lines
        assert len(lines) == 1
        assert "Traceback" not in err
        assert {path: path.stat().st_mtime_ns for path in here.rglob("*")} == before
        return lines[0]

    return run
