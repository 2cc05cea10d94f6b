"""Tables of an evaluation: the paper's tables with its numbers beside ours, other measures, and paired comparisons."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sbam.evaluation.fold import FoldResult
from sbam.evaluation.paper_numbers import PAPER_DATA, PAPER_OBJECTS, PAPER_TABLES, paper_row

Array = NDArray[np.float64]
Cell = str | float | None

RESAMPLES = 2000
CONFIDENCE = 0.95
ALL_PAIRS = "all pairs"


@dataclass(frozen=True)
class Table:
    """A table of text and numbers.

    Attributes:
        name: short name, for files.
        caption: what the numbers are, and what data they are on.
        columns: headings.
        rows: cells; None where there is no number.
    """

    name: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def markdown(self) -> str:
        """As a Markdown table below its caption."""
        right = [any(isinstance(row[i], float) for row in self.rows) for i in range(len(self.columns))]
        lines = [self.columns, tuple("---:" if one else "---" for one in right), *self._texts()]
        return f"{self.caption}\n\n" + "".join(f"| {' | '.join(line)} |\n" for line in lines)

    def csv(self) -> str:
        """As comma-separated values with full precision, the caption in a comment line."""
        text = io.StringIO()
        text.write(f"# {self.caption}\n")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([["" if cell is None else cell for cell in row] for row in self.rows])
        return text.getvalue()

    def latex(self) -> str:
        """As a LaTeX table (package booktabs)."""
        layout = "".join("r" if any(isinstance(row[i], float) for row in self.rows) else "l" for i in self._indices())
        lines = [" & ".join(map(_escaped, line)) + r" \\" for line in (self.columns, *self._texts())]
        body = "\n".join([r"\toprule", lines[0], r"\midrule", *lines[1:], r"\bottomrule"])
        return (
            f"\\begin{{table}}\n\\caption{{{_escaped(self.caption)}}}\n\\centering\n"
            f"\\begin{{tabular}}{{{layout}}}\n{body}\n\\end{{tabular}}\n\\end{{table}}\n"
        )

    def _indices(self) -> range:
        return range(len(self.columns))

    def _texts(self) -> list[tuple[str, ...]]:
        return [tuple(cell_text(cell) for cell in row) for row in self.rows]


def cell_text(cell: Cell) -> str:
    """A cell as people read it: numbers with one decimal, those below ten with two."""
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    return f"{cell:.1f}" if abs(cell) >= 10 else f"{cell:.2f}"


def evaluation_tables(results: Sequence[FoldResult]) -> list[Table]:
    """All tables of an evaluation.

    Args:
        results: of one or more conditions on the same folds.
    """
    tables = [similarity_table(of_condition(results, name)) for name in conditions(results)]
    tables.append(measures_table(results))
    if len(conditions(results)) > 1:
        tables.append(comparison_table(results))
    return tables


def conditions(results: Sequence[FoldResult]) -> list[str]:
    """Names of the conditions, in order of appearance."""
    return list(dict.fromkeys(result.condition for result in results))


def of_condition(results: Sequence[FoldResult], condition: str) -> list[FoldResult]:
    """Results of one condition."""
    return [result for result in results if result.condition == condition]


def similarity_table(results: Sequence[FoldResult]) -> Table:
    """The paper's Table II or III: distances per pair and type over all keypoints of all folds, mm.

    Args:
        results: of one condition, for one or more constraint types.
    """
    rows: list[tuple[Cell, ...]] = []
    types = list(dict.fromkeys(result.constraint for result in results))
    executed = [result for result in results if result.executed]
    of_paper = {name for result in executed for name in result.objects} <= PAPER_OBJECTS
    for pair in dict.fromkeys(pair.pair for result in executed for pair in result.pairs):
        known = paper_row(pair) if of_paper else None
        label = " - ".join(known[1]) if known else pair
        for constraint in types:
            mine = [p for r in executed if r.constraint == constraint for p in r.pairs if p.pair == pair]
            if mine:
                paper = PAPER_TABLES[known[0]][known[1]].get(constraint) if known else None
                rows.append((label, constraint, *(paper or (None,) * 3), *_statistics(mine)))
    for constraint in types:
        mine = [p for r in executed if r.constraint == constraint for p in r.pairs]
        paper = [
            PAPER_TABLES[known[0]][known[1]][constraint][0]
            for pair in dict.fromkeys(p.pair for p in mine)
            if of_paper and (known := paper_row(pair)) and constraint in PAPER_TABLES[known[0]][known[1]]
        ]
        if mine:
            mean = float(np.mean(paper)) if paper else None
            rows.append((ALL_PAIRS, constraint, mean, None, None, *_statistics(mine)))
    columns = ("pair", "type", "paper avg", "std", "min", "ours avg", "std", "min", "events avg", "std", "rel.")
    return Table(f"similarity {results[0].condition}", _similarity_caption(results), (*columns, "dense"), tuple(rows))


def measures_table(results: Sequence[FoldResult]) -> Table:
    """Mean of every other measure over the folds, a column for every condition and type."""
    groups = _groups(results)
    names = list(dict.fromkeys(name for result in results for name in result.values))
    rows: list[tuple[Cell, ...]] = [
        (name, *(_mean([r.values[name] for r in group if name in r.values]) for group in groups.values()))
        for name in names
    ]
    for stage in dict.fromkeys(stage for result in results for stage in result.seconds):
        rows.append(
            (
                f"time to {stage} [s]",
                *(_mean([r.seconds[stage] for r in g if stage in r.seconds]) for g in groups.values()),
            )
        )
    rows.append(("keypoints", *(_mean([float(r.keypoints) for r in group]) for group in groups.values())))
    rows.append(("executed [share]", *(_mean([float(r.executed) for r in group]) for group in groups.values())))
    rows.append(("without problems [share]", *(_mean([float(not r.problems) for r in g]) for g in groups.values())))
    caption = f"Other measures, means over folds; {_data(results)}. Time is aligned by events."
    return Table("measures", caption, ("measure", *(f"{c}, {t}" for c, t in groups)), tuple(rows))


def comparison_table(results: Sequence[FoldResult], seed: int = 0) -> Table:
    """Conditions against the first one: mean difference over the folds with a bootstrap interval.

    Only folds that both conditions executed are compared.

    Args:
        results: of two or more conditions on the same folds.
        seed: of the bootstrap.
    """
    names = conditions(results)
    rows: list[tuple[Cell, ...]] = []
    for constraint in dict.fromkeys(result.constraint for result in results):
        base = {r.test: r for r in of_condition(results, names[0]) if r.constraint == constraint and r.executed}
        for name in names[1:]:
            other = {r.test: r for r in of_condition(results, name) if r.constraint == constraint and r.executed}
            tests = [test for test in base if test in other]
            for measure, value in _COMPARED.items():
                both = [(value(other[test]), value(base[test])) for test in tests]
                differences = np.array([a - b for a, b in both if a is not None and b is not None])
                if len(differences):
                    low, high = bootstrap_interval(differences, seed)
                    rows.append((measure, constraint, name, float(differences.mean()), low, high, len(differences)))
    caption = (
        f"Difference from {names[0]!r}, paired over folds, with the {100 * CONFIDENCE:.0f} % bootstrap interval of the "
        f"mean ({RESAMPLES} resamples, seed {seed}); {_data(results)}"
    )
    columns = ("measure", "type", "condition", "difference", "from", "to", "folds")
    return Table("comparison", caption, columns, tuple(tuple(map(_number, row)) for row in rows))


def bootstrap_interval(values: Array, seed: int = 0) -> tuple[float, float]:
    """Percentile bootstrap interval of the mean of values (N,); of a single value, itself twice."""
    if len(values) < 2:
        return float(values[0]), float(values[0])
    from scipy.stats import bootstrap

    interval = bootstrap(
        (values,),
        np.mean,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return float(interval.low), float(interval.high)


def mean_distance(result: FoldResult, kind: str = "events") -> float:
    """Mean over the pairs of their mean distance over the keypoints, mm; kind ``events`` or ``seconds``."""
    return float(np.mean([np.mean(getattr(pair, kind)) for pair in result.pairs]))


def relevant_distance(result: FoldResult) -> float:
    """Mean over the pairs of their distance weighted by relevance, mm."""
    return float(np.mean([pair.relevant for pair in result.pairs]))


_COMPARED = {
    "all pairs, same second [mm]": lambda result: mean_distance(result, "seconds"),
    "all pairs, by events [mm]": mean_distance,
    "all pairs, by relevance [mm]": relevant_distance,
    **{
        name: lambda result, name=name: result.values.get(name)
        for name in (
            "mouth - rim while pouring [mm]",
            "pour_from: tilt error, rms [deg]",
            "poured over the cup [share]",
            "half-strokes",
            "turning points off by [mm]",
            "strokes' amplitude / person's",
        )
    },
}


def _statistics(pairs: Sequence) -> tuple[float, ...]:
    """Average, std, min of the paper's measure; average, std by events; mean by relevance; dense mean."""
    seconds = np.concatenate([pair.seconds for pair in pairs])
    events = np.concatenate([pair.events for pair in pairs])
    relevant, dense = np.mean([pair.relevant for pair in pairs]), np.mean([pair.dense for pair in pairs])
    numbers = (seconds.mean(), seconds.std(), seconds.min(), events.mean(), events.std(), relevant, dense)
    return tuple(map(float, numbers))


