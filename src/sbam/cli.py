"""The command line: verbs, no logic. Each verb says what it takes, whom it asks and how its report is shown."""

# A verb's docstring is its help; its methods are those of `sbam.console.running.Verb`.
# ruff: noqa: D102

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import FlagCreatePairsOff, Positional, arg
from tyro.extras import SubcommandApp

from sbam.console.running import Report, run, usage_error

if TYPE_CHECKING:
    from rich.console import RenderableType

    from sbam.scene.object_library import ObjectLibrary

DESCRIPTION = "Teach a two-armed robot a task by showing it a few times. `sbam demo` shows all of it."

app = SubcommandApp()
recordings = SubcommandApp()
scenes = SubcommandApp()
robots = SubcommandApp()

Constraints = Literal["cartesian", "cylindrical", "symbolic"]
Mode = Literal["default", "paper"]
Format = Literal["npz", "csv", "ros"]
Recordings = Annotated[
    tuple[str, ...],
    arg(
        metavar="RECORDING...",
        help="Files, folders of files, or built-in:pouring, built-in:rolling.",
        help_behavior_hint="",
    ),
]
Scene = Annotated[
    str, arg(metavar="SCENE|RECORDING", help="A scene file, built-in:NAME, or a recording, of which the first frame.")
]
ModelFile = Annotated[Path, arg(metavar="MODEL", help="A model file.")]
Objects = Annotated[Path | None, arg(metavar="FOLDER", help="Folder with object files of your own.")]


@dataclass(frozen=True, kw_only=True)
class _Verb:
    json: Annotated[str | None, arg(metavar="FILE", help="Write the report as JSON; - for standard output.")] = None


@dataclass(frozen=True, kw_only=True)
class _RecordingsVerb(_Verb):
    recordings: Positional[Recordings]

    def __post_init__(self) -> None:
        if not self.recordings:
            raise usage_error("give one or more recordings: files, folders, or built-in:pouring, built-in:rolling")


