"""The paper's two faults are seen where they are put in."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.evaluation.executed_motion import executed_plan
from sbam.tasks.faults import measure_faults

END, BEFORE, BESIDE = "largest speed at the end [mm/s]", "largest speed before [mm/s]", "tilted beside the cup for [s]"


@pytest.fixture(scope="module")
def motion(small_plan):
    return executed_plan(small_plan)


def moved_bottle(motion, offset, turn=None):
    pose = motion.T_agent_object["apple_juice"]
    turn = Rotation.identity() if turn is None else turn
    changed = RigidTransform.from_components(pose.translation + offset, turn * pose.rotation)
    return replace(motion, T_agent_object={**motion.T_agent_object, "apple_juice": changed})


def test_a_good_execution_has_neither(motion, small_plan):
    faults = measure_faults(motion)
    assert 10 < faults[END] < faults[BEFORE] < 1500
    assert faults[BESIDE] == 0
    assert faults == measure_faults(small_plan)


def test_an_abrupt_move_at_the_end(motion):
    """The bottle runs away at 700 mm/s of the demonstration's time from the last but one keypoint on."""
    last = motion.task.model.keypoint_times[-2]
    away = np.clip(motion.model_time - last, 0.0, 0.1)[:, None] * [0.7, 0.0, 0.0]
    faults = measure_faults(moved_bottle(motion, away))
    assert faults[END] >= 0.9 * 700
    assert faults[BEFORE] == pytest.approx(measure_faults(motion)[BEFORE])


def test_stretching_time_changes_nothing(motion):
    slow = replace(motion, time=3.0 * motion.time)
    assert measure_faults(slow) == measure_faults(motion)


def test_a_carton_tilted_beside_the_cup(motion):
    """Shifted aside by more than the rim, all of its pouring is beside; the time is that of the tilt."""
    bottle = motion.task.scene.objects[motion.task.binding["pour_from"]]
    tilted = motion.T_agent_object["apple_juice"].rotation.apply(bottle.up)[:, 2] < 0.5
    expected = np.gradient(motion.model_time)[tilted].sum()
    assert expected > 0.5
    assert measure_faults(moved_bottle(motion, [0.2, 0.0, 0.0]))[BESIDE] == pytest.approx(expected)


def test_without_pouring_only_speeds(rolling):
    assert set(measure_faults(rolling)) == {END, BEFORE}


@pytest.fixture(scope="module")
def rolling():
    from sbam.demonstrations.scenes import starting_scene
    from sbam.demonstrations.synthetic import built_in_demonstrations
    from sbam.evaluation.executed_motion import flight
    from sbam.learning.learn import learn
    from sbam.planning.bind import bind
    from sbam.planning.settings import PlanSettings

    model = learn(built_in_demonstrations("rolling")[::4])
    return flight(bind(model, starting_scene("built-in:rolling")), PlanSettings())
