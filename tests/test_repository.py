"""What must not get into the repository."""

import re
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[1]

MACHINE_PATH = re.compile(r"(?<![\w.$})-])/(?:work|root|home|tmp|Users)/\w")


@pytest.fixture(scope="module")
def tracked() -> list[Path]:
    try:
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=REPOSITORY, capture_output=True, check=True, text=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("not a git checkout")
    paths = [REPOSITORY / name for name in listed.stdout.split("\0") if name]
    return [path for path in paths if path.is_file()]


def test_no_path_of_anyone_s_machine(tracked: list[Path]) -> None:
    found = [
        f"{path.relative_to(REPOSITORY)}:{number}: {line.strip()}"
        for path in tracked
        if b"\0" not in (content := path.read_bytes())
        for number, line in enumerate(content.decode(errors="replace").splitlines(), 1)
        if MACHINE_PATH.search(line) and path != Path(__file__)
    ]
    assert found == []


@pytest.mark.parametrize("path", ["/home/me/data", "'/" + "tmp/x'", "see /" + "work/main", "=/" + "root/a"])
def test_machine_paths_are_recognised(path: str) -> None:
    assert MACHINE_PATH.search(path)


@pytest.mark.parametrize(
    "text", ["https://a.org/" + "home/x", "$HOME/" + "work/x", "out/" + "tmp/x", "home/x", "tmp_path"]
)
def test_other_text_is_not_taken_for_one(text: str) -> None:
    assert not MACHINE_PATH.search(text)


def test_no_file_is_large(tracked: list[Path]) -> None:
    assert {str(path.relative_to(REPOSITORY)) for path in tracked if path.stat().st_size > 3_000_000} == set()
