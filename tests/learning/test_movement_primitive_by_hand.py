"""Movement primitives where the result is known."""

import numpy as np
import pytest
from scipy.interpolate import pchip_interpolate
from scipy.spatial.transform import Rotation

from sbam.learning.movement_primitive import SketchedPath, learn_primitive

TIME = np.linspace(1.0, 4.0, 151)


@pytest.mark.parametrize(("seconds", "count"), [(3.0, 21), (0.75, 6), (0.2, 4)])
def test_one_basis_function_every_0_15_s_and_four_at_least(seconds, count):
    time = np.linspace(2.0, 2.0 + seconds, 100)
    primitive = learn_primitive(time, [np.zeros((100, 2))] * 2, spread=0.1)
    assert (primitive.mean.shape, primitive.covariance.shape) == ((count, 2), (2, count, count))
    assert (primitive.start, primitive.end) == (2.0, pytest.approx(2.0 + seconds))


def test_equal_demonstrations_leave_the_spread_alone():
    path = np.stack([np.sin(TIME), TIME], axis=1)
    for count in (1, 3):
        primitive = learn_primitive(TIME, [path] * count, spread=0.1)
        np.testing.assert_allclose(primitive.covariance, np.broadcast_to(0.01 * np.eye(21), (2, 21, 21)), atol=1e-12)
    # The second channel is straight, however it runs: no weights.
    np.testing.assert_allclose(primitive.mean[:, 1], 0.0, atol=1e-9)


def test_two_demonstrations_spread_by_the_sample_covariance():
    """Opposite swings a and -a: mean 0, covariance 2 w w^T."""
    swing = np.sin(np.pi * (TIME - 1.0) / 3.0)[:, None]
    one = learn_primitive(TIME, [swing], spread=0.0)
    both = learn_primitive(TIME, [swing, -swing], spread=0.0)
    np.testing.assert_allclose(both.mean, 0.0, atol=1e-9)
    np.testing.assert_allclose(both.covariance[0], 2.0 * np.outer(one.mean[:, 0], one.mean[:, 0]), atol=1e-9)


def test_what_cannot_be_reached_is_interpolated():
    """Straight demonstrations without any spread: from first to last via-point, and the rest is a remainder."""
    primitive = learn_primitive(TIME, [TIME[:, None] * [1.0, -2.0]] * 3, spread=0.0)
    at = np.array([1.0, 2.0, 2.5, 4.0])
    via = np.array([[0.5, 1.0], [0.9, 1.0], [0.2, 0.0], [1.5, 2.0]])
    straight = via[0] + ((TIME - 1.0) / 3.0)[:, None] * (via[-1] - via[0])
    straight_via = via[0] + ((at - 1.0) / 3.0)[:, None] * (via[-1] - via[0])
    found = primitive.through(at, via, TIME)
    np.testing.assert_allclose(found, straight + pchip_interpolate(at, via - straight_via, TIME), atol=1e-9)


def test_a_via_point_moves_what_is_beside_it_and_not_what_is_far():
    """With independent weights a pull of 1 at 2.5 s is felt within some widths of the basis functions, 0.15 s."""
    primitive = learn_primitive(TIME, [np.zeros((151, 1))] * 2, spread=1.0)
    found = primitive.through(np.array([1.0, 2.5, 4.0]), np.array([[0.0], [1.0], [0.0]]), TIME)[:, 0]
    assert found[75] == pytest.approx(1.0)
    np.testing.assert_allclose(found, found[::-1], atol=1e-6)
    assert np.abs(found[TIME < 1.7]).max() < 0.01
    assert found[np.argmin(np.abs(TIME - 2.35))] == pytest.approx(0.7, abs=0.15)


def test_before_and_after_a_sketched_path_it_stands_still():
    position = np.linspace([0.0, 0.1, 0.2], [0.9, 0.1, -0.2], 10)
    rotation = np.linspace([0.0, 0.0, 0.0], [0.0, 0.0, 0.9], 10)
    path = SketchedPath("cup", position, rotation)
    found, turned = path.at(np.array([-1.0, 0.0, 0.5, 2.0, 9.0]), 2.0)
    shares = np.array([0.0, 0.0, 0.25, 1.0, 1.0])
    np.testing.assert_allclose(found, position[0] + shares[:, None] * (position[-1] - position[0]), atol=1e-12)
    np.testing.assert_allclose(turned.as_rotvec(), shares[:, None] * [0.0, 0.0, 0.9], atol=1e-12)
    assert isinstance(turned, Rotation)
