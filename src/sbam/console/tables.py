"""Reports as text and tables for people."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

Report = dict[str, Any]

SHOWN_CHECKS = ("velocity limits", "acceleration limits", "clearance arm-arm", "clearance arm-object", "torque limits")
"""Checks whose worst value is printed; the report holds all of them."""


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """A table of plain cells; numbers get three significant decimals, None a dash."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    result = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD)
    for column in columns:
        result.add_column(column, overflow="fold", no_wrap=column == columns[0])
    for row in rows:
        result.add_row(*(Text(_cell(value)) for value in row))
    return result


def model_line(report: Report) -> str:
    """One line on what a model is."""
    count = len(report["demonstrations"])
    synthetic = " (synthetic)" if report["synthetic"] else ""
    return (
        f"{report['constraint']} model in mode {report['mode']} from {count} "
        f"demonstration{'s' if count > 1 else ''}{synthetic}: {len(report['roles'])} roles, "
        f"{len(report['pairs'])} pairs, {len(report['keypoints'])} keypoints over {report['duration']:.2f} s"
    )


def model_tables(report: Report) -> Iterator[RenderableType]:
    """All of `sbam.learning.report.model_report`."""
    yield f"{report['name']}: {model_line(report)}"
    yield table(
        "Roles",
        ("role", "affordances", "moves", "demonstrated by"),
        (
            (role["name"], ", ".join(role["affordances"]), role["moves"], ", ".join(role["demonstrated"]))
            for role in report["roles"]
        ),
    )
    yield table(
        "Pairs, the most relevant first",
        ("pair", "constraint", "precision", "at, s", "spread / layouts'", "channels (mean std)"),
        (
            (
                pair["pair"],
                pair["constraint"],
                pair["precision"],
                pair["best_time"],
                f"{pair['spread']:.2f}{' (fixed)' if pair['fixed'] else ''}",
                ", ".join(f"{one['name']} {_with_unit(one['mean_std'], one['unit'])}" for one in pair["channels"]),
            )
            for pair in report["pairs"]
        ),
    )
    yield table(
        "Anchors", ("event", "role", "time, s"), ((one["kind"], one["role"], one["time"]) for one in report["anchors"])
    )
    yield table(
        "Holds",
        ("role", "hand", "grasp, s", "release, s", "seen in demonstrations"),
        (
            (hold["role"], hold["hand"], hold["grasp"], hold["release"], hold["observations"])
            for hold in report["holds"]
        ),
    )
    yield "Keypoints, s: " + " ".join(f"{time:.2f}" for time in report["keypoints"])
    yield from (f"note: {note}" for note in report["notes"])


def recording_list(title: str, summaries: Sequence[Report]) -> Table:
    """One line a recording."""
    return table(
        title,
        ("name", "s", "Hz", "objects", "hands", "synthetic", "notes"),
        (
            (
                one["name"],
                one["duration"],
                round(one["rate"], 1),
                ", ".join(one["objects"]),
                ", ".join(one["hands"]),
                one["synthetic"],
                len(one["notes"]),
            )
            for one in summaries
        ),
    )


def recording_tables(report: Report) -> Iterator[RenderableType]:
    """All of `sbam.demonstrations.report.demonstration_report`."""
    yield recording_list(report["name"], [report])
    if report["unknown_objects"]:
        yield f"not in the object library: {', '.join(report['unknown_objects'])}"
    yield table(
        "Events",
        ("time, s", "event", "object", "strength"),
        ((one["time"], one["kind"], one["object"], one["strength"]) for one in report["events"]),
    )
    yield table(
        "Holds",
        ("hand", "object", "from, s", "to, s", "spread, mm"),
        ((one["hand"], one["object"], one["start"], one["end"], 1000 * one["spread"]) for one in report["holds"]),
    )
    if report["labels"]:
        yield table(
            "Labels",
            ("hand", "from, s", "to, s", "action", "target"),
            ((one["hand"], one["start"], one["end"], one["action"], one["target"]) for one in report["labels"]),
        )
    yield from (f"note: {note}" for note in report["notes"])


def plan_lines(report: Report) -> Iterator[RenderableType]:
    """The gist of `sbam.planning.report.plan_report`, and the files that were written."""
    worst = ", ".join(
        f"{one['name']} {one['worst']:.3g} {one['unit']}" for one in report["checks"] if one["name"] in SHOWN_CHECKS
    )
    yield (
        f"planned {report['model']['name']} in scene {report['scene']['name']} on {report['robot']['name']}: "
        f"{len(report['keypoints'])} keypoints, {report['duration_s']:.1f} s of motion, objective "
        f"{report['objective']:.2f}, planned in {report['seconds']['total']:.2f} s"
    )
    passed = sum(one["ok"] for one in report["checks"])
    yield f"{passed} of {len(report['checks'])} checks passed" + (f": {worst}" if worst else "")
    yield from report["notes"]
    yield from (f"wrote {path}" for path in report.get("files", ()))


def simulation_lines(report: Report) -> Iterator[RenderableType]:
    """The gist of `sbam.simulation.report.simulation_report`."""
    values, yardstick = report["values"], report["yardstick"] or {}
    numbers = [key for key, value in values.items() if isinstance(value, float | int)]
    yield f"{report['action']}: {report['task']} {'succeeds' if report['ok'] else 'fails'} in physics"
    yield table("Measured", ("", "here", "demonstrations"), ((key, values[key], yardstick.get(key)) for key in numbers))
    if report["tracking_error"]:
        error, torque = max(report["tracking_error"].values()), max(report["torque_ratio"].values())
        yield f"largest tracking error {error:.4f} rad, largest torque {torque:.2f} of its limit"
    for key, slip in report["slip_m"].items():
        yield f"slip, {key}: {1e3 * slip:.1f} mm and {report['slip_deg'][key]:.1f} degrees at most"
    yield "; ".join(report["assumptions"])
    yield from (f"note: {warning}" for warning in report["warnings"])
    yield (
        f"{report['simulated_s']:.1f} s of physics in {report['seconds']:.1f} s "
        f"({report['simulated_s'] / report['seconds']:.2f} x real time)"
    )
    yield from (f"wrote {path}" for path in report.get("files", ()))


