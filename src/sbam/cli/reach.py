"""`sbam reach`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from sbam.cli.options import ModelFile, Objects, Roles, Scene, VerbOptions, library_of, pairs
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class ReachVerb(VerbOptions):
    """Say whether a robot reaches a scene, and where its base or the objects would have to be."""

    model: Positional[ModelFile]
    scene: Scene
    robot: Annotated[
        str | None, arg(metavar="ROBOT", help="Name or file of a robot; default: the scene's, else panda_dual.")
    ] = None
    roles: Roles = ()
    picture: Annotated[Path | None, arg(metavar="FILE", help="Also draw the map of places (.png, .pdf, .svg).")] = None
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.planning.placement.report import base_report

        roles = pairs("roles", "ROLE=OBJECT", self.roles)
        model = sbam.load_model(self.model)
        scene = sbam.load_scene(self.scene, library_of(self.objects))
        with counting("searching") as progress:
            found = sbam.search_base(model, scene, self.robot, roles=roles, progress=progress)
        report = {**base_report(found), "picture": None, "files": []}
        if self.picture:
            from sbam.plots import plot_base_map, save_figure

            save_figure(plot_base_map(found), self.picture)
            report["picture"], report["files"] = str(self.picture), [str(self.picture)]
        report["problems"] = [] if report["ok"] else report["sentences"]
        return report

    def show(self, report: Report) -> Iterable[RenderableType]:
        if report["ok"]:
            yield from report["sentences"]
        if report["picture"]:
            yield f"wrote {report['picture']}"
