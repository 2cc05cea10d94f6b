"""A hand's poses are followed from the hardest moment to both ends, and it is said where that breaks."""

import numpy as np
import pytest

from sbam.planning.grasping.follow_outwards import MOST_AT_ONCE, follow_outwards, solve_hand

MOMENTS, HARDEST = 7, 3


@pytest.fixture(scope="module")
def paths(panda):
    """Poses (2, M) of the right hand on smooth joint paths (2, M, n) around home."""
    arm = panda.arms["right"]
    configurations = np.tile(panda.clip(panda.home), (2, MOMENTS, 1))
    swing = np.linspace(-0.3, 0.3, MOMENTS)
    for path, sign in zip(configurations, (1.0, -1.0), strict=True):
        path[:, arm.joint_indices[:4]] += sign * swing[:, None] * np.array([1.0, 0.5, -0.5, 0.3])
    flat = panda.kinematics(configurations.reshape(2 * MOMENTS, -1), [arm.tcp_frame])
    return (
        configurations,
        flat.position[:, 0].reshape(2, MOMENTS, 3),
        flat.rotation[:, 0].reshape(2, MOMENTS, 3, 3),
    )


def test_what_can_be_followed_is_followed_to_both_ends(panda, paths):
    configurations, position, rotation = paths
    found = follow_outwards(panda, "right", position, rotation, configurations[:, HARDEST], HARDEST)
    assert found.broken_at.tolist() == [-1, -1]
    assert found.miss.max() < 1e-3
    reached = panda.kinematics(found.configurations.reshape(2 * MOMENTS, -1), [panda.arms["right"].tcp_frame])
    np.testing.assert_allclose(reached.position[:, 0], position.reshape(-1, 3), atol=1e-3)


@pytest.mark.parametrize("give_up", [True, False])
def test_a_path_breaks_where_a_pose_is_out_of_reach(panda, paths, give_up):
    configurations, position, rotation = paths
    far = position.copy()
    far[0, HARDEST + 2] += [0.0, 3.0, 0.0]
    found = follow_outwards(panda, "right", far, rotation, configurations[:, HARDEST], HARDEST, give_up=give_up)
    assert found.broken_at.tolist() == [HARDEST + 2, -1]
    assert found.miss[0, HARDEST + 2] > 1.0
    assert np.isinf(found.miss[0, HARDEST + 3]) == give_up
    assert found.miss[1].max() < 1e-3
    assert found.miss[0, HARDEST - 2 : HARDEST + 2].max() < 1e-3


def test_another_branch_of_the_arm_is_no_way_on(panda, paths):
    configurations, position, rotation = paths
    turned = rotation.copy()
    turned[0, HARDEST + 1] = rotation[0, HARDEST + 1] @ np.diag([-1.0, -1.0, 1.0])  # half a turn of the hand
    found = follow_outwards(panda, "right", position, turned, configurations[:, HARDEST], HARDEST)
    assert found.broken_at.tolist() == [HARDEST + 1, -1]


def test_batches_change_nothing(panda, paths):
    configurations, position, rotation = paths
    times = -(-(MOST_AT_ONCE + 10) // MOMENTS)
    many = solve_hand(
        panda,
        "right",
        np.tile(position[0], (times, 1)),
        np.tile(rotation[0], (times, 1, 1)),
        np.tile(configurations[0], (times, 1)),
        iterations=3,
    )
    one = solve_hand(panda, "right", position[0], rotation[0], configurations[0], iterations=3)
    np.testing.assert_allclose(many.configurations[-MOMENTS:], one.configurations, atol=1e-9)
    assert len(solve_hand(panda, "right", position[0][:0], rotation[0][:0], configurations[0][:0]).position_error) == 0
