"""Where the objects would go if no robot had to hold them."""

import numpy as np
import pytest

from sbam.demonstrations.scenes import starting_scene
from sbam.planning.bind import bind
from sbam.planning.keypoints.free_flight import flying_hands, solve_free_flight
from sbam.planning.settings import PlanSettings


@pytest.fixture(scope="module", params=["pouring", "rolling"])
def flown(request, model_of):
    scene = {"pouring": "pouring_new_layout", "rolling": "rolling"}[request.param]
    task = bind(model_of(request.param), starting_scene(f"built-in:{scene}"))
    return task, *solve_free_flight(task, PlanSettings())


def test_objects_rest_before_their_lift_and_after_their_place(flown):
    task, _, poses = flown
    times = task.model.keypoint_times
    for moved in task.moved:
        assert len(poses[moved.role]) == len(times)
        for resting, still in ((times <= moved.lift, moved.start), (times >= moved.place, moved.put_down)):
            off = still.inv() * poses[moved.role][resting]
            assert np.linalg.norm(off.translation, axis=1).max() < 5e-4
            assert off.rotation.magnitude().max() < 5e-3


def test_pairs_are_as_near_to_what_was_learned_as_they_are_certain(flown):
    """Each costs a few learned standard deviations at most; summed over keypoints, less than one each on average."""
    _, solution, _ = flown
    costs = np.array(list(solution.terms["similarity"].values()))
    assert costs.mean() < 1.5
    assert solution.objective > 0.0


def test_the_spout_comes_over_the_cup(model_of):
    task = bind(model_of("pouring"), starting_scene("built-in:pouring_new_layout"))
    _, poses = solve_free_flight(task, PlanSettings())
    offset = poses["pour_from"].apply([0.0, 0.245, 0.0]) - poses["pour_into"].apply([0.0, 0.130, 0.0])
    tilt = (poses["pour_from"].rotation * poses["pour_from"][0].rotation.inv()).magnitude()
    pouring = tilt > np.deg2rad(60.0)
    assert pouring.sum() >= 2
    assert np.hypot(*offset[pouring, :2].T).max() < 0.040
    assert ((offset[pouring, 2] > 0.010) & (offset[pouring, 2] < 0.080)).all()


def test_flying_hands_have_no_limits():
    robot = flying_hands()
    assert robot is flying_hands()
    assert np.isinf(robot.lower).all()
    assert np.isinf(robot.upper).all()
