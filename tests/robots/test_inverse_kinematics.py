"""Inverse kinematics against forward kinematics of random postures."""

import numpy as np
import pytest

from sbam.planning.keypoints.state import Workspace
from sbam.robots import load_robot
from sbam.robots.inverse_kinematics import solve_poses

ARMS = ("left", "right")
COUNT = 150


@pytest.fixture(scope="module")
def targets(panda, within_limits):
    """Random postures near the limits too, and where they bring both hands."""
    q = within_limits(panda, np.random.default_rng(0), COUNT, share=1.0)
    return q, panda.kinematics(q, [panda.arms[arm].tcp_frame for arm in ARMS])


def errors(robot, arms, solution, position, rotation):
    """Position and angle errors by forward kinematics, apart from what the solver says of itself."""
    k = robot.kinematics(solution.configurations, [robot.arms[arm].tcp_frame for arm in arms])
    cosine = 0.5 * (np.einsum("bfij,bfij->bf", k.rotation, rotation) - 1.0)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)).max(axis=1)
    return np.linalg.norm(k.position - position, axis=-1).max(axis=1), angle


@pytest.mark.parametrize(("spread", "share"), [(0.1, 0.99), (0.3, 0.97), (1.0, 0.65)])
def test_both_hands_reach_where_they_can(panda, targets, spread, share):
    q, k = targets
    start = panda.clip(q + np.random.default_rng(1).normal(0, spread, q.shape))
    solution = solve_poses(panda, ARMS, k.position, k.rotation, start)
    reached = solution.reached()
    position_error, angle = errors(panda, ARMS, solution, k.position, k.rotation)
    assert reached.mean() >= share
    np.testing.assert_allclose(solution.position_error, position_error, atol=1e-9)
    np.testing.assert_allclose(solution.rotation_error[reached], angle[reached], atol=1e-6)
    assert (position_error[reached] < 1e-3).all()
    assert (angle[reached] < np.deg2rad(0.5)).all()
    assert (solution.configurations >= panda.lower).all()
    assert (solution.configurations <= panda.upper).all()


def test_one_hand_leaves_the_other_where_it_is(panda, targets):
    q, k = targets
    start = panda.clip(q + np.random.default_rng(2).normal(0, 0.3, q.shape))
    left = panda.arms["left"].joint_indices
    start[:, left] = panda.home[left]
    solution = solve_poses(panda, ["right"], k.position[:, 1:], k.rotation[:, 1:], start)
    assert solution.reached().mean() > 0.95
    np.testing.assert_array_equal(solution.configurations[:, left], start[:, left])


def test_the_order_of_the_arms_is_that_of_the_targets(panda, targets):
    q, k = targets
    some = slice(0, 5)
    swapped = solve_poses(panda, ("right", "left"), k.position[some, ::-1], k.rotation[some, ::-1], q[some])
    assert swapped.reached().all()
    np.testing.assert_allclose(swapped.configurations, q[some], atol=1e-6)


def test_a_batch_is_solved_as_its_members(panda, targets):
    q, k = targets
    start = panda.clip(q + np.random.default_rng(3).normal(0, 0.5, q.shape))
    together = solve_poses(panda, ARMS, k.position[:20], k.rotation[:20], start[:20])
    for i in range(20):
        alone = solve_poses(panda, ARMS, k.position[[i]], k.rotation[[i]], start[i])
        np.testing.assert_allclose(alone.configurations[0], together.configurations[i], atol=1e-9)


def test_what_is_out_of_reach_is_said_and_limits_are_kept(panda):
    """A target 3 m ahead: stretched arms come as near as they can, but it is not reached."""
    position = np.array([[[0.0, 3.0, 0.5]], [[-0.3, 0.5, 0.4]]])
    rotation = np.tile(np.diag([1.0, -1.0, -1.0]), (2, 1, 1, 1))
    solution = solve_poses(panda, ["left"], position, rotation, panda.home)
    np.testing.assert_array_equal(solution.reached(), [False, True])
    assert 1.5 < solution.position_error[0] < 3.0
    assert np.isfinite(solution.configurations).all()
    assert (solution.configurations >= panda.lower).all()
    assert (solution.configurations <= panda.upper).all()


def test_redundancy_settles_as_near_to_the_reference_as_it_can(panda, targets):
    """Nearer than the posture it starts from; hardly any motion within the null space would bring it nearer."""
    q, k = targets
    reference = panda.clip(q + np.random.default_rng(4).normal(0, 0.3, q.shape))
    solution = solve_poses(panda, ARMS, k.position, k.rotation, q, reference)
    found = solution.configurations
    assert solution.reached(2e-4, 1e-3).all()
    before, after = np.linalg.norm(q - reference, axis=1), np.linalg.norm(found - reference, axis=1)
    assert (after <= before + 1e-6).mean() > 0.95
    state = Workspace(panda, (), ()).state(found)
    columns = np.arange(2)
    jacobian = np.concatenate(
        [state.point_jacobian(state.kinematics.position, columns), state.angular_jacobian(columns)], axis=-2
    ).reshape(COUNT, 12, -1)
    inside = ((found > panda.lower + 1e-6) & (found < panda.upper - 1e-6)).all(axis=1)
    assert inside.sum() > COUNT // 2
    ways = []
    for i in np.flatnonzero(inside):
        null_space = np.linalg.svd(jacobian[i])[2][12:]
        ways.append(np.linalg.norm(null_space @ (found[i] - reference[i])))
    assert np.median(ways) < 0.02 * np.median(after)
    assert np.mean(np.array(ways) < 0.2 * np.median(after)) > 0.9


def test_targets_are_in_the_frame_in_which_the_robot_stands(targets):
    """A robot that was moved with its targets finds the same configurations."""
    from scipy.spatial.transform import RigidTransform, Rotation

    q, _ = targets
    moved = load_robot("panda_dual").placed_for(
        RigidTransform.from_components([1.0, -2.0, 0.7], Rotation.from_euler("z", 2.0))
    )
    k = moved.kinematics(q[:10], [moved.arms[arm].tcp_frame for arm in ARMS])
    solution = solve_poses(moved, ARMS, k.position, k.rotation, q[:10])
    np.testing.assert_allclose(solution.configurations, q[:10], atol=1e-6)
