"""Measures: zero for the person's own motion, and known values for known deviations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.scenes import scene_from_demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.evaluation.executed_motion import ExecutedMotion, executed_plan, flight
from sbam.evaluation.metrics import PairDistances, measures, pair_distances, paper_pairs
from sbam.evaluation.person import PersonMotion, model_anchors, person_motion
from sbam.learning.learn import learn
from sbam.planning.bind import bind
from sbam.planning.settings import PlanSettings
from sbam.scene import ObjectLibrary

LIBRARY = ObjectLibrary.built_in()


@pytest.fixture(scope="module")
def copied() -> tuple[ExecutedMotion, PersonMotion]:
    """An execution that does exactly what the person did, and the person."""
    demonstrations = built_in_demonstrations("pouring")
    model = learn(demonstrations[:3])
    person = person_motion(demonstrations[0], model, LIBRARY)
    task = bind(model, scene_from_demonstration(demonstrations[0]))
    clock = np.linspace(0.0, model.duration, 801)
    roles = [moved.role for moved in task.moved]
    at_keypoints, dense = (person.poses_at(person.aligned(times)) for times in (model.keypoint_times, clock))
    motion = ExecutedMotion(
        task=task,
        keypoint_poses={role: at_keypoints[role] for role in roles},
        time=clock,
        model_time=clock,
        T_agent_object={task.binding[role]: dense[role] for role in roles},
        objective=0.0,
        human_deviation=None,
        trajectory=None,
        problems=(),
    )
    return motion, person


def changed(motion: ExecutedMotion, role: str, change) -> ExecutedMotion:
    """The motion with all poses of one object changed."""
    name = motion.task.binding[role]
    return replace(
        motion,
        keypoint_poses={**motion.keypoint_poses, role: change(motion.keypoint_poses[role])},
        T_agent_object={**motion.T_agent_object, name: change(motion.T_agent_object[name])},
    )


def test_the_paper_s_ten_pairs(copied):
    motion, _ = copied
    pairs = paper_pairs(motion.task)
    assert len(pairs) == 10
    assert not any(pair.is_own_start for pair in pairs)


def test_the_person_s_own_motion_is_at_no_distance(copied):
    motion, person = copied
    for pair in pair_distances(motion, person, [person]):
        assert np.asarray(pair.events) == pytest.approx(0.0, abs=1e-6)
        assert pair.spread == (0.0,) * len(motion.task.model.keypoint_times)
        # All that is left in the same second is the tempo.
        assert np.mean(pair.seconds) == pytest.approx(pair.tempo, abs=1e-6)
        # The dense motion is compared at the nearest later sample.
        assert pair.dense < 10.0
    values = measures(motion, person)
    assert values["mouth - rim while pouring [mm]"] == pytest.approx(0.0, abs=1e-6)
    for role in ("pour_from", "pour_into"):
        for name in ("orientation error [deg]", "axis error [deg]", "tilt error, rms [deg]", "ends off by [mm]"):
            assert values[f"{role}: {name}"] == pytest.approx(0.0, abs=1e-4)


def test_a_shift_of_one_object_shows_in_all_pairs_across_it(copied):
    motion, person = copied
    shifted = changed(motion, "pour_from", lambda pose: RigidTransform.from_translation([0.03, 0.04, 0.0]) * pose)
    for pair in pair_distances(shifted, person, [person]):
        expected = 50.0 if pair.pair.count("of pour_from") == 1 else 0.0
        assert np.asarray(pair.events) == pytest.approx(expected, abs=1e-6)
        assert np.asarray(pair.relevant) == pytest.approx(expected, abs=1e-6)
    values = measures(shifted, person)
    assert values["mouth - rim while pouring [mm]"] == pytest.approx(50.0)
    assert values["pour_from: ends off by [mm]"] == pytest.approx(50.0)
    assert values["pour_into: ends off by [mm]"] == pytest.approx(0.0, abs=1e-6)


def test_a_turn_of_one_object_shows_in_its_orientation(copied):
    motion, person = copied
    turn = RigidTransform.from_rotation(Rotation.from_euler("y", 12.0, degrees=True))  # about the bottle's own axis
    values = measures(changed(motion, "pour_from", lambda pose: pose * turn), person)
    assert values["pour_from: orientation error [deg]"] == pytest.approx(12.0)
    assert values["pour_from: axis error [deg]"] == pytest.approx(0.0, abs=1e-4)
    tip = RigidTransform.from_rotation(Rotation.from_euler("x", 12.0, degrees=True))
    values = measures(changed(motion, "pour_from", lambda pose: pose * tip), person)
    assert values["pour_from: axis error [deg]"] == pytest.approx(12.0)


def test_a_late_person_is_seen_by_the_second_but_not_by_events(copied):
    motion, person = copied
    late = replace(person, time=2.0 * person.time, own_anchors=2.0 * person.own_anchors)
    for pair in pair_distances(motion, late, [person]):
        assert np.asarray(pair.events) == pytest.approx(0.0, abs=1e-6)
    assert max(np.mean(pair.seconds) for pair in pair_distances(motion, late, [person])) > 20.0


def test_relevance_weighs_agreement():
    pair = PairDistances("a -> b", (0.0, 0.0), (10.0, 100.0), (0.0, 1000.0), 0.0, 0.0)
    weights = np.array([1 / 25.0, 1 / (1000.0**2 + 25.0)])
    assert np.asarray(pair.relevant) == pytest.approx(weights @ [10.0, 100.0] / weights.sum())
    assert np.asarray(pair.relevant) == pytest.approx(10.0, abs=0.01)


def test_the_spread_is_that_of_the_training(copied):
    motion, person = copied
    shift = RigidTransform.from_translation([0.02, 0.0, 0.0])
    other = replace(person, T_agent_role={**person.T_agent_role, "pour_from": shift * person.T_agent_role["pour_from"]})
    for pair in pair_distances(motion, person, [person, other]):
        expected = 20.0 / np.sqrt(2.0) if pair.pair.count("of pour_from") == 1 else 0.0
        assert np.asarray(pair.spread) == pytest.approx(expected, abs=1e-6)


def test_a_motion_that_jerks_is_less_smooth(copied):
    motion, person = copied
    smooth = measures(motion, person)["pour_into: log dimensionless jerk"]
    shake = 0.005 * np.sin(2 * np.pi * 4.0 * motion.model_time)
    pose = RigidTransform.from_translation(shake[:, None] * [1.0, 0.0, 0.0]) * motion.T_agent_object["cup_large"]
    shaken = replace(motion, T_agent_object={**motion.T_agent_object, "cup_large": pose})
    assert measures(shaken, person)["pour_into: log dimensionless jerk"] > smooth + 1.0


def test_a_paper_model_is_aligned_by_the_events_that_it_keeps():
    demonstrations = built_in_demonstrations("pouring")[:3]
    paper = learn(demonstrations, mode="paper")
    assert [anchor.kind for anchor in paper.anchors] == ["start", "end"]
    found, known = model_anchors(paper), model_anchors(learn(demonstrations))
    assert found.kinds == known.kinds
    assert found.times == pytest.approx(known.times)


def test_a_plan_is_executed_as_it_was_optimised(small_plan):
    motion = executed_plan(small_plan)
    # At keypoints where nothing rests the dense motion passes through the optimised poses, but for rounded corners.
    for role, poses in motion.keypoint_poses.items():
        assert poses[0].translation == pytest.approx(
            motion.T_agent_object[motion.task.binding[role]][0].translation, abs=1e-3
        )
        assert poses[-1].translation == pytest.approx(
            motion.T_agent_object[motion.task.binding[role]][-1].translation, abs=1e-3
        )
    assert motion.human_deviation is not None
    assert 0.0 < motion.human_deviation < 180.0


def test_rolling_is_flown():
    demonstrations = built_in_demonstrations("rolling")
    model = learn(demonstrations[1:4])
    motion = flight(bind(model, scene_from_demonstration(demonstrations[0])), PlanSettings())
    person = person_motion(demonstrations[0], model, LIBRARY)
    values = measures(motion, person)
    assert values["half-strokes (person)"] == 8
    assert values["half-strokes"] == 8
    assert values["turning points off by [mm]"] < 40.0
    assert len(pair_distances(motion, person, [person])) == 3
