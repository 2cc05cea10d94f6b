"""Tables of an evaluation: the paper's tables with its numbers beside ours, other measures, and paired comparisons."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sbam.batch.table import Cell, Table
from sbam.evaluation.comparison import (
    PAIR_MEASURES,
    comparison_table,
    conditions,
    data_of,
    of_condition,
    pairs_table,
    verdict_table,
)
from sbam.evaluation.fold import FoldResult
from sbam.evaluation.paper_numbers import PAPER_DATA, PAPER_OBJECTS, PAPER_TABLES, paper_row

ALL_PAIRS = "all pairs"


def evaluation_tables(results: Sequence[FoldResult]) -> list[Table]:
    """All tables of an evaluation.

    Args:
        results: of one or more conditions on the same folds.
    """
    tables = [similarity_table(of_condition(results, name)) for name in conditions(results)]
    tables.append(measures_table(results))
    if len(conditions(results)) > 1:
        tables += [pairs_table(results, measure) for measure in PAIR_MEASURES]
        tables += [comparison_table(results), verdict_table(results)]
    return tables


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
    columns = ("pair", "type", "paper avg", "std", "min", "ours avg", "std", "min", "tempo", "events avg")
    columns = (*columns, "std", "rel.", "dense")
    return Table(f"similarity {results[0].condition}", _similarity_caption(results), columns, tuple(rows))


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
                f"processor time to {stage} [s]",
                *(_mean([r.seconds[stage] for r in g if stage in r.seconds]) for g in groups.values()),
            )
        )
    rows.append(("keypoints", *(_mean([float(r.keypoints) for r in group]) for group in groups.values())))
    rows.append(("executed [share]", *(_mean([float(r.executed) for r in group]) for group in groups.values())))
    rows.append(("without problems [share]", *(_mean([float(not r.problems) for r in g]) for g in groups.values())))
    caption = f"Other measures, means over folds; {data_of(results)}. Time is aligned by events."
    return Table("measures", caption, ("measure", *(f"{c}, {t}" for c, t in groups)), tuple(rows))


def _statistics(pairs: Sequence) -> tuple[float, ...]:
    """Average, std, min of the paper's measure; tempo; average, std by events; mean by relevance; dense mean."""
    seconds = np.concatenate([pair.seconds for pair in pairs])
    events = np.concatenate([pair.events for pair in pairs])
    tempo, relevant, dense = np.mean([(pair.tempo, pair.relevant, pair.dense) for pair in pairs], axis=0)
    numbers = (seconds.mean(), seconds.std(), seconds.min(), tempo, events.mean(), events.std(), relevant, dense)
    return tuple(map(float, numbers))


def _similarity_caption(results: Sequence[FoldResult]) -> str:
    return (
        f"Distance between demonstrated and executed vectors of region pairs over all keypoints of all folds, mm; "
        f"{results[0].condition}. 'paper': its own numbers, on {PAPER_DATA}. 'ours': {data_of(results)}, the person "
        "looked at in the same second; 'tempo': what the person's own tempo alone makes of that; 'events': with time "
        "aligned by events; 'rel.': that, weighted by how much the demonstrations agree; 'dense': the whole motion by "
        "events."
    )


def _groups(results: Sequence[FoldResult]) -> dict[tuple[str, str], list[FoldResult]]:
    groups: dict[tuple[str, str], list[FoldResult]] = {}
    for result in results:
        groups.setdefault((result.condition, result.constraint), []).append(result)
    return groups


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None
