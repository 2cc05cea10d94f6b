"""`sbam plan`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from sbam.cli.options import (
    Mode,
    ModelFile,
    Objects,
    Roles,
    Scene,
    VerbOptions,
    library_of,
    number,
    pairs,
    some_added_to,
    some_of,
)
from sbam.console.running import Report, usage_error

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, kw_only=True)
class PlanVerb(VerbOptions):
    """Plan a learned action for a robot in a scene and write the trajectory."""

    model: Positional[ModelFile]
    scene: Scene
    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for what is written.")]
    robot: Annotated[
        str | None, arg(metavar="ROBOT", help="Name or file of a robot; default: the scene's, else panda_dual.")
    ] = None
    solver: Annotated[Mode, arg(help="The fast one, or the paper's (minutes).")] = "default"
    roles: Roles = ()
    start: Annotated[
        tuple[str, ...],
        arg(
            metavar="JOINT=POSITION...",
            help="Where the robot stands now, rad; default: its home.",
            help_behavior_hint="",
        ),
    ] = ()
    human_likeness: Annotated[
        float | None, arg(metavar="WEIGHT", help="Weight of human-like postures; default: the robot's.")
    ] = None
    posture: Annotated[
        Literal["directions", "joints"], arg(help="What is compared with a person: arms, or ARMAR's joints.")
    ] = "directions"
    between: Annotated[
        Literal["poses", "primitive", "splines", "lines"] | None,
        arg(metavar="poses|primitive|splines|lines", help="What runs between keypoints; default: the solver's way."),
    ] = None
    clearance: Annotated[float, arg(help="Distance to keep from what is not touched on purpose, m.")] = 0.0
    margin: Annotated[float, arg(help="Distance beyond it that is sought where something is nearer, m.")] = 0.01
    prune: Annotated[
        float | None, arg(metavar="SHARE", help="Do without pairs below this share of the best precision, 0 to 1.")
    ] = None
    speed: Annotated[float, arg(help="Share of the robot's velocity limits, above 0 to 1.")] = 0.5
    seed: Annotated[int, arg(help="Seed of the random starts.")] = 0
    formats: Annotated[tuple[str, ...], some_of("sbam.plan_writers", ("npz", "csv"), "Formats of the trajectory.")] = (
        "npz",
        "csv",
    )
    terms: Annotated[
        tuple[str, ...], some_added_to("sbam.terms", "Further terms of the objective, which extensions add.")
    ] = ()
    plots: Annotated[bool, arg(help="Also draw figures: demonstrated, learned and executed; joints; paths.")] = False
    keep_failed: Annotated[bool, arg(help="Write the plan even if something is wrong with it.")] = False
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import stages
        from sbam.planning.report import plan_report
        from sbam.results import write_results

        roles = pairs("roles", "ROLE=OBJECT", self.roles)
        start = {
            joint: number("start", position) for joint, position in pairs("start", "JOINT=POSITION", self.start).items()
        }
        if not 0.0 < self.speed <= 1.0:
            raise usage_error(f"--speed {self.speed:g} is not above 0 and at most 1")
        if self.seed < 0:
            raise usage_error(f"--seed {self.seed} is negative")
        model = sbam.load_model(self.model)
        scene = sbam.load_scene(self.scene, library_of(self.objects))
        settings = sbam.PlanSettings(
            solver=self.solver,
            human_likeness=self.human_likeness,
            posture=self.posture,
            between=self.between,
            clearance=self.clearance,
            margin=self.margin,
            prune=self.prune,
            terms=self.terms,
            speed=self.speed,
            seed=self.seed,
        )
        with stages("planning") as progress:
            plan = sbam.plan(model, scene, self.robot, settings, roles, start, progress)
            wanted = plan.ok or self.keep_failed
            files = write_results(plan, self.output, self.formats, self.plots, progress=progress) if wanted else []
        return {**plan_report(plan), "files": [str(path) for path in files]}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import plan_lines

        yield from plan_lines(report)
