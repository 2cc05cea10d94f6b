"""`sbam robots`: list robots, check one, or describe your own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg
from tyro.extras import SubcommandApp

from sbam.cli.options import VerbOptions
from sbam.console.running import Report

if TYPE_CHECKING:
    from rich.console import RenderableType

app = SubcommandApp()


@app.command(name="list")
@dataclass(frozen=True, kw_only=True)
class RobotsList(VerbOptions):
    """List the built-in robots."""

    def __call__(self) -> Report:
        from sbam.robots.report import robot_summaries

        return {"robots": robot_summaries()}

    def show(self, report: Report) -> Iterable[RenderableType]:
        from sbam.console.tables import robot_list

        yield robot_list(report["robots"])


@app.command(name="check")
@dataclass(frozen=True, kw_only=True)
class RobotsCheck(VerbOptions):
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


@app.command(name="new")
@dataclass(frozen=True, kw_only=True)
class RobotsNew(VerbOptions):
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
