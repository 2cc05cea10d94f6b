"""What came of a sweep: tables, maps of where it works, and all failures with cause and picture."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sbam.batch.table import Cell, Table, write_tables
from sbam.files import write_atomically
from sbam.simulation.trial import Row

LOOKS = {"success": ("tab:green", "o"), "failure in physics": ("tab:red", "X"), "no verified plan": ("tab:gray", "s")}
OFF = "off the planned thickness, 95 % [mm]"


def write_sweep_tables(rows: Sequence[Row], folder: Path) -> tuple[list[Table], list[Path]]:
    """Write both tables as Markdown, CSV and LaTeX; returns tables and files."""
    tables = [success_table(rows), sweep_table(rows)]
    return tables, write_tables(tables, folder)


def success_table(rows: Sequence[Row]) -> Table:
    """Successes of scenes tried, a column for each constraint type."""
    constraints = list(dict.fromkeys(row["constraint"] for row in rows))
    lines: list[tuple[Cell, ...]] = []
    for key, own in _groups(rows, ("task", "robot", "mode")):
        cells = []
        for constraint in constraints:
            oks = [row["ok"] for row in own if row["constraint"] == constraint]
            cells.append(f"{sum(oks)} of {len(oks)} ({100 * sum(oks) / len(oks):.0f} %)" if oks else None)
        lines.append((*key, *cells))
    caption = "Random scenes that succeed: the plan passes every check, and physics agrees. " + _versions(rows)
    return Table("success", caption.strip(), ("task", "robot", "mode", *constraints), tuple(lines))


def sweep_table(rows: Sequence[Row]) -> Table:
    """Counts and numbers of every condition."""
    lines: list[tuple[Cell, ...]] = []
    for key, own in _groups(rows, ("task", "robot", "constraint", "mode")):
        tried = [row for row in own if row["succeeds"] is not None]
        lines.append(
            (
                *key,
                str(len(own)),
                str(sum(row["verified"] for row in own)),
                str(sum(bool(row["succeeds"]) for row in own)),
                str(sum(row["ok"] for row in own)),
                _mean(tried, "poured", 100.0),
                _mean(tried, "spilled", 100.0),
                _mean(tried, OFF, 1.0),
                max((row["torque_ratio"] for row in tried), default=None),
                _median(own, "planning_s"),
                _median(own, "physics_s"),
            )
        )
    columns = (
        *("task", "robot", "constraint", "mode", "scenes", "verified plans", "right in physics", "both"),
        *("poured %", "spilled %", "off mm", "largest torque / limit", "planning s", "physics s"),
    )
    caption = (
        "Random scenes in physics, plans that failed a check included. Poured and spilled: % of the content; off: mm "
        "off the planned thickness (95 %); means over the scenes tried; seconds: medians. " + _versions(rows)
    )
    return Table("physics", caption.strip(), columns, tuple(lines))


def write_failures(rows: Sequence[Row], folder: Path) -> Path:
    """Write `failures.md`: every trial that did not succeed, why, and the picture of its failing moment."""
    failed = [row for row in rows if not row["ok"]]
    lines = [f"# {len(failed)} of {len(rows)} trials failed\n"]
    for row in failed:
        where = "physics" if row["verified"] else "planning"
        lines.append(
            f"## {row['task']}, {row['robot']}, {row['constraint']}, {row['mode']}, scene {row['seed']}: {where}\n"
        )
        lines += [f"- {problem}" for problem in row["problems"]]
        if "picture" in row:
            lines.append(f"\n![before, at and after the failing moment]({row['picture']})")
        lines.append("")
    path = folder / "failures.md"
    write_atomically(path, "\n".join(lines))
    return path


def write_maps(rows: Sequence[Row], folder: Path) -> list[Path]:
    """Where the moved objects stood, by what came of it: a picture for each task and mode."""
    files = []
    for (task, mode), own in _groups(rows, ("task", "mode")):
        files.append(folder / f"map_{task}_{mode}.png")
        write_atomically(files[-1], _map(own, f"{task}, {mode}"))
    return files


def _map(rows: Sequence[Row], title: str) -> bytes:
    """A panel for each robot and constraint type; a line leads from the first object of a scene to the last."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    robots = list(dict.fromkeys(row["robot"] for row in rows))
    constraints = list(dict.fromkeys(row["constraint"] for row in rows))
    names = list(rows[0]["places"])
    spots = np.array([list(row["places"].values()) for row in rows]).reshape(-1, 2)
    low, high = spots.min(axis=0) - 0.05, spots.max(axis=0) + 0.05
    width = 3.2
    height = width * float(np.clip((high - low)[1] / (high - low)[0], 0.4, 1.5)) + 0.4
    size = (width * len(constraints) + 0.8, height * len(robots) + 1.2)
    figure = Figure(figsize=size, dpi=100, layout="constrained")
    grid = figure.subplots(len(robots), len(constraints), squeeze=False, sharex=True, sharey=True)
    for axes, robot in zip(grid, robots, strict=True):
        for panel, constraint in zip(axes, constraints, strict=True):
            own = [row for row in rows if row["robot"] == robot and row["constraint"] == constraint]
            for row in own:
                color, marker = LOOKS[_outcome(row)]
                places = np.array([row["places"][name] for name in names])
                panel.plot(places[:, 0], places[:, 1], color=color, linewidth=0.8, alpha=0.5)
                panel.plot(*places[-1], color=color, marker=marker, markersize=6, alpha=0.8)
            panel.set_title(f"{robot}, {constraint}: {sum(row['ok'] for row in own)} of {len(own)}", fontsize=9)
            panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes[0].set_ylabel("before the agent, m", fontsize=9)
    for panel in grid[-1]:
        panel.set_xlabel("to the agent's right, m", fontsize=9)
    to = f" (a line leads to it from {names[0]})" if len(names) > 1 else ""
    figure.suptitle(f"{title}: where {names[-1]} stood{to}", fontsize=10)
    marks = [Line2D([], [], color=c, marker=m, linestyle="", label=label) for label, (c, m) in LOOKS.items()]
    figure.legend(handles=marks, loc="outside lower center", ncols=3, fontsize=8)
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()


def _outcome(row: Row) -> str:
    return "success" if row["ok"] else "failure in physics" if row["verified"] else "no verified plan"


def _groups(rows: Sequence[Row], names: Sequence[str]) -> list[tuple[tuple[str, ...], list[Row]]]:
    """Rows by the values of some fields, in order of appearance."""
    keys = [tuple(str(row[name]) for name in names) for row in rows]
    return [(key, [row for row, k in zip(rows, keys, strict=True) if k == key]) for key in dict.fromkeys(keys)]


def _mean(rows: Sequence[Row], key: str, factor: float) -> float | None:
    found = [row["values"][key] for row in rows if key in row["values"]]
    return factor * float(np.mean(found)) if found else None


def _median(rows: Sequence[Row], key: str) -> float | None:
    found = [row[key] for row in rows if key in row]
    return float(np.median(found)) if found else None


def _versions(rows: Sequence[Row]) -> str:
    count = len({row.get("version") for row in rows})
    return f"Trials of {count} versions of the code." if count > 1 else ""
