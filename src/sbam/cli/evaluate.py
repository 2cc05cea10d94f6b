"""`sbam evaluate`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from sbam.cli.options import BUILT_IN_CONSTRAINTS, Mode, Objects, VerbOptions, library_of, some_of
from sbam.console.running import Report, usage_error

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class EvaluateVerb(VerbOptions):
    """Measure like the paper: cross-validate a task, or test a model on recordings that it was not learned from."""

    recordings: Positional[
        Annotated[
            tuple[str, ...],
            arg(
                metavar="TASK|RECORDING...",
                help="pouring, rolling (built-in), or recordings of one task.",
                help_behavior_hint="",
            ),
        ]
    ]
    train: Annotated[
        tuple[str, ...],
        arg(
            metavar="TASK|RECORDING...",
            help="Learn from these instead of cross-validating.",
            help_behavior_hint="",
        ),
    ] = ()
    train_objects: Annotated[
        tuple[str, ...],
        arg(
            metavar="OBJECT...",
            help="Learn only from demonstrations that show all of these, such as apple_juice.",
            help_behavior_hint="",
        ),
    ] = ()
    robot: Annotated[
        str, arg(metavar="ROBOT", help="Name or file of a robot; flying_hands for none: quick, without its limits.")
    ] = "panda_dual"
    constraints: Annotated[tuple[str, ...], some_of("sbam.constraints", BUILT_IN_CONSTRAINTS, "Types to compare.")] = (
        BUILT_IN_CONSTRAINTS
    )
    mode: Annotated[tuple[Mode, ...], arg(help="How to learn; of several the first is compared with.")] = ("default",)
    solver: Annotated[tuple[Mode, ...], arg(help="How to solve; the paper's takes a minute a fold.")] = ("default",)
    prune: Annotated[
        float | None, arg(metavar="SHARE", help="Drop pairs with a lower precision relative to the best, 0 to 1.")
    ] = None
    seed: Annotated[int, arg(help="Seed of the built-in demonstrations.")] = 0
    jobs: Annotated[int, arg(help="Processes; -1 for one per core.")] = -1
    cluster: Annotated[str | None, arg(metavar="ADDRESS", help="Dask scheduler, such as tcp://host:8786.")] = None
    cache: Annotated[
        Path | None,
        arg(metavar="DIR", help="Where finished folds are kept, to resume; default: the user's cache folder."),
    ] = None
    fresh: Annotated[bool, arg(help="Neither use nor keep finished folds.")] = False
    output: Annotated[
        Path | None, arg(aliases=["-o"], metavar="DIR", help="Write the tables as Markdown, CSV and LaTeX.")
    ] = None
    objects: Objects = None

    def __post_init__(self) -> None:
        if not self.recordings:
            raise usage_error("give a task (pouring, rolling) or recordings")
        if self.seed < 0:
            raise usage_error(f"--seed {self.seed} is negative")
        if self.jobs == 0:
            raise usage_error("--jobs 0 does no work; give a number of processes, or -1 for one per core")

    def __call__(self) -> Report:
        from sbam.console.progress import counting
        from sbam.evaluation.evaluate import default_cache, run_evaluation

        with counting("folds") as progress:
            return run_evaluation(
                self.recordings,
                self.output,
                train=self.train,
                train_objects=self.train_objects,
                robot=self.robot,
                constraints=self.constraints,
                modes=self.mode,
                solvers=self.solver,
                prune=self.prune,
                seed=self.seed,
                library=library_of(self.objects),
                jobs=self.jobs,
                cache=None if self.fresh else self.cache or default_cache(),
                cluster=self.cluster,
                progress=progress,
            )

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import evaluation_tables

        yield from evaluation_tables(report)
