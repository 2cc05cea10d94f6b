"""Rotation errors and their derivative against scipy, also where logarithms are delicate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sbam.robots.rotation_error import left_jacobian_inverse, rotation_error

ANGLES = (0.0, 1e-12, 1e-7, 0.99e-4, 1.01e-4, 1e-2, 1.0, 3.0, np.pi - 1e-3, np.pi - 1e-5)
UNIT = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)


def unit(vector) -> np.ndarray:
    return np.asarray(vector) / np.linalg.norm(vector)


@given(UNIT, st.sampled_from(ANGLES), UNIT)
def test_error_turns_the_target_into_the_rotation(axis, angle, other):
    target = Rotation.from_rotvec(2.0 * unit(other))
    turned = Rotation.from_rotvec(angle * unit(axis)) * target
    error = rotation_error(turned.as_matrix(), target.as_matrix())
    np.testing.assert_allclose(error, angle * unit(axis), atol=1e-8)


def test_half_a_turn_has_either_sign():
    error = rotation_error(Rotation.from_rotvec([0.0, np.pi, 0.0]).as_matrix(), np.eye(3))
    np.testing.assert_allclose(np.abs(error), [0.0, np.pi, 0.0], atol=1e-12)


def test_any_batch():
    rotations = Rotation.random(24, rng=1)
    targets = Rotation.random(24, rng=2)
    shape = (2, 3, 4, 3, 3)
    error = rotation_error(rotations.as_matrix().reshape(shape), targets.as_matrix().reshape(shape))
    assert error.shape == shape[:-1]
    np.testing.assert_allclose(error.reshape(-1, 3), (rotations * targets.inv()).as_rotvec(), atol=1e-12)


@pytest.mark.parametrize("angle", [*ANGLES, np.pi, 4.0, 6.0])
@given(axis=UNIT)
def test_left_jacobian_inverse_is_that_of_differences(angle, axis):
    """log(Exp(h) Exp(v)) by h; beyond half a turn the nearest representative of the logarithm is meant."""
    vector, step = angle * unit(axis), 1e-6
    rotation = Rotation.from_rotvec(vector)

    def logarithm(displacement):
        found = (Rotation.from_rotvec(displacement) * rotation).as_rotvec()
        length = np.linalg.norm(found)
        if np.linalg.norm(found - vector) > 1.0:  # the other representative: 2 pi further along the axis
            found = found * (1.0 - 2.0 * np.pi / length)
        return found

    slopes = [(logarithm(step * e) - logarithm(-step * e)) / (2.0 * step) for e in np.eye(3)]
    scale = max(1.0, 2.0 / abs(2.0 * np.pi - angle))
    np.testing.assert_allclose(left_jacobian_inverse(vector), np.stack(slopes, axis=-1), atol=1e-8 * scale)


def test_left_jacobian_inverse_of_nothing_is_the_identity():
    np.testing.assert_array_equal(left_jacobian_inverse(np.zeros((4, 2, 3))), np.broadcast_to(np.eye(3), (4, 2, 3, 3)))
