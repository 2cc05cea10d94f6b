"""The measure of pouring fails where it should: a good plan with its objects' motion spoilt."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.planning.plan import Plan
from sbam.tasks import measure_pouring


def tilt_deg(made: Plan) -> np.ndarray:
    up = made.T_agent_object["apple_juice"].rotation.apply([0.0, 1.0, 0.0])
    return np.degrees(np.arccos(np.clip(up[:, 2], -1.0, 1.0)))


def test_a_good_pouring(small_plan):
    measure = measure_pouring(small_plan)
    assert measure.ok
    assert measure.problems == ()
    tilt = tilt_deg(small_plan)
    assert measure.values["largest tilt [deg]"] == pytest.approx(tilt.max())
    assert measure.values["tilted for [s]"] == pytest.approx(1e-3 * (tilt > 60.0).sum())
    spout = small_plan.T_agent_object["apple_juice"].apply([0.0, 0.245, 0.0])
    rim = small_plan.T_agent_object["cup_large"].apply([0.0, 0.130, 0.0])
    aside = np.hypot(*(spout - rim)[tilt > 60.0, :2].T)
    assert measure.values["mouth aside, worst [mm]"] == pytest.approx(1e3 * aside.max())


@pytest.mark.parametrize("by", [[0.08, 0.0, 0.0], [0.0, -0.08, 0.0]])
def test_a_spout_beside_the_cup(small_plan, by, spoilt, shifted):
    measure = measure_pouring(spoilt(small_plan, "pour_from", shifted(by)))
    assert not measure.ok
    assert any("aside while tilted" in problem for problem in measure.problems)


def test_a_cup_taken_away(small_plan, spoilt, shifted):
    assert not measure_pouring(spoilt(small_plan, "pour_into", shifted([0.08, 0.0, 0.0]))).ok


def test_one_sample_beside_the_cup_is_enough(small_plan, spoilt, shifted):
    """The carton that is tilted while its spout is not over the cup, if only for a moment, spills."""
    sample = np.flatnonzero(tilt_deg(small_plan) > 70.0)[[0]]
    assert not measure_pouring(spoilt(small_plan, "pour_from", shifted([0.08, 0.0, 0.0]), sample)).ok
    upright = np.flatnonzero(tilt_deg(small_plan) < 50.0)
    assert measure_pouring(spoilt(small_plan, "pour_from", shifted([0.5, 0.0, 0.0]), upright)).ok


@pytest.mark.parametrize("by", [0.08, -0.05])
def test_a_spout_too_high_or_too_low(small_plan, by, spoilt, shifted):
    measure = measure_pouring(spoilt(small_plan, "pour_from", shifted([0.0, 0.0, by])))
    assert any("above the rim while tilted" in problem for problem in measure.problems)


def test_a_bottle_that_is_not_tilted(small_plan, spoilt):
    def upright(pose):
        start = small_plan.T_agent_object["apple_juice"][0].rotation
        return RigidTransform.from_components(pose.translation, Rotation.concatenate([start] * len(pose)))

    measure = measure_pouring(spoilt(small_plan, "pour_from", upright))
    assert not measure.ok
    assert measure.problems == ("never tilted beyond 60 degrees (at most 0)",)
