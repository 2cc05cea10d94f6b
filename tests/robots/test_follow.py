"""Configurations that follow a dense path of one hand."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import UnreachableError
from sbam.robots.follow import POSITION_TOLERANCE, ROTATION_TOLERANCE, follow

DOWNWARDS = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


def straight(start, end, count: int) -> RigidTransform:
    points = np.linspace(start, end, count)
    return RigidTransform.from_components(points, Rotation.concatenate([DOWNWARDS] * count))


def off(robot, hand, q, tcp) -> tuple[float, float]:
    k = robot.kinematics(q, [robot.arms[hand].tcp_frame])
    turn = Rotation.from_matrix(k.rotation[:, 0]) * tcp.rotation.inv()
    return float(np.linalg.norm(k.position[:, 0] - tcp.translation, axis=1).max()), float(turn.magnitude().max())


@pytest.mark.parametrize("hand", ["left", "right"])
def test_a_straight_line_is_followed_smoothly(panda, hand):
    side = -1.0 if hand == "left" else 1.0
    tcp = straight([side * 0.4, 0.45, 0.2], [side * 0.1, 0.6, 0.35], 60)
    reference = np.tile(panda.home, (60, 1))
    q = follow(panda, hand, tcp, reference, "in a line")
    position, angle = off(panda, hand, q, tcp)
    assert position < POSITION_TOLERANCE
    assert angle < ROTATION_TOLERANCE
    assert np.abs(np.diff(q, axis=0)).max() < 0.1
    assert np.abs(np.diff(q, n=2, axis=0)).max() < 0.02
    other = panda.arms["right" if hand == "left" else "left"].joint_indices
    np.testing.assert_allclose(q[:, other], reference[:, other])


def test_neighbours_help_where_the_reference_misleads(panda):
    """Half of the references point at nothing useful; solved neighbours take over."""
    tcp = straight([-0.4, 0.45, 0.2], [-0.1, 0.6, 0.35], 40)
    good = follow(panda, "left", tcp, np.tile(panda.home, (40, 1)), "in a line")
    reference = good.copy()
    reference[20:] = panda.clip(-good[20:])
    q = follow(panda, "left", tcp, reference, "in a line")
    assert off(panda, "left", q, tcp)[0] < POSITION_TOLERANCE


def test_what_cannot_be_followed_is_named(panda):
    tcp = straight([-0.4, 0.45, 0.2], [-0.4, 1.6, 0.2], 24)
    clock = np.linspace(2.0, 4.3, 24)
    with pytest.raises(UnreachableError, match=r"panda_dual's left hand cannot follow its path to the sky at 4\.30 s"):
        follow(panda, "left", tcp, np.tile(panda.home, (24, 1)), "to the sky", clock)