@app.command(name="learn")
@dataclass(frozen=True, kw_only=True)
class Learn(_RecordingsVerb):
    """Learn a model from recordings of a person doing one task."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="MODEL", help="Where to write the model.")]
    constraints: Annotated[Constraints, arg(help="How the vector between two regions is seen.")] = "cartesian"
    mode: Annotated[Mode, arg(help="The best we know, or the paper's way with its faults.")] = "default"
    name: Annotated[str | None, arg(metavar="NAME", help="Name of the action; default: that of the file.")] = None
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.learning.report import model_report

        library = _library(self.objects)
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


@app.command(name="add")
@dataclass(frozen=True, kw_only=True)
class Add(_Verb):
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

        library = _library(self.objects)
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


@app.command(name="show")
@dataclass(frozen=True, kw_only=True)
class Show(_Verb):
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


@app.command(name="plan")
@dataclass(frozen=True, kw_only=True)
class Plan(_Verb):
    """Plan a learned action for a robot in a scene and write the trajectory."""

    model: Positional[ModelFile]
    scene: Scene
    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for what is written.")]
    robot: Annotated[
        str | None, arg(metavar="ROBOT", help="Name or file of a robot; default: the scene's, else panda_dual.")
    ] = None
    solver: Annotated[Mode, arg(help="The fast one, or the paper's (minutes).")] = "default"
    roles: Annotated[
        tuple[str, ...],
        arg(
            metavar="ROLE=OBJECT...",
            help="Which object plays which role, where it is not clear.",
            help_behavior_hint="",
        ),
    ] = ()
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
    clearance: Annotated[float, arg(help="Distance to keep from what is not touched on purpose, m.")] = 0.0
    speed: Annotated[float, arg(help="Share of the robot's velocity limits, above 0 to 1.")] = 0.5
    seed: Annotated[int, arg(help="Seed of the random starts.")] = 0
    formats: Annotated[tuple[Format, ...], arg(help="Formats of the trajectory.")] = ("npz", "csv")
    plots: Annotated[bool, arg(help="Also draw figures: demonstrated, learned and executed; joints; paths.")] = False
    keep_failed: Annotated[bool, arg(help="Write the plan even if something is wrong with it.")] = False
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import stages
        from sbam.planning.report import plan_report
        from sbam.results import write_results

        roles = _pairs("roles", "ROLE=OBJECT", self.roles)
        start = {
            joint: _number("start", position)
            for joint, position in _pairs("start", "JOINT=POSITION", self.start).items()
        }
        if not 0.0 < self.speed <= 1.0:
            raise usage_error(f"--speed {self.speed:g} is not above 0 and at most 1")
        if self.seed < 0:
            raise usage_error(f"--seed {self.seed} is negative")
        model = sbam.load_model(self.model)
        scene = sbam.load_scene(self.scene, _library(self.objects))
        settings = sbam.PlanSettings(
            solver=self.solver,
            human_likeness=self.human_likeness,
            clearance=self.clearance,
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


@app.command(name="simulate")
@dataclass(frozen=True, kw_only=True)
class Simulate(_Verb):
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
        library = _library(self.objects)
        with seconds("simulating") as progress:
            return simulate_folder(self.plan, self.task, self.demonstrations, self.video, library, progress)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import simulation_lines, sweep_lines

        yield from sweep_lines(report) if self.sweep else simulation_lines(report)


@recordings.command(name="list")
@dataclass(frozen=True, kw_only=True)
class RecordingsList(_Verb):
    """List the built-in recordings, or those in a folder."""

    folder: Positional[Annotated[Path | None, arg(metavar="FOLDER", help="Where to look.")]] = None

    def __call__(self) -> Report:
        from sbam.demonstrations.report import list_recordings

        return list_recordings(self.folder)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import recording_list

        yield recording_list(report["where"], report["recordings"])
        yield from (f"cannot be used: {problem}" for problem in report["unusable"])


@recordings.command(name="info")
@dataclass(frozen=True, kw_only=True)
class RecordingsInfo(_RecordingsVerb):
    """Say what is in recordings: objects, hands, events, holds, repairs, labels."""

    objects: Objects = None

    def __call__(self) -> Report:
        import sbam
        from sbam.demonstrations.report import demonstration_report

        library = _library(self.objects)
        return {"recordings": [demonstration_report(one, library) for one in sbam.load(self.recordings)]}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import recording_tables

        for one in report["recordings"]:
            yield from recording_tables(one)


@recordings.command(name="write")
@dataclass(frozen=True, kw_only=True)
class RecordingsWrite(_RecordingsVerb):
    """Write recordings into a folder, also in another format."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for the files.")]
    format: Annotated[Literal["mmm", "npz", "csv"], arg(help="MMM 2.0, our own NPZ, or KIT CSV.")] = "mmm"

    def __call__(self) -> Report:
        import sbam
        from sbam.console.progress import counting
        from sbam.demonstrations.writers import write_demonstrations

        with counting("writing") as progress:
            files = write_demonstrations(sbam.load(self.recordings), self.output, self.format, progress)
        return {"files": [str(path) for path in files]}

    def show(self, report: Report) -> Iterable[RenderableType]:
        yield from (f"wrote {path}" for path in report["files"])


@scenes.command(name="list")
@dataclass(frozen=True, kw_only=True)
class ScenesList(_Verb):
    """List the built-in scenes."""

    def __call__(self) -> Report:
        from sbam.scene.built_in_scenes import scene_summaries

        return {"scenes": scene_summaries()}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import scene_list

        yield scene_list(report["scenes"])


@scenes.command(name="write")
@dataclass(frozen=True, kw_only=True)
class ScenesWrite(_Verb):
    """Write a built-in scene, or the first frame of a recording, as a scene file to start from."""

    scene: Positional[Scene]
    output: Annotated[Path, arg(aliases=["-o"], metavar="FILE", help="The scene file (YAML).")]
    objects: Objects = None

    def __call__(self) -> Report:
        import sbam

        scene = sbam.load_scene(self.scene, _library(self.objects))
        sbam.save_scene(scene, self.output)
        return {"file": str(self.output), "name": scene.name, "objects": list(scene.objects)}

    def show(self, report: Report) -> Iterable[RenderableType]:
        yield f"wrote {report['file']}: {', '.join(report['objects'])}"


@robots.command(name="list")
@dataclass(frozen=True, kw_only=True)
class RobotsList(_Verb):
    """List the built-in robots."""

    def __call__(self) -> Report:
        from sbam.robots.report import robot_summaries

        return {"robots": robot_summaries()}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import robot_list

        yield robot_list(report["robots"])


