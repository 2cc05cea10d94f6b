"""Objects' paths in their demonstrated shape, and joints that are interpolated instead."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.demonstrations.scenes import scene_from_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.evaluation.executed_motion import flight
from sbam.evaluation.person import person_motion
from sbam.learning.learn import learn
from sbam.planning.bind import bind
from sbam.planning.motion.object_path import acting_point, object_path, shapes_of
from sbam.planning.plan import plan
from sbam.planning.settings import PlanSettings
from sbam.scene import ObjectLibrary


@pytest.fixture(scope="module")
def case():
    """Rolling, one demonstration left out, and what the person did there."""
    demonstrations = built_in_demonstrations("rolling")
    task = bind(learn(demonstrations[1:]), scene_from_demonstration(demonstrations[0]))
    return task, person_motion(demonstrations[0], task.model, ObjectLibrary.built_in())


def test_between_a_persons_own_keypoints_it_is_nearer_to_the_person(case):
    task, person = case
    (pin,) = task.moved
    model = task.model
    clock = 0.02 * np.arange(round(model.duration / 0.02) + 1)

    def poses(times):
        return person.poses_at(person.aligned(np.asarray(times)))[pin.role]

    ends = poses([pin.lift, pin.place])
    theirs = replace(pin, start=ends[0], put_down=ends[1])
    wanted = poses(clock).apply(acting_point(task, pin))
    off = {}
    for name, shape in (("poses", None), ("primitive", shapes_of(task)[pin.role])):
        path = object_path(task, theirs, model.keypoint_times, poses(model.keypoint_times), clock, shape).pose
        off[name] = np.linalg.norm(path.apply(acting_point(task, pin)) - wanted, axis=1).mean()
    assert off["primitive"] < 0.7 * off["poses"]


def test_objects_rest_before_and_after_as_without(case):
    task, _ = case
    (pin,) = task.moved
    executed = flight(task, PlanSettings(between="primitive"))
    pose, clock = executed.T_agent_object[pin.name], executed.model_time
    for still, at in ((clock <= pin.lift, pin.start), (clock >= pin.place, pin.put_down)):
        np.testing.assert_allclose(pose[still].translation - at.translation, 0, atol=1e-9)
        assert (pose[still].rotation * at.rotation.inv()).magnitude().max() < 1e-9


def test_models_without_paths_have_no_shapes(case):
    task, _ = case
    sketches = tuple(replace(sketch, paths=()) for sketch in task.model.demonstrations)
    assert shapes_of(replace(task, model=replace(task.model, demonstrations=sketches))) == {}


def test_joints_by_splines_open_two_handed_grasps(rolling_plan):
    """What the comparison with the paper shows, and the checks see."""
    model, scene = rolling_plan.task.model, rolling_plan.task.scene
    settings = PlanSettings(between="splines", avoid_collisions=False)
    splines = plan(model, scene, settings=settings)
    assert not splines.ok
    worst = {check.name: check.worst for check in splines.checks}
    assert worst["rolling_pin follows its path"] > 5e-3
    assert rolling_plan.ok
