"""Arms that pass each other on the way to their grasps and back."""

import numpy as np
import pytest

from sbam.demonstrations.scenes import scene_from_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning.learn import learn
from sbam.planning.motion.allowed_contacts import collision_model, touching_hands
from sbam.planning.motion.carrying import Holding, hold_objects
from sbam.planning.motion.motion import Motion, with_approaches
from sbam.planning.plan import Plan, plan
from sbam.planning.start import in_agent_frame
from sbam.tasks import measure_pouring, measure_put_down


@pytest.fixture(scope="module")
def crossing() -> Plan:
    """The right hand fetches the bottle from the left, the left hand the cup from the right."""
    demonstrations = built_in_demonstrations("pouring")[:9]
    shown = next(d for d in demonstrations if "left" in d.name)
    return plan(learn([d for d in demonstrations if d is not shown]), scene_from_demonstration(shown), "panda_dual")


@pytest.fixture(scope="module")
def holding(crossing, problem_of) -> Holding:
    q = crossing.solution.configurations
    poses = problem_of(crossing).state(q).object_poses()
    times = crossing.task.model.keypoint_times
    return hold_objects(crossing.task, in_agent_frame(crossing.robot), crossing.grasps, times, q, poses)


def distances(plan: Plan, motion: Motion) -> np.ndarray:
    """(N,) least distance at every tick of what must not touch."""
    objects = {**plan.task.T_agent_object, **motion.T_agent_object}
    held = touching_hands(plan.task, motion.phases, motion.clock)
    report = collision_model(plan.task, in_agent_frame(plan.robot)).clearances(motion.configurations, objects, held)
    return np.min([d for kind, d in report.distance_by_class.items() if kind != "palm-object"], axis=0)


def test_arms_that_cross(crossing):
    starts = {moved.hands: moved.start.translation[0] for moved in crossing.task.moved}
    assert starts["right",] < 0.0 < starts["left",]
    assert crossing.ok, crossing.problems
    for measure in (measure_pouring(crossing), measure_put_down(crossing)):
        assert measure.ok, measure.problems


def test_the_action_waits_for_the_arm_that_passes(crossing):
    clock, time = crossing.model_time, crossing.trajectory.time
    assert np.diff(clock).min() > 0.0
    rate = np.gradient(clock, time)
    waits = rate < 0.02
    assert waits.sum() > 100
    assert [note for note in crossing.notes if note.startswith("all else waits ")]
    # Meanwhile one arm moves, and what is carried stands still.
    moving = np.abs(crossing.trajectory.velocity[waits]).max(axis=0)
    assert moving.max() > 0.1
    for poses in crossing.T_agent_object.values():
        speed = np.linalg.norm(np.gradient(poses.translation, time, axis=0), axis=1)
        assert speed[waits].max() < 0.02


def test_the_distance_that_the_ways_promise_is_kept(crossing, holding):
    shapes = collision_model(crossing.task, in_agent_frame(crossing.robot))
    motion = with_approaches(crossing.task, in_agent_frame(crossing.robot), shapes, holding)
    assert motion.surplus > 0.0
    # Ways are looked at in samples, a few centimetres apart.
    assert distances(crossing, motion).min() > min(motion.surplus, 0.0) - 0.002


def test_more_distance_takes_other_ways(crossing, holding):
    shapes = collision_model(crossing.task, in_agent_frame(crossing.robot))
    motion = with_approaches(crossing.task, in_agent_frame(crossing.robot), shapes, holding, clearance=0.06)
    assert motion.surplus < 0.0
    assert motion.narrowest in crossing.grasps


def test_without_the_other_arm_nothing_waits(small_plan, problem_of):
    """Where arms do not cross the clock is the model's time."""
    q = small_plan.solution.configurations
    poses = problem_of(small_plan).state(q).object_poses()
    times = small_plan.task.model.keypoint_times
    held = hold_objects(small_plan.task, in_agent_frame(small_plan.robot), small_plan.grasps, times, q, poses)
    shapes = collision_model(small_plan.task, in_agent_frame(small_plan.robot))
    motion = with_approaches(small_plan.task, in_agent_frame(small_plan.robot), shapes, held)
    np.testing.assert_allclose(motion.model_time, motion.clock, atol=1e-9)
    assert motion.notes == ()
