"""The command line as a process: full disks, readers that stop early, and a quick start."""

import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

JUICE = "built-in:synthetic_pouring_juice_right_0"


def sbam_process(*arguments: str, cwd: Path, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sbam.cli", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, **options)


def small_files() -> None:
    """No file may grow beyond 4 kB, as on a disk that is full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are POSIX")
@pytest.mark.parametrize("verb", ["learn", "plan"])
def test_a_full_disk(learned, here, verb: str) -> None:
    arguments = {
        "learn": ["learn", JUICE, "-o", "new/model.json"],
        "plan": ["plan", str(learned), "--scene", "built-in:pouring_new_layout", "-o", "new/out"],
    }[verb]
    done = sbam_process(*arguments, cwd=here, preexec_fn=small_files)
    assert done.returncode == 1
    assert done.stderr.startswith("sbam: cannot write") and len(done.stderr.splitlines()) == 1
    assert [path for path in here.rglob("*") if path.is_file()] == []


def test_nothing_heavy_is_imported_for_help(here) -> None:
    heavy = ("scipy", "mujoco", "matplotlib", "viser", "numpy")
    code = f"import sys, sbam, sbam.cli; print(sorted(set(sys.modules) & set({heavy!r})))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    done = sbam_process("--help", cwd=here)
    assert done.returncode == 0
    for verb in ("learn", "add", "show", "plan", "recordings", "demo"):
        assert verb in done.stdout


def test_a_reader_that_stops_early_is_no_fault(here) -> None:
    command = f"{sys.executable} -m sbam.cli recordings list | head -n 1"
    done = subprocess.run(["bash", "-c", command], cwd=here, capture_output=True, text=True, env=os.environ)
    assert "Traceback" not in done.stderr and "fault of sbam" not in done.stderr
