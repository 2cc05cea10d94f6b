"""`sbam scenes`: list scenes, or write one to start from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg
from tyro.extras import SubcommandApp

from sbam.cli.options import Objects, Scene, VerbOptions, library_of
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType

app = SubcommandApp()


@app.command(name="list")
@dataclass(frozen=True, kw_only=True)
class ScenesList(VerbOptions):
    """List the built-in scenes."""

    def __call__(self) -> Report:
        from sbam.scene.built_in_scenes import scene_summaries

        return {"scenes": scene_summaries()}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import scene_list

        yield scene_list(report["scenes"])


@app.command(name="write")
@dataclass(frozen=True, kw_only=True)
class ScenesWrite(VerbOptions):
    """Write a built-in scene, or the first frame of a recording, as a scene file to start from."""

    scene: Positional[Scene]
    output: Annotated[Path, arg(aliases=["-o"], metavar="FILE", help="The scene file (YAML).")]
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam

        scene = sbam.load_scene(self.scene, library_of(self.objects))
        sbam.save_scene(scene, self.output)
        return {"file": str(self.output), "name": scene.name, "objects": list(scene.objects)}

    def show(self, report: Report) -> Iterable[RenderableType]:
        yield f"wrote {report['file']}: {', '.join(report['objects'])}"
