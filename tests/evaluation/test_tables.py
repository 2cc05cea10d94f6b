"""Tables: the paper's numbers, statistics that can be worked by hand, and the formats."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from sbam.evaluation.paper_numbers import PAPER_TABLES, paper_row
from sbam.evaluation.tables import evaluation_tables, similarity_table

MOUTH_RIM = "pour from of pour_from -> pour into of pour_into"


def test_the_paper_s_tables_are_complete():
    assert [len(table) for table in PAPER_TABLES.values()] == [10, 3]
    for table in PAPER_TABLES.values():
        assert all(len(row) == 3 for row in table.values())
    # The paper's text says about 17 cm for mouth and rim, and 25.226 mm as the largest difference between types.
    pouring = {pair: [row[kind][0] for kind in row] for pair, row in PAPER_TABLES["pouring"].items()}
    assert max(np.ptp(averages) for averages in pouring.values()) == pytest.approx(25.226)


@pytest.mark.parametrize("pair", [MOUTH_RIM, " -> ".join(reversed(MOUTH_RIM.split(" -> ")))])
def test_a_pair_finds_its_row_in_either_order(pair):
    task, row = paper_row(pair) or ("", ("", ""))
    assert task == "pouring"
    assert PAPER_TABLES[task][row]["cartesian"] == (165.770, 208.665, 3.357)


def test_an_unknown_pair_has_no_row():
    assert paper_row("stir of spoon -> stir in of bowl") is None


def test_statistics_are_over_all_keypoints_of_all_folds(result):
    table = similarity_table([result("x", (1.0, 3.0)), result("y", (5.0, 7.0))])
    row = dict(zip(table.columns[2:], table.rows[0][2:], strict=False))
    assert row["paper avg"] == 165.770
    numbers = table.rows[0][5:]
    assert numbers == pytest.approx((8.0, 2 * np.std([1, 3, 5, 7]), 2.0, 6.0, 4.0, np.std([1, 3, 5, 7]), 4.0, 5.0))
    assert "synthetic" in table.caption
    assert "KIT" in table.caption


def test_other_objects_are_not_compared_with_the_paper(result):
    spoon = replace(result("x", (1.0,)), objects=("cup_large", "tablespoon"))
    assert all(row[2] is None for row in similarity_table([spoon]).rows)


def test_formats_agree(result):
    tables = evaluation_tables([result("x", (1.0,), height=2.5), result("x", (3.0,), "b", height=3.5)])
    assert [table.name for table in tables] == [
        *("similarity a", "similarity b", "measures"),
        *("pairs same second", "pairs by events", "pairs relevant", "pairs dense", "comparison", "verdict"),
    ]
    measures = tables[2]
    assert next(row for row in measures.rows if row[0] == "height")[1:] == (2.5, 3.5)
    read = list(csv.reader(line for line in io.StringIO(measures.csv()) if not line.startswith("#")))
    assert tuple(read[0]) == measures.columns
    assert read[1] == ["height", "2.5", "3.5"]
    assert "| height | 2.50 | 3.50 |" in measures.markdown()
    assert r"height & 2.50 & 3.50 \\" in measures.latex()
    assert r"pour\_from" not in measures.latex()
    assert all(line.count("&") == len(measures.columns) - 1 for line in measures.latex().splitlines() if "&" in line)
