"""`sbam learn`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from sbam.cli.options import Constraints, Mode, Objects, RecordingsOptions, library_of
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class LearnVerb(RecordingsOptions):
    """Learn a model from recordings of a person doing one task."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="MODEL", help="Where to write the model.")]
    constraints: Constraints = "cartesian"
    mode: Annotated[Mode, arg(help="The best we know, or the paper's way with its faults.")] = "default"
    name: Annotated[str | None, arg(metavar="NAME", help="Name of the action; default: that of the file.")] = None
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.learning.report import model_report

        library = library_of(self.objects)
        with counting("reading") as progress:
            demonstrations = sbam.load(self.recordings, progress)
        with counting("learning") as progress:
            name = self.name or self.output.stem
            model = sbam.learn(demonstrations, self.constraints, self.mode, library, name, progress)
        sbam.save_model(model, self.output)
        return {"file": str(self.output), **model_report(model)}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import model_line

        yield f"{report['file']}: {model_line(report)}"
