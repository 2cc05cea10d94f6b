"""Dense paths of objects between keypoints."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.planning.motion.object_path import EASING, SMOOTHING, acting_point, ease, object_path

STEP = 0.02


@pytest.fixture(scope="module")
def keypoints(small_plan, problem_of):
    """Times and object poses at the keypoints of the pouring plan."""
    problem = problem_of(small_plan)
    return small_plan.task.model.keypoint_times, problem.state(small_plan.solution.configurations).object_poses()


@pytest.fixture(scope="module")
def clock(keypoints) -> np.ndarray:
    return STEP * np.arange(-40, round(keypoints[0][-1] / STEP) + 40)


@pytest.fixture(scope="module")
def paths(small_plan, keypoints, clock):
    times, poses = keypoints
    return {
        moved.role: object_path(small_plan.task, moved, times, poses[moved.role], clock)
        for moved in small_plan.task.moved
    }


def moved_object(plan, role: str):
    return next(moved for moved in plan.task.moved if moved.role == role)


def test_acting_points_are_spout_rim_and_the_middle_of_the_pin(small_plan, rolling_plan):
    task = small_plan.task
    np.testing.assert_allclose(acting_point(task, moved_object(small_plan, "pour_from")), [0.0, 0.245, 0.0])
    np.testing.assert_allclose(acting_point(task, moved_object(small_plan, "pour_into")), [0.0, 0.130, 0.0])
    (pin,) = rolling_plan.task.moved
    np.testing.assert_allclose(acting_point(rolling_plan.task, pin), np.zeros(3), atol=1e-12)


def test_objects_rest_exactly_before_the_lift_and_after_the_place(small_plan, paths, clock):
    for moved in small_plan.task.moved:
        pose = paths[moved.role].pose
        for resting, still in ((clock <= moved.lift, moved.start), (clock >= moved.place, moved.put_down)):
            assert resting.sum() > 30
            np.testing.assert_allclose(
                pose[resting].as_matrix(), np.broadcast_to(still.as_matrix(), (resting.sum(), 4, 4)), atol=1e-12
            )


def test_paths_pass_near_the_keypoints(small_plan, keypoints, paths, clock):
    """Rounding a corner of slopes a and b by a Gaussian of width s moves the path by |b - a| s / sqrt(2 pi)."""
    times, poses = keypoints
    for moved in small_plan.task.moved:
        inside = (times > moved.lift + EASING) & (times < moved.place - EASING)
        point = acting_point(small_plan.task, moved)
        wanted = poses[moved.role].apply(point)
        slopes = np.diff(wanted, axis=0) / np.diff(times)[:, None]
        corner = np.zeros(len(times))
        corner[1:-1] = np.linalg.norm(np.diff(slopes, axis=0), axis=1)
        dense = paths[moved.role].pose.apply(point)
        at = np.stack([np.interp(times, clock, column) for column in dense.T], axis=-1)
        off = np.linalg.norm(at - wanted, axis=1)
        bound = 2e-3 + 1.5 * corner * SMOOTHING / np.sqrt(2 * np.pi)
        assert inside.sum() > 5
        assert (off < bound)[inside].all()
        nearest = np.abs(clock[:, None] - times).argmin(axis=0)
        turn = (paths[moved.role].pose.rotation[nearest] * poses[moved.role].rotation.inv()).magnitude()
        assert np.median(turn[inside]) < np.deg2rad(1.5)


def test_rotations_are_proper_and_continuous(small_plan, rolling_plan, problem_of, paths, clock):
    (pin,) = rolling_plan.task.moved
    times = rolling_plan.task.model.keypoint_times
    poses = problem_of(rolling_plan).state(rolling_plan.solution.configurations).object_poses()
    every = [*paths.values(), object_path(rolling_plan.task, pin, times, poses[pin.role], clock)]
    for path in every:
        matrix = path.pose.rotation.as_matrix()
        np.testing.assert_allclose(
            matrix @ np.swapaxes(matrix, 1, 2), np.broadcast_to(np.eye(3), matrix.shape), atol=1e-9
        )
        np.testing.assert_allclose(np.linalg.det(matrix), 1.0, atol=1e-9)
        step = (path.pose[1:].rotation * path.pose[:-1].rotation.inv()).magnitude()
        assert step.max() < 4.0 * STEP
        assert np.linalg.norm(np.diff(path.pose.translation, axis=0), axis=1).max() < 2.0 * STEP


def test_spout_and_rim_keep_their_distance_while_something_flows(small_plan, keypoints, paths, clock):
    """Each is interpolated by itself; what counts is the vector between them, here against its linear interpolation."""
    times, poses = keypoints
    task = small_plan.task
    bottle, cup = moved_object(small_plan, "pour_from"), moved_object(small_plan, "pour_into")
    spout, rim = acting_point(task, bottle), acting_point(task, cup)
    at_keypoints = poses["pour_from"].apply(spout) - poses["pour_into"].apply(rim)
    expected = np.stack([np.interp(clock, times, column) for column in at_keypoints.T], axis=-1)
    actual = paths["pour_from"].pose.apply(spout) - paths["pour_into"].pose.apply(rim)
    tilted = paths["pour_from"].pose.rotation.apply(bottle.model.up)[:, 2] < 0.5
    assert tilted.sum() > 50
    assert np.linalg.norm(actual - expected, axis=1)[tilted].max() < 0.004


def test_turning_points_are_reached(rolling_plan, problem_of, clock):
    """The strokes of the pin are as long as those of the keypoints; straight lines with round corners lose 20 mm."""
    (pin,) = rolling_plan.task.moved
    times = rolling_plan.task.model.keypoint_times
    poses = problem_of(rolling_plan).state(rolling_plan.solution.configurations).object_poses()[pin.role]
    path = object_path(rolling_plan.task, pin, times, poses, STEP * np.arange(round(times[-1] / STEP) + 1))
    reversals = [anchor.time for anchor in rolling_plan.task.model.anchors if anchor.kind == "reversal"]
    assert len(reversals) > 5
    at = np.searchsorted(times, np.array(reversals) - 1e-6)
    near = np.abs(path.model_time[:, None] - reversals).argmin(axis=0)
    assert np.abs(path.pose.translation[near, 1] - poses.translation[at, 1]).max() < 0.002
    assert path.pose.translation[:, 1].max() < poses.translation[:, 1].max() + 1e-3


def test_without_keypoints_in_between_it_goes_straight(small_plan, keypoints):
    """A motion shorter than the steps between keypoints."""
    times, poses = keypoints
    gap = int(np.argmax(np.diff(times)))
    third = (times[gap + 1] - times[gap]) / 3.0
    moved = replace(moved_object(small_plan, "pour_from"), lift=times[gap] + third, place=times[gap + 1] - third)
    clock = np.arange(times[gap] - 0.5, times[gap + 1] + 0.5, STEP)
    pose = object_path(small_plan.task, moved, times, poses["pour_from"], clock).pose
    assert np.isfinite(pose.as_matrix()).all()
    np.testing.assert_allclose(pose[0].as_matrix(), moved.start.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(pose[-1].as_matrix(), moved.put_down.as_matrix(), atol=1e-12)


def test_easing_starts_and_ends_softly():
    share = np.linspace(-0.5, 1.5, 2001)
    value = ease(share)
    assert (value[share <= 0.0] == 0.0).all()
    assert (value[share >= 1.0] == 1.0).all()
    assert (np.diff(value) >= 0.0).all()
    np.testing.assert_allclose(value + ease(1.0 - share), 1.0, atol=1e-12)
    first, second = np.gradient(value, share), np.gradient(np.gradient(value, share), share)
    ends = np.abs(share - np.array([[0.0], [1.0]])).argmin(axis=1)
    np.testing.assert_allclose(first[ends], 0.0, atol=1e-4)
    np.testing.assert_allclose(second[ends], 0.0, atol=0.1)
