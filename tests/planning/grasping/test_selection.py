"""Grasps with which the whole action can be done."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from sbam.errors import UnreachableError
from sbam.planning.grasping.selection import choose_grasps
from sbam.planning.keypoints.free_flight import solve_free_flight
from sbam.planning.motion.allowed_contacts import collision_model, meeting_objects
from sbam.planning.start import in_agent_frame


@pytest.fixture(scope="module")
def some(small_plan):
    """Indices of a few keypoints from the first lift to the last place."""
    return np.unique(np.linspace(4, len(small_plan.task.model.keypoint_times) - 5, 8).round().astype(int))


@pytest.fixture(scope="module")
def times(small_plan, some):
    return small_plan.task.model.keypoint_times[some]


@pytest.fixture(scope="module")
def checkpoints(small_plan, some):
    """Object poses of the free flight at these keypoints."""
    _, poses = solve_free_flight(small_plan.task, small_plan.settings)
    return {role: pose[some] for role, pose in poses.items()}


@pytest.fixture(scope="module")
def combinations(small_plan, checkpoints, times):
    shapes = collision_model(small_plan.task, in_agent_frame(small_plan.robot))
    return choose_grasps(small_plan.task, in_agent_frame(small_plan.robot), shapes, checkpoints, times, seed=0)


def test_every_chosen_grasp_holds_its_object_while_it_is_carried(small_plan, checkpoints, times, combinations):
    robot = in_agent_frame(small_plan.robot)
    assert 1 < len(combinations) <= 60
    for combination in combinations[:5]:
        assert set(combination) == {("pour_from", "right"), ("pour_into", "left")}
        for (role, hand), followed in combination.items():
            moved = next(moved for moved in small_plan.task.moved if moved.role == role)
            held = (times >= moved.lift) & (times <= moved.place)
            k = robot.kinematics(followed.configurations[held], [robot.arms[hand].tcp_frame])
            wanted = checkpoints[role][held] * followed.grasp.T_object_tcp
            assert np.linalg.norm(k.position[:, 0] - wanted.translation, axis=1).max() < 1e-3
            turn = wanted.rotation.inv().as_matrix() @ k.rotation[:, 0]
            assert np.arccos(np.clip(0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0), -1.0, 1.0)).max() < np.deg2rad(0.5)
            assert (followed.configurations >= robot.lower).all()
            assert (followed.configurations <= robot.upper).all()


def test_combinations_differ(combinations):
    seen = {tuple(id(item) for item in combination.values()) for combination in combinations}
    assert len(seen) == len(combinations)


def test_the_same_seed_chooses_the_same(small_plan, checkpoints, times, combinations):
    shapes = collision_model(small_plan.task, in_agent_frame(small_plan.robot))
    again = choose_grasps(small_plan.task, in_agent_frame(small_plan.robot), shapes, checkpoints, times, seed=0)
    for first, second in zip(combinations, again, strict=True):
        for key in first:
            np.testing.assert_array_equal(first[key].configurations, second[key].configurations)


def test_objects_that_the_action_brings_together_may_touch(small_plan, rolling_plan):
    pairs = set(meeting_objects(small_plan.task))
    assert {frozenset(pair) for pair in pairs} >= {
        frozenset(("apple_juice", "cup_large")),
        frozenset(("apple_juice", "kitchen_sideboard")),
    }
    assert {frozenset(pair) for pair in meeting_objects(rolling_plan.task)} == {
        frozenset(("rolling_pin", "kitchen_sideboard"))
    }


def test_out_of_reach_says_how_far(small_plan, checkpoints, times):
    far = {role: RigidTransform.from_translation([0.0, 0.8, 0.0]) * pose for role, pose in checkpoints.items()}
    robot = in_agent_frame(small_plan.robot)
    with pytest.raises(UnreachableError, match=r"'apple_juice' with none of \d+ grasps .* by \d+ mm"):
        choose_grasps(small_plan.task, robot, collision_model(small_plan.task, robot), far, times)
