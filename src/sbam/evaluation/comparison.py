"""Conditions compared fold by fold: mean differences with bootstrap intervals, and what they come to."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float

from sbam.batch.table import Cell, Table
from sbam.evaluation.fold import FoldResult
from sbam.evaluation.metrics import PERSON, PairDistances

Measure = Callable[[FoldResult], float | None]

RESAMPLES = 2000
CONFIDENCE = 0.95

PAIR_MEASURES: dict[str, Callable[[PairDistances], float]] = {
    "same second": lambda pair: float(np.mean(pair.seconds)),
    "by events": lambda pair: float(np.mean(pair.events)),
    "relevant": lambda pair: pair.relevant,
    "dense": lambda pair: pair.dense,
}
"""Ways to look at one pair in one fold, mm; the first is the paper's."""


def conditions(results: Sequence[FoldResult]) -> list[str]:
    """Names of the conditions, in order of appearance."""
    return list(dict.fromkeys(result.condition for result in results))


def of_condition(results: Sequence[FoldResult], condition: str) -> list[FoldResult]:
    """Results of one condition."""
    return [result for result in results if result.condition == condition]


def all_pairs(measure: str) -> Callable[[FoldResult], float]:
    """Mean over the pairs of one of `PAIR_MEASURES`, mm."""
    return lambda result: float(np.mean([PAIR_MEASURES[measure](pair) for pair in result.pairs]))


def comparison_table(results: Sequence[FoldResult], seed: int = 0) -> Table:
    """Conditions against the first one in every measure, over all pairs together.

    Args:
        results: of two or more conditions on the same folds.
        seed: of the bootstrap.
    """
    measures: dict[str, Measure] = {f"all pairs, {name} [mm]": all_pairs(name) for name in PAIR_MEASURES}
    for name in dict.fromkeys(name for result in results for name in result.values if not name.endswith(PERSON)):
        measures[name] = lambda result, name=name: result.values.get(name)
    for stage in dict.fromkeys(stage for result in results for stage in result.seconds):
        measures[f"processor time to {stage} [s]"] = lambda result, stage=stage: result.seconds.get(stage)
    rows: list[tuple[Cell, ...]] = []
    for constraint in _types(results):
        for other in conditions(results)[1:]:
            for name, measure in measures.items():
                found = paired_difference(results, constraint, other, measure, seed)
                if found:
                    rows.append((name, constraint, other, *found))
    columns = ("measure", "type", "condition", *_DIFFERENCE)
    return Table("comparison", _caption(results, seed), columns, tuple(rows))


def pairs_table(results: Sequence[FoldResult], measure: str, seed: int = 0) -> Table:
    """Conditions against the first one, pair by pair.

    Args:
        results: of two or more conditions on the same folds.
        measure: one of `PAIR_MEASURES`.
        seed: of the bootstrap.
    """
    rows: list[tuple[Cell, ...]] = []
    for pair in _pairs(results):
        for constraint in _types(results):
            for other in conditions(results)[1:]:
                found = paired_difference(results, constraint, other, _of_pair(pair, measure), seed)
                if found:
                    rows.append((pair, constraint, other, *found))
    columns = ("pair", "type", "condition", *_DIFFERENCE)
    return Table(f"pairs {measure}", f"Pair by pair, {measure}, mm. {_caption(results, seed)}", columns, tuple(rows))


def verdict_table(results: Sequence[FoldResult], seed: int = 0) -> Table:
    """On how many pairs the first condition is nearer to the person than each other one, and where it is not.

    Args:
        results: of two or more conditions on the same folds.
        seed: of the bootstrap.
    """
    first, *others = conditions(results)
    rows: list[tuple[Cell, ...]] = []
    for other in others:
        for constraint in _types(results):
            for measure in PAIR_MEASURES:
                found = {
                    pair: paired_difference(results, constraint, other, _of_pair(pair, measure), seed)
                    for pair in _pairs(results)
                }
                compared = {pair: one for pair, one in found.items() if one}
                worse = {pair: one for pair, one in compared.items() if one[2] < 0.0}
                certain = sum(high < 0.0 for *_, high, _ in worse.values())
                names = [f"{pair} (by {-one[2]:.1f})" for pair, one in worse.items()]
                counts = (float(len(compared) - len(worse)), float(len(worse)), float(certain))
                rows.append((other, constraint, measure, *counts, "; ".join(names) or "none"))
    caption = (
        f"Pairs on which {first!r} is at least as near to the person as the other condition, and on which it is worse "
        f"(mean over the folds; 'certainly': the whole interval is). {_caption(results, seed)}"
    )
    columns = ("condition", "type", "measure", "as near or nearer", "worse", "certainly", f"{first} is worse on")
    return Table("verdict", caption, columns, tuple(rows))


def paired_difference(
    results: Sequence[FoldResult], constraint: str, other: str, measure: Measure, seed: int = 0
) -> tuple[float, float, float, float, float, float] | None:
    """A measure under another condition against the first one, over the folds that both executed.

    Returns:
        Mean of the first and of the other condition, mean difference, both ends of its bootstrap interval, number of
        folds; None if there are none.
    """
    first = conditions(results)[0]
    base, compared = (
        {r.test: measure(r) for r in of_condition(results, name) if r.constraint == constraint and r.executed}
        for name in (first, other)
    )
    both = [
        (ours, theirs) for test, ours in base.items() if ours is not None and (theirs := compared.get(test)) is not None
    ]
    if not both:
        return None
    ours, theirs = np.array(both).T
    low, high = bootstrap_interval(theirs - ours, seed)
    return float(ours.mean()), float(theirs.mean()), float((theirs - ours).mean()), low, high, float(len(both))


def bootstrap_interval(values: Float[np.ndarray, " values"], seed: int = 0) -> tuple[float, float]:
    """Percentile bootstrap interval of the mean of values; of a single value, itself twice."""
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


def data_of(results: Sequence[FoldResult]) -> str:
    """What data results are on: real and synthetic are never mixed in one evaluation."""
    folds = len({result.test for result in results})
    robots = ", ".join(dict.fromkeys(result.robot for result in results))
    tested = "synthetic" if results[0].synthetic else "real"
    trained = "synthetic" if results[0].synthetic_training else "real"
    return f"{folds} fold{'s' if folds > 1 else ''}, learned from {trained}, tested on {tested} recordings, on {robots}"


_DIFFERENCE = ("first", "condition's", "difference", "from", "to", "folds")


def _caption(results: Sequence[FoldResult], seed: int) -> str:
    return (
        f"'difference': from {conditions(results)[0]!r}, the first condition, paired over folds, with the "
        f"{100 * CONFIDENCE:.0f} % bootstrap interval of the mean ({RESAMPLES} resamples, seed {seed}); "
        f"{data_of(results)}."
    )


def _of_pair(pair: str, measure: str) -> Measure:
    def value(result: FoldResult) -> float | None:
        return next((PAIR_MEASURES[measure](one) for one in result.pairs if one.pair == pair), None)

    return value


def _pairs(results: Sequence[FoldResult]) -> list[str]:
    return list(dict.fromkeys(pair.pair for result in results for pair in result.pairs))


def _types(results: Sequence[FoldResult]) -> list[str]:
    return list(dict.fromkeys(result.constraint for result in results))
