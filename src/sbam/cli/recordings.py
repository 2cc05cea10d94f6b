"""`sbam recordings`: list, describe or write recordings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg
from tyro.extras import SubcommandApp

from sbam.cli.options import Objects, RecordingsOptions, VerbOptions, library_of, one_of
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType

app = SubcommandApp()


@app.command(name="list")
@dataclass(frozen=True, kw_only=True)
class RecordingsList(VerbOptions):
    """List the built-in recordings, or those in a folder."""

    folder: Positional[Annotated[Path | None, arg(metavar="FOLDER", help="Where to look.")]] = None

    def __call__(self) -> Report:
        from sbam.demonstrations.report import list_recordings

        return list_recordings(self.folder)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import recording_list

        yield recording_list(report["where"], report["recordings"])
        yield from (f"cannot be used: {problem}" for problem in report["unusable"])


@app.command(name="info")
@dataclass(frozen=True, kw_only=True)
class RecordingsInfo(RecordingsOptions):
    """Say what is in recordings: objects, hands, events, holds, repairs, labels."""

    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.demonstrations.report import demonstration_report

        library = library_of(self.objects)
        return {"recordings": [demonstration_report(one, library) for one in sbam.load(self.recordings)]}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import recording_tables

        for one in report["recordings"]:
            yield from recording_tables(one)


@app.command(name="write")
@dataclass(frozen=True, kw_only=True)
class RecordingsWrite(RecordingsOptions):
    """Write recordings into a folder, also in another format."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for the files.")]
    format: Annotated[str, one_of("sbam.writers", "mmm", "MMM 2.0, our own NPZ, KIT CSV, or an extension's.")] = "mmm"

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.demonstrations.writers import write_demonstrations

        with counting("writing") as progress:
            files = write_demonstrations(sbam.load(self.recordings), self.output, self.format, progress)
        return {"files": [str(path) for path in files]}

    def show(self, report: Report) -> Iterable[RenderableType]:
        yield from (f"wrote {path}" for path in report["files"])
