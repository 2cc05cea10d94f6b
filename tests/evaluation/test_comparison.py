"""Conditions against each other: numbers that can be worked by hand."""

import numpy as np
import pytest

from sbam.evaluation.comparison import bootstrap_interval, comparison_table, pairs_table, verdict_table


def test_differences_are_paired_over_folds(result):
    first = [result("x", (1.0,)), result("y", (50.0,)), result("only here", (0.0,))]
    second = [result("x", (3.0,), "b"), result("y", (54.0,), "b")]
    table = comparison_table(first + second)
    row = next(row for row in table.rows if row[0] == "all pairs, by events [mm]")
    assert row[1:] == ("cartesian", "b", 25.5, 28.5, 3.0, 2.0, 4.0, 2.0)
    assert [row[0] for row in table.rows][4:] == ["processor time to plan [s]"]
    assert "'a'" in table.caption
    assert "synthetic" in table.caption


def test_every_measure_of_the_execution_is_compared(result):
    first = [result("x", (1.0,), height=2.0, **{"speed (person)": 1.0})]
    second = [result("x", (1.0,), "b", height=5.0, **{"speed (person)": 1.0})]
    rows = {row[0]: row for row in comparison_table(first + second).rows}
    assert rows["height"][3:6] == (2.0, 5.0, 3.0)
    assert "speed (person)" not in rows


def test_every_pair_is_compared_by_itself(result):
    first = [result("x", {"p": (1.0, 3.0), "q": (5.0, 5.0)}), result("y", {"p": (2.0, 2.0), "q": (7.0, 7.0)})]
    second = [
        result("x", {"p": (4.0, 4.0), "q": (4.0, 4.0)}, "b"),
        result("y", {"p": (3.0, 3.0), "q": (4.0, 4.0)}, "b"),
    ]
    table = pairs_table(first + second, "same second")  # twice the distances by events
    assert [row[:6] for row in table.rows] == [
        ("p", "cartesian", "b", 4.0, 7.0, 3.0),
        ("q", "cartesian", "b", 12.0, 8.0, -4.0),
    ]

    verdict = verdict_table(first + second)
    by_events = next(row for row in verdict.rows if row[2] == "by events")
    assert by_events[:6] == ("b", "cartesian", "by events", 1.0, 1.0, 1.0)
    assert by_events[6] == "q (by 2.0)"
    other_way = next(row for row in verdict_table(second + first).rows if row[2] == "by events")
    assert other_way[3:] == (1.0, 1.0, 1.0, "p (by 1.5)")


def test_what_is_nowhere_worse_is_said_to_be(result):
    table = verdict_table([result("x", (1.0, 2.0)), result("x", (3.0, 4.0), "b")])
    assert {row[2]: row[3:] for row in table.rows} == {
        measure: (1.0, 0.0, 0.0, "none") for measure in ("same second", "by events", "relevant", "dense")
    }


def test_a_worse_mean_whose_interval_holds_zero_is_not_certain(result):
    first = [result("x", (1.0,)), result("y", (50.0,))]
    second = [result("x", (3.0,), "b"), result("y", (40.0,), "b")]
    row = next(row for row in verdict_table(first + second).rows if row[2] == "by events")
    assert row[3:6] == (0.0, 1.0, 0.0)


def test_bootstrap_is_seeded_and_covers():
    generator = np.random.default_rng(1)
    covered = 0
    for _ in range(40):
        low, high = bootstrap_interval(generator.normal(3.0, 1.0, 30), seed=5)
        covered += low < 3.0 < high
    assert covered >= 32
    values = generator.normal(size=9)
    assert bootstrap_interval(values, 7) == bootstrap_interval(values, 7)
    assert bootstrap_interval(np.array([2.0])) == pytest.approx((2.0, 2.0))
