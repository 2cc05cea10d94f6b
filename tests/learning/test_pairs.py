from dataclasses import replace

import pytest

from sbam.learning import LearningSettings
from sbam.learning.pairs import candidate_pairs, pair_constraint, pairs_that_move
from sbam.scene.object_library import ObjectLibrary

LIBRARY = ObjectLibrary.built_in()
POURING = {"bottle": LIBRARY["apple_juice"], "cup": LIBRARY["cup_large"], "table": LIBRARY["kitchen_sideboard"]}
ROLLING = {"pin": LIBRARY["rolling_pin"], "table": LIBRARY["kitchen_sideboard"]}
DEFAULT, PAPER = LearningSettings.default(), LearningSettings.paper()


def names(pairs):
    return {str(pair) for pair in pairs}


def test_pouring_in_default():
    assert names(candidate_pairs(POURING, DEFAULT)) == {
        "pour from of bottle -> pour into of cup",
        "place of bottle -> place onto of table",
        "place of cup -> place onto of table",
        "pour from of bottle -> place of bottle",
        "pour into of cup -> place of cup",
        "pour from of bottle -> own start",
        "place of bottle -> own start",
        "pour into of cup -> own start",
        "place of cup -> own start",
    }


def test_pouring_in_paper_has_the_ten_pairs_of_its_table():
    pairs = candidate_pairs(POURING, PAPER)
    assert len(pairs) == len(names(pairs)) == 10
    assert not any(pair.is_own_start for pair in pairs)


def test_a_pin_is_paired_with_the_surface():
    assert names(candidate_pairs(ROLLING, DEFAULT)) == {
        "handle left of pin -> place onto of table",
        "handle right of pin -> place onto of table",
        "handle left of pin -> handle right of pin",
        "handle left of pin -> own start",
        "handle right of pin -> own start",
    }


def test_pairs_in_which_nothing_moves_are_dropped():
    moving = pairs_that_move(candidate_pairs(POURING, DEFAULT), {"bottle"})
    assert "pour from of bottle -> pour into of cup" in names(moving)
    assert not any("of cup" in name for name in names(moving) - {"pour from of bottle -> pour into of cup"})


@pytest.mark.parametrize("constraint", ["cartesian", "cylindrical", "symbolic"])
def test_constraint_of_a_pair(constraint):
    for pair in candidate_pairs(POURING, DEFAULT):
        upright, support = pair.is_same_object, pair.second is not None and pair.second.affordance == "place onto"
        expected = "cartesian" if pair.is_own_start or upright or support else constraint
        assert pair_constraint(pair, POURING, constraint, DEFAULT) == expected
        if support:
            from_center = replace(DEFAULT, supports="center")
            assert pair_constraint(pair, POURING, constraint, from_center) == constraint
    # The pin's handles lie apart, so their azimuth is defined.
    handles = candidate_pairs(ROLLING, DEFAULT)[2]
    assert handles.is_same_object
    assert pair_constraint(handles, ROLLING, constraint, DEFAULT) == constraint
