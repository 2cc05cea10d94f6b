"""The measure of rolling fails where it should: a good plan with its pin's motion spoilt."""

import pytest
from scipy.spatial.transform import RigidTransform

from sbam.demonstrations.scenes import starting_scene
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.planning.plan import Plan, plan
from sbam.tasks import measure_put_down, measure_rolling


@pytest.fixture(scope="module")
def rolling() -> Plan:
    return plan(learn(built_in_demonstrations("rolling")[::3]), starting_scene("built-in:rolling"))


def test_a_good_rolling(rolling):
    measure = measure_rolling(rolling)
    assert measure.ok, measure.problems
    assert measure.values["half-strokes"] >= 8
    assert measure_put_down(rolling).ok


def middle_of_motion(made: Plan) -> slice:
    count = len(made.model_time)
    return slice(count // 3, 2 * count // 3)


@pytest.mark.parametrize("height", [0.01, -0.01])
def test_a_pin_too_high_or_too_low(rolling, height, spoilt, shifted):
    measure = measure_rolling(spoilt(rolling, "handle_left", shifted([0.0, 0.0, height]), middle_of_motion(rolling)))
    assert not measure.ok
    assert measure.values["height off, worst [mm]"] > 5.0


def test_a_pin_that_stands_still(rolling, spoilt):
    def still(pose):
        return RigidTransform.concatenate([rolling.T_agent_object["rolling_pin"][0]] * len(pose))

    measure = measure_rolling(spoilt(rolling, "handle_left", still))
    assert not measure.ok
    assert measure.problems[0].startswith("0 half-strokes")


def test_a_pin_that_stops_halfway(rolling, spoilt):
    count = len(rolling.model_time)

    def stopped(pose):
        return RigidTransform.concatenate([rolling.T_agent_object["rolling_pin"][count // 2]] * len(pose))

    measure = measure_rolling(spoilt(rolling, "handle_left", stopped, slice(count // 2, None)))
    assert 1 <= measure.values["half-strokes"] < 8
    assert not measure.ok
