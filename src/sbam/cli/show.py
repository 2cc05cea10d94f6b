"""`sbam show`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from sbam.cli.options import ModelFile, VerbOptions
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class ShowVerb(VerbOptions):
    """Show what a model holds: roles, pairs by relevance, anchors, holds and keypoints."""

    model: Positional[ModelFile]
    plots: Annotated[Path | None, arg(metavar="DIR", help="Also draw the model's figures into this folder.")] = None

    def __call__(self) -> Report:
        import sbam
        from sbam.learning.report import model_report

        model = sbam.load_model(self.model)
        report = {"file": str(self.model), **model_report(model)}
        if self.plots:
            from sbam.plots import write_model_plots

            report["plots"] = [str(path) for path in write_model_plots(model, self.plots)]
        return report

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import model_tables

        yield from model_tables(report)
        yield from (f"wrote {path}" for path in report.get("plots", ()))