def _similarity_caption(results: Sequence[FoldResult]) -> str:
    return (
        f"Distance between demonstrated and executed vectors of region pairs over all keypoints of all folds, mm; "
        f"{results[0].condition}. 'paper': its own numbers, on {PAPER_DATA}. 'ours': {_data(results)}, the person "
        "looked at in the same second; 'events': with time aligned by events; 'rel.': that, weighted by how much "
        "the demonstrations agree; 'dense': the whole motion by events."
    )


def _data(results: Sequence[FoldResult]) -> str:
    """What data results are on: real and synthetic are never mixed in one evaluation."""
    folds = len({result.test for result in results})
    robots = ", ".join(dict.fromkeys(result.robot for result in results))
    tested = "synthetic" if results[0].synthetic else "real"
    trained = "synthetic" if results[0].synthetic_training else "real"
    return f"{folds} fold{'s' if folds > 1 else ''}, learned from {trained}, tested on {tested} recordings, on {robots}"


def _groups(results: Sequence[FoldResult]) -> dict[tuple[str, str], list[FoldResult]]:
    groups: dict[tuple[str, str], list[FoldResult]] = {}
    for result in results:
        groups.setdefault((result.condition, result.constraint), []).append(result)
    return groups


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _number(cell: Cell) -> Cell:
    return float(cell) if isinstance(cell, int) else cell


def _escaped(text: str) -> str:
    for character in "\\&%$#_{}":
        text = text.replace(character, r"\textbackslash " if character == "\\" else f"\\{character}")
    return text
