"""Running a verb: its report on screen or as JSON, errors as one line, and the exit code."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from sbam.errors import OutputError, SbamError
from sbam.files import write_atomically

if TYPE_CHECKING:
    from rich.console import RenderableType

Report = dict[str, Any]
"""Plain numbers, words, lists and dictionaries; keys: docs, "Reports"."""

DONE, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""

PLAIN_WIDTH = 150
"""Width of tables that go to a file or another program, characters."""


class Verb(Protocol):
    """A verb with its arguments: doing it gives a report, which can be shown."""

    @property
    def json(self) -> str | None:
        """File for the report as JSON, ``-`` for standard output."""
        ...

    def __call__(self) -> Report:
        """Do it."""
        ...

    def show(self, report: Report) -> Iterable[RenderableType]:
        """What to print of the report."""
        ...


def run(verb: Verb) -> int:
    """Do a verb, show and write its report.

    Args:
        verb: what to do.

    Returns:
        The exit code: 0 if it did its job, 1 if not, 130 if interrupted.
    """
    name = type(verb).__name__.removesuffix("Verb").lower()
    report: Report
    try:
        report = {"verb": name, "ok": True, "problems": [], **verb()}
        if report["ok"] or report.get("files"):
            _print(verb.show(report), to_stderr=verb.json == "-")
    except KeyboardInterrupt:
        _say("interrupted")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except SbamError as error:
        report = _failure(name, error, str(error))
    except Exception as error:
        if os.environ.get("SBAM_DEBUG") == "1":
            raise
        report = _failure(name, error, f"{type(error).__name__}: {error}")
        _say("this is a fault of sbam; please report it, with what SBAM_DEBUG=1 makes it say")
    for problem in report["problems"]:
        _say(problem)
    try:
        _write(report, verb.json)
    except OutputError as error:
        _say(str(error))
        return FAILED
    return DONE if report["ok"] else FAILED


def usage_error(problem: str) -> SystemExit:
    """What to raise for arguments that do not fit together."""
    _say(problem)
    return SystemExit(WRONG_USAGE)


def _failure(name: str, error: Exception, problem: str) -> Report:
    return {"verb": name, "ok": False, "problems": [problem], "error": type(error).__name__}


def _write(report: Report, path: str | None) -> None:
    if path is None:
        return
    text = json.dumps(report, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if path == "-":
        sys.stdout.write(text)
    else:
        write_atomically(Path(path), text)


def _say(problem: str) -> None:
    """One line on standard error."""
    print("sbam: " + " ".join(problem.split()), file=sys.stderr)


def _print(renderables: Iterable[RenderableType], *, to_stderr: bool) -> None:
    from rich.console import Console

    console = Console(stderr=to_stderr, highlight=False)
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    for renderable in renderables:
        console.print(renderable, soft_wrap=isinstance(renderable, str), markup=False)
