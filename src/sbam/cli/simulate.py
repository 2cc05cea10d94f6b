"""`sbam simulate`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from sbam.cli.options import Constraints, Mode, Objects, VerbOptions, library_of
from sbam.console.running import Report, usage_error

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class Simulate(VerbOptions):
    """Try a written plan in physics: does the drink end up in the cup?"""

    plan: Positional[
        Annotated[Path | None, arg(metavar="PLAN", help="Folder that `sbam plan -o` wrote; or give --sweep.")]
    ] = None
    task: Annotated[
        str | None,
        arg(metavar="TASK", help="pouring, rolling, or a Python file that defines TASK; default: what fits."),
    ] = None
    demonstrations: Annotated[
        tuple[str, ...],
        arg(
            metavar="RECORDING...",
            help="What success is measured against; default: the built-in ones of the task.",
            help_behavior_hint="",
        ),
    ] = ()
    video: Annotated[Path | None, arg(metavar="FILE", help="Also write a film (.mp4) or moments (.png).")] = None
    sweep: Annotated[
        Path | None,
        arg(metavar="DIR", help="Instead plan and try random scenes; the folder keeps every trial, so it can go on."),
    ] = None
    scenes: Annotated[int, arg(help="Random scenes of a sweep.")] = 20
    robots: Annotated[tuple[str, ...], arg(metavar="ROBOT...", help="Robots of a sweep.", help_behavior_hint="")] = (
        "panda_dual",
    )
    constraints: Annotated[tuple[Constraints, ...], arg(help="Types of a sweep.")] = (
        "cartesian",
        "cylindrical",
        "symbolic",
    )
    modes: Annotated[tuple[Mode, ...], arg(help="How to learn and plan in a sweep.")] = ("default",)
    jobs: Annotated[int, arg(help="Processes of a sweep; -1 for one per core.")] = -1
    objects: Objects = None

    def __post_init__(self) -> None:
        if (self.plan is None) == (self.sweep is None):
            raise usage_error("give the folder of a plan, or --sweep DIR")
        if self.scenes < 1 or self.jobs == 0:
            raise usage_error("--scenes must be 1 or more, and --jobs not 0")

    def __call__(self) -> Report:
        from sbam.console.progress import counting, seconds
        from sbam.simulation.run_folder import simulate_folder

        if self.sweep:
            from sbam.simulation.sweep import sweep

            tasks = (self.task,) if self.task else ("pouring", "rolling")
            with counting("trials") as trials:
                return sweep(
                    self.sweep, tasks, self.robots, self.constraints, self.modes, self.scenes, self.jobs, trials
                )
        assert self.plan is not None
        library = library_of(self.objects)
        with seconds("simulating") as progress:
            return simulate_folder(self.plan, self.task, self.demonstrations, self.video, library, progress)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import simulation_lines, sweep_lines

        yield from sweep_lines(report) if self.sweep else simulation_lines(report)
