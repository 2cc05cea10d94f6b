"""The command line: verbs, no logic.

A verb is a file with one dataclass: its fields are the arguments, its docstring is the help, and its methods, those of
`sbam.console.running.Verb`, say whom it asks and how its report is shown. A new verb is one such file and a line here.
"""

from __future__ import annotations

from collections.abc import Sequence

from tyro.conf import FlagCreatePairsOff
from tyro.extras import SubcommandApp

from sbam.cli import recordings, robots, scenes
from sbam.cli.add import Add
from sbam.cli.demo import Demo
from sbam.cli.evaluate import Evaluate
from sbam.cli.learn import Learn
from sbam.cli.plan import Plan
from sbam.cli.reach import Reach
from sbam.cli.show import Show
from sbam.cli.simulate import Simulate
from sbam.console.running import run

DESCRIPTION = "Teach a two-armed robot a task by showing it a few times. `sbam demo` shows all of it."

app = SubcommandApp()
app.command(name="learn")(Learn)
app.command(name="add")(Add)
app.command(name="show")(Show)
app.command(name="plan")(Plan)
app.command(name="reach")(Reach)
app.command(name="simulate")(Simulate)
app.command(name="evaluate")(Evaluate)
app.command(name="demo")(Demo)
app.command(recordings.app, name="recordings", help="List, describe or write recordings.")
app.command(scenes.app, name="scenes", help="List scenes, or write one to start from.")
app.command(robots.app, name="robots", help="List robots, check one, or describe your own.")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code, and leaves with 2 through `SystemExit` for wrong usage."""
    verb = app.cli(prog="sbam", description=DESCRIPTION, args=arguments, config=(FlagCreatePairsOff,))
    return run(verb)
