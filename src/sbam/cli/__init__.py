"""The command line: verbs, no logic.

A verb is a file with one dataclass: its fields are the arguments, its docstring is the help, and its methods, those of
`sbam.console.running.Verb`, say whom it asks and how its report is shown. A new verb is one such file and a line here.
"""

from __future__ import annotations

from collections.abc import Sequence

from tyro.conf import FlagCreatePairsOff
from tyro.extras import SubcommandApp

from sbam.cli import recordings, robots, scenes
from sbam.cli.add import AddVerb
from sbam.cli.demo import DemoVerb
from sbam.cli.evaluate import EvaluateVerb
from sbam.cli.learn import LearnVerb
from sbam.cli.plan import PlanVerb
from sbam.cli.reach import ReachVerb
from sbam.cli.show import ShowVerb
from sbam.cli.simulate import SimulateVerb
from sbam.console.running import run

DESCRIPTION = "Teach a two-armed robot a task by showing it a few times. `sbam demo` shows all of it."

app = SubcommandApp()
app.command(name="learn")(LearnVerb)
app.command(name="add")(AddVerb)
app.command(name="show")(ShowVerb)
app.command(name="plan")(PlanVerb)
app.command(name="reach")(ReachVerb)
app.command(name="simulate")(SimulateVerb)
app.command(name="evaluate")(EvaluateVerb)
app.command(name="demo")(DemoVerb)
app.command(recordings.app, name="recordings", help="List, describe or write recordings.")
app.command(scenes.app, name="scenes", help="List scenes, or write one to start from.")
app.command(robots.app, name="robots", help="List robots, check one, or describe your own.")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code, and leaves with 2 through `SystemExit` for wrong usage."""
    verb = app.cli(prog="sbam", description=DESCRIPTION, args=arguments, config=(FlagCreatePairsOff,))
    return run(verb)
