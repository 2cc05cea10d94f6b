"""`sbam simulate`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from sbam.cli.options import BUILT_IN_CONSTRAINTS, Mode, Objects, VerbOptions, library_of, some_of
from sbam.console.running import Report, usage_error

if TYPE_CHECKING:
    from rich.console import RenderableType


def _known_tasks(_: str) -> str:
    """Called for the help of this verb alone: it takes a while to look through all that is installed."""
    from sbam.extensions import names

    return f"(known: {', '.join(names('sbam.tasks'))})"


@dataclass(frozen=True, kw_only=True)
class SimulateVerb(VerbOptions):
    """Try a written plan in physics: does the drink end up in the cup?"""

    plan: Positional[
        Annotated[Path | None, arg(metavar="PLAN", help="Folder that `sbam plan -o` wrote; or give --sweep.")]
    ] = None
    task: Annotated[
        str | None,
        arg(
            metavar="TASK",
            help="What is tried: a name, or a Python file that defines TASK; default: what fits.",
            help_behavior_hint=_known_tasks,
        ),
    ] = None
    demonstrations: Annotated[
        tuple[str, ...],
        arg(
            metavar="RECORDING...",
            help="What success is measured against; default: the built-in ones of the task.",
            help_behavior_hint="",
        ),
    ] = ()
    grasp: Annotated[
        Literal["weld", "contact"], arg(help="Objects are rigid in the hand (assumed), or held by the fingers.")
    ] = "weld"
    grasp_force: Annotated[float, arg(help="Of each finger that holds by contact, N.")] = 40.0
    video: Annotated[Path | None, arg(metavar="FILE", help="Also write a film (.mp4) or moments (.png).")] = None
    sweep: Annotated[
        Path | None,
        arg(metavar="DIR", help="Instead plan and try random scenes; the folder keeps every trial, so it can go on."),
    ] = None
    scenes: Annotated[int, arg(help="Random scenes of a sweep.")] = 20
    robots: Annotated[tuple[str, ...], arg(metavar="ROBOT...", help="Robots of a sweep.", help_behavior_hint="")] = (
        "panda_dual",
    )
    constraints: Annotated[tuple[str, ...], some_of("sbam.constraints", BUILT_IN_CONSTRAINTS, "Types of a sweep.")] = (
        BUILT_IN_CONSTRAINTS
    )
    modes: Annotated[tuple[Mode, ...], arg(help="How to learn and plan in a sweep.")] = ("default",)
    paper_scenes: Annotated[
        int | None, arg(metavar="COUNT", help="Fewer scenes for mode paper, which takes a minute a plan.")
    ] = None
    any_version: Annotated[bool, arg(help="Also take trials of a sweep that another version of sbam made.")] = False
    jobs: Annotated[int, arg(help="Processes of a sweep; -1 for one per core.")] = -1
    cluster: Annotated[
        str | None, arg(metavar="ADDRESS", help="Dask scheduler for a sweep, such as tcp://host:8786.")
    ] = None
    objects: Objects = None

    def __post_init__(self) -> None:
        if (self.plan is None) == (self.sweep is None):
            raise usage_error("give the folder of a plan, or --sweep DIR")
        if self.scenes < 1 or self.jobs == 0 or (self.paper_scenes or 1) < 1:
            raise usage_error("--scenes and --paper-scenes must be 1 or more, and --jobs not 0")
        if self.sweep and self.grasp != "weld":
            raise usage_error("--grasp contact is for a plan, not for --sweep")
        if not 0.0 < self.grasp_force < float("inf"):
            raise usage_error(f"--grasp-force {self.grasp_force:g} is not above 0")

    def __call__(self) -> Report:
        from sbam.console.progress import counting, seconds
        from sbam.simulation.run_folder import simulate_folder

        if self.sweep:
            from sbam.simulation.sweep import sweep

            tasks = (self.task,) if self.task else ("pouring", "rolling")
            with counting("trials") as trials:
                return sweep(
                    self.sweep,
                    tasks,
                    self.robots,
                    self.constraints,
                    self.modes,
                    self.scenes,
                    self.paper_scenes,
                    self.jobs,
                    self.cluster,
                    self.any_version,
                    trials,
                )
        assert self.plan is not None
        library = library_of(self.objects)
        with seconds("simulating") as progress:
            return simulate_folder(
                self.plan,
                self.task,
                self.demonstrations,
                self.video,
                library,
                progress,
                self.grasp,
                self.grasp_force,
            )

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import simulation_lines, sweep_lines

        yield from sweep_lines(report) if self.sweep else simulation_lines(report)
