"""`sbam add`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from sbam.cli.options import ModelFile, Objects, Recordings, VerbOptions, library_of
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class AddVerb(VerbOptions):
    """Add recordings to a model; the earlier ones are not needed."""

    model: Positional[ModelFile]
    recordings: Positional[Recordings]
    output: Annotated[
        Path | None, arg(aliases=["-o"], metavar="MODEL", help="Where to write the model; default: in place.")
    ] = None
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.learning.report import model_report

        library = library_of(self.objects)
        model = sbam.load_model(self.model)
        with counting("adding") as progress:
            demonstrations = sbam.load(self.recordings)
            for done, demonstration in enumerate(demonstrations, 1):
                model = sbam.add_demonstration(model, demonstration, library)
                progress(done, len(demonstrations))
        output = self.output or self.model
        sbam.save_model(model, output)
        return {"file": str(output), **model_report(model)}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import model_line

        yield f"{report['file']}: {model_line(report)}"