def sweep_lines(report: Report) -> Iterator[RenderableType]:
    """The table of `sbam.simulation.sweep.sweep`, and what failed."""
    for title, cells in (("Scenes that succeed", report["success"]), ("Random scenes in physics", report["cells"])):
        yield table(title, tuple(cells[0]), (tuple(cell.values()) for cell in cells))
    for row in report["rows"]:
        if not row["ok"]:
            case = f"{row['task']} {row['robot']} {row['constraint']} {row['mode']} scene {row['seed']}"
            yield f"{case}, {row['stage']}: {'; '.join(row['problems'])}"
    yield from (f"wrote {path}" for path in report["files"])


def demo_lines(report: Report) -> Iterator[RenderableType]:
    """What the demo did, and where to look."""
    seconds, plan, model = report["seconds"], report["plan"], report["model"]
    passed = sum(one["ok"] for one in plan["checks"])
    yield f"1. took {len(report['demonstrations'])} synthetic demonstrations of pouring, which come with sbam"
    yield f"2. learned in {seconds['learn']:.2f} s a {model_line(model)}"
    yield (
        f"3. planned the scene {report['scene']!r}, which was not demonstrated, on {plan['robot']['name']} in "
        f"{plan['seconds']['total']:.2f} s: {plan['duration_s']:.1f} s of motion"
    )
    yield f"4. verified the trajectory, sampled at 1 kHz: {passed} of {len(plan['checks'])} checks passed"
    yield f"5. wrote {len(report['files'])} files into {report['folder']}:"
    yield f"   look at  {report['folder']}/recording.html (in a browser) and {report['folder']}/plots/"
    yield f"   use      {report['folder']}/trajectory.csv or .npz, {report['folder']}/model.json"
    yield f"   read     {report['folder']}/report.json (every check and its worst value)"


def evaluation_tables(report: Report) -> Iterator[RenderableType]:
    """Tables of `sbam.evaluation.evaluate.evaluation_report`, and what went wrong in single folds."""
    for one in report["tables"]:
        yield one["caption"]
        grid = table("", one["columns"], one["rows"])
        for index, column in enumerate(grid.columns):
            if any(isinstance(row[index], float) for row in one["rows"]):
                column.justify = "right"
            else:
                column.no_wrap = True
        yield grid
    for fold in report["folds"]:
        where = f"{fold['condition']}, {fold['constraint']}, {fold['test']}"
        yield from (f"{where}: {problem}" for problem in fold["problems"])
    yield f"{len(report['folds'])} folds in {report['seconds']['total']:.1f} s"
    yield from (f"wrote {path}" for path in report.get("files", ()))


def scene_list(scenes: Sequence[Report]) -> Table:
    """All of `sbam.scene.built_in_scenes.scene_summaries`."""
    return table(
        "Scenes",
        ("name", "title", "objects", "robot"),
        ((f"built-in:{one['name']}", one["title"], ", ".join(one["objects"]), one["robot"]) for one in scenes),
    )


def robot_list(robots: Sequence[Report]) -> Table:
    """All of `sbam.robots.report.robot_summaries`."""
    return table(
        "Robots",
        ("name", "arms", "joints", "description"),
        ((one["name"], ", ".join(one["arms"]), len(one["joint_names"]), one["file"]) for one in robots),
    )


def robot_check(report: Report) -> Iterator[RenderableType]:
    """What `sbam.robots.check.check_robot` says."""
    joints = ("arm", "name", "kind", "lower", "upper", "home", "velocity", "acceleration", "torque")
    rows = ([joint[key] for key in joints] for joint in report["joints"])
    yield table(f"{report['name']}: planned joints (rad, s, Nm; slides m, N)", joints, rows)
    fields = ("tcp", "shoulder", "elbow", "wrist", "grip", "max_width", "length", "sampled_reach")
    places = ("shoulder_at_home", "tcp_at_home", "approach_at_home")
    arms = report["arms"]
    rows = [[field, *(arm[field] for arm in arms.values())] for field in fields]
    rows += [[field, *(" ".join(f"{value:.2f}" for value in arm[field]) for arm in arms.values())] for field in places]
    rows.append(["over the table", *(f"{100 * arm['postures_over_table']:.1f} % of postures" for arm in arms.values())])
    yield table("Arms (m; agent frame: x right, y forward, z up from the table top)", ("", *arms), rows)
    if report["locked_joints"]:
        held = ", ".join(f"{name} {value:.3g}" for name, value in report["locked_joints"].items())
        yield f"held still: {held}"
    yield from (f"look at: {warning}" for warning in report["warnings"])
    yield from (f"WRONG: {problem}" for problem in report["problems"])
    if report.get("picture"):
        yield f"drew {report['picture']}"
    elif report.get("no_picture"):
        yield f"no picture: {report['no_picture']}"
    if not report["problems"]:
        yield "nothing is wrong with it"


def _with_unit(value: float, unit: str) -> str:
    return {"m": f"{1000 * value:.1f} mm", "rad": f"{value:.3f} rad", "log": f"{value:.2f} log"}.get(
        unit, f"{value:.3g} {unit}"
    )


def _cell(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.2f}" if isinstance(value, float) else str(value)
