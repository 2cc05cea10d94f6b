"""Measures of success fail where they should: good plans with their objects' motion spoilt."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.evaluation import measure_pouring, measure_put_down, measure_rolling
from sbam.evaluation.task_geometry import region_path
from sbam.learning.learn import learn
from sbam.planning.plan import Plan, plan


@pytest.fixture(scope="module")
def rolling() -> Plan:
    return plan(learn(built_in_demonstrations("rolling")[::3]), starting_scene("built-in:rolling"))


def spoilt(made: Plan, role: str, change, where=slice(None)) -> Plan:
    """The plan with poses (a selection of samples) of one object changed."""
    name = made.task.binding[role]
    pose = made.T_agent_object[name]
    matrices = pose.as_matrix().copy()
    matrices[where] = change(pose[where]).as_matrix()
    return replace(made, T_agent_object={**made.T_agent_object, name: RigidTransform.from_matrix(matrices)})


def shifted(by):
    return lambda pose: RigidTransform.from_translation(by) * pose


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
def test_a_spout_beside_the_cup(small_plan, by):
    measure = measure_pouring(spoilt(small_plan, "pour_from", shifted(by)))
    assert not measure.ok
    assert any("aside while tilted" in problem for problem in measure.problems)


def test_a_cup_taken_away(small_plan):
    assert not measure_pouring(spoilt(small_plan, "pour_into", shifted([0.08, 0.0, 0.0]))).ok


def test_one_sample_beside_the_cup_is_enough(small_plan):
    """The carton that is tilted while its spout is not over the cup, if only for a moment, spills."""
    sample = np.flatnonzero(tilt_deg(small_plan) > 70.0)[[0]]
    assert not measure_pouring(spoilt(small_plan, "pour_from", shifted([0.08, 0.0, 0.0]), sample)).ok
    upright = np.flatnonzero(tilt_deg(small_plan) < 50.0)
    assert measure_pouring(spoilt(small_plan, "pour_from", shifted([0.5, 0.0, 0.0]), upright)).ok


@pytest.mark.parametrize("by", [0.08, -0.05])
def test_a_spout_too_high_or_too_low(small_plan, by):
    measure = measure_pouring(spoilt(small_plan, "pour_from", shifted([0.0, 0.0, by])))
    assert any("above the rim while tilted" in problem for problem in measure.problems)


def test_a_bottle_that_is_not_tilted(small_plan):
    def upright(pose):
        start = small_plan.T_agent_object["apple_juice"][0].rotation
        return RigidTransform.from_components(pose.translation, Rotation.concatenate([start] * len(pose)))

    measure = measure_pouring(spoilt(small_plan, "pour_from", upright))
    assert not measure.ok
    assert measure.problems == ("never tilted beyond 60 degrees (at most 0)",)


@pytest.mark.parametrize("role", ["pour_from", "pour_into"])
def test_put_down_elsewhere(small_plan, role):
    assert measure_put_down(small_plan).ok
    last = slice(-500, None)
    measure = measure_put_down(spoilt(small_plan, role, shifted([0.0, 0.05, 0.0]), last))
    assert not measure.ok
    assert all(role in problem and "put down" in problem for problem in measure.problems)
    near = measure_put_down(spoilt(small_plan, role, shifted([0.0, 0.01, 0.0]), last))
    assert near.ok
    assert max(near.values.values()) == pytest.approx(10.0, abs=1.0)


def test_put_down_on_its_side(small_plan):
    """Its foot is where it should be, its mouth is not."""

    def toppled(pose):
        return pose * RigidTransform.from_rotation(Rotation.from_euler("x", 90.0, degrees=True))

    measure = measure_put_down(spoilt(small_plan, "pour_from", toppled, slice(-500, None)))
    assert any(problem.startswith("pour from of pour_from") for problem in measure.problems)


def test_a_good_rolling(rolling):
    measure = measure_rolling(rolling)
    assert measure.ok, measure.problems
    assert measure.values["half-strokes"] >= 8
    assert measure_put_down(rolling).ok


def middle_of_motion(made: Plan) -> slice:
    count = len(made.model_time)
    return slice(count // 3, 2 * count // 3)


@pytest.mark.parametrize("height", [0.01, -0.01])
def test_a_pin_too_high_or_too_low(rolling, height):
    measure = measure_rolling(spoilt(rolling, "handle_left", shifted([0.0, 0.0, height]), middle_of_motion(rolling)))
    assert not measure.ok
    assert measure.values["height off, worst [mm]"] > 5.0


def test_a_pin_that_stands_still(rolling):
    def still(pose):
        return RigidTransform.concatenate([rolling.T_agent_object["rolling_pin"][0]] * len(pose))

    measure = measure_rolling(spoilt(rolling, "handle_left", still))
    assert not measure.ok
    assert measure.problems[0].startswith("0 half-strokes")


def test_a_pin_that_stops_halfway(rolling):
    count = len(rolling.model_time)

    def stopped(pose):
        return RigidTransform.concatenate([rolling.T_agent_object["rolling_pin"][count // 2]] * len(pose))

    measure = measure_rolling(spoilt(rolling, "handle_left", stopped, slice(count // 2, None)))
    assert 1 <= measure.values["half-strokes"] < 8
    assert not measure.ok


def test_paths_of_regions(small_plan):
    table = region_path(small_plan, "place_onto", "place onto")
    assert table.shape == (len(small_plan.model_time), 3)
    assert np.ptp(table, axis=0).max() == 0.0
    assert table[0, 2] == pytest.approx(0.0, abs=1e-6)
    rim = region_path(small_plan, "pour_into", "pour into")
    start = small_plan.task.T_agent_object["cup_large"]
    np.testing.assert_allclose(rim[0], start.apply([0.0, 0.130, 0.0]), atol=1e-9)