@robots.command(name="check")
@dataclass(frozen=True, kw_only=True)
class RobotsCheck(_Verb):
    """Load a robot and say what is there, what is missing and what looks wrong; draw it."""

    robot: Positional[Annotated[str, arg(metavar="ROBOT", help="Name or description file of a robot.")]]
    picture: Annotated[Path | None, arg(metavar="FILE", help="Also draw it, at home, into this PNG file.")] = None

    def __call__(self) -> Report:
        import sbam
        from sbam.errors import RenderingError
        from sbam.robots.check import check_robot

        robot = sbam.load_robot(self.robot)
        report = {**check_robot(robot), "picture": None}
        report["ok"] = not report["problems"]
        if self.picture:
            from sbam.viewer.robot_picture import draw_robot

            try:
                report["drawn_with_meshes"] = draw_robot(robot, self.picture)
                report["picture"] = str(self.picture)
            except RenderingError as error:
                report["no_picture"] = str(error)
        return report

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import robot_check

        yield from robot_check(report)


@robots.command(name="new")
@dataclass(frozen=True, kw_only=True)
class RobotsNew(_Verb):
    """Write a commented description for a robot of your own, guessed from its model file."""

    model: Positional[
        Annotated[str, arg(metavar="MODEL", help="URDF or MJCF file, or the name of a robot_descriptions model.")]
    ]
    output: Annotated[Path, arg(aliases=["-o"], metavar="FILE", help="The description (YAML).")]
    name: Annotated[str | None, arg(metavar="NAME", help="Name of the robot; default: that of the file.")] = None

    def __call__(self) -> Report:
        from sbam.robots.new_description import new_description

        description, notes = new_description(self.model, self.output, self.name)
        return {"file": str(self.output), "name": description.name, "notes": notes}

    def show(self, report: Report) -> Iterable[RenderableType]:
        yield f"wrote {report['file']}; look at it, then: sbam robots check {report['file']} --picture robot.png"
        yield from (f"guessed: {note}" for note in report["notes"])


@app.command(name="evaluate")
@dataclass(frozen=True, kw_only=True)
class Evaluate(_Verb):
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
    robot: Annotated[
        str, arg(metavar="ROBOT", help="Name or file of a robot; flying_hands for none: quick, without its limits.")
    ] = "panda_dual"
    constraints: Annotated[tuple[Constraints, ...], arg(help="Types to compare.")] = (
        "cartesian",
        "cylindrical",
        "symbolic",
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
                robot=self.robot,
                constraints=self.constraints,
                modes=self.mode,
                solvers=self.solver,
                prune=self.prune,
                seed=self.seed,
                library=_library(self.objects),
                jobs=self.jobs,
                cache=None if self.fresh else self.cache or default_cache(),
                cluster=self.cluster,
                progress=progress,
            )

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import evaluation_tables

        yield from evaluation_tables(report)


@app.command(name="demo")
@dataclass(frozen=True, kw_only=True)
class Demo(_Verb):
    """Learn the built-in pouring demonstrations, plan a new scene on two Pandas, write everything there is to see."""

    output: Annotated[Path, arg(aliases=["-o"], metavar="DIR", help="Folder for what is written.")] = Path("out/demo")
    constraints: Annotated[Constraints, arg(help="How the vector between two regions is seen.")] = "cartesian"

    def __call__(self) -> Report:
        from sbam.console.progress import stages
        from sbam.demo import run_demo

        with stages("demo") as progress:
            return run_demo(self.output, self.constraints, progress)

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import demo_lines

        yield from demo_lines(report)


app.command(recordings, name="recordings", help="List, describe or write recordings.")
app.command(scenes, name="scenes", help="List scenes, or write one to start from.")
app.command(robots, name="robots", help="List robots, check one, or describe your own.")


def _library(folder: Path | None) -> ObjectLibrary:
    from sbam.scene.object_library import ObjectLibrary

    return ObjectLibrary.built_in().with_folder(folder) if folder else ObjectLibrary.built_in()


def _pairs(option: str, form: str, texts: Sequence[str]) -> dict[str, str]:
    pairs = [text.partition("=") for text in texts]
    for text, (name, equals, value) in zip(texts, pairs, strict=True):
        if not (name and equals and value):
            raise usage_error(f"--{option} {text!r} is not of the form {form}")
    return {name: value for name, _, value in pairs}


def _number(option: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise usage_error(f"--{option}: {text!r} is not a number") from None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code, and leaves with 2 through `SystemExit` for wrong usage."""
    verb = app.cli(prog="sbam", description=DESCRIPTION, args=arguments, config=(FlagCreatePairsOff,))
    return run(verb)


if __name__ == "__main__":
    sys.exit(main())
