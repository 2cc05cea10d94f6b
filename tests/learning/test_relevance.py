from dataclasses import replace

import numpy as np
import pytest

from sbam.constraints import CONSTRAINT_TYPES
from sbam.learning import learn
from sbam.learning.relevance import pruned, rank_pairs


@pytest.mark.parametrize("constraint", list(CONSTRAINT_TYPES))
def test_the_mouth_over_the_cup_is_what_matters(pouring, constraint):
    model = learn(pouring[:9], constraint)
    ranked = rank_pairs(model)
    assert {entry.pair for entry in ranked} == {change.pair for change in model.changes}
    between = [entry for entry in ranked if len(entry.pair.roles) == 2]
    assert str(between[0].pair) == "pour from of pour_from -> pour into of pour_into"
    assert between[0].precision == 1.0
    assert between[0].precision > 1.3 * between[1].precision
    tilts = [anchor.time for anchor in model.anchors if anchor.kind == "tilt"]
    assert tilts[0] - 1 < between[0].best_time < tilts[-1] + 1
    for entry in ranked:
        assert 0 < entry.precision <= 1 and entry.spread > 0 and 0 <= entry.best_time <= model.duration
        assert entry.fixed == (entry.spread < 0.1)


def test_pruning_keeps_what_carries_and_what_is_precise(pouring):
    model = learn(pouring[:9], mode="paper")
    small = pruned(model)
    names = {str(change.pair) for change in small.changes}
    assert "pour from of pour_from -> pour into of pour_into" in names
    assert "place of pour_from -> place onto of place_onto" not in names
    assert all(change.pair.is_same_object for change in model.changes if change not in small.changes) is False
    assert sum(change.pair.is_same_object for change in small.changes) == 2
    assert small.keypoint_times[0] == 0 and small.keypoint_times[-1] == model.duration
    assert len(pruned(model, 0.0).changes) == len(model.changes)


def test_one_demonstration_says_nothing_about_relevance(pouring):
    ranked = rank_pairs(learn(pouring[:1]))
    assert {entry.precision for entry in ranked} == {1.0}
    assert np.all([np.isfinite(entry.spread) for entry in ranked])


def test_without_holds_the_whole_action_counts(pouring):
    ranked = rank_pairs(replace(learn(pouring[:9]), holds=()))
    assert all(np.isfinite(entry.spread) for entry in ranked)
