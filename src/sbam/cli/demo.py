"""`sbam demo`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from sbam.cli.options import Constraints, VerbOptions
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class DemoVerb(VerbOptions):
    """Learn the built-in pouring demonstrations, plan a new scene on two Pandas, write everything there is to see."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for what is written.")] = Path("out/demo")
    constraints: Constraints = "cartesian"

    def __call__(self) -> Report:
        from sbam.console.progress import stages
        from sbam.demo import run_demo

        with stages("demo") as progress:
            return run_demo(self.output, self.constraints, progress)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import demo_lines

        yield from demo_lines(report)
