"""Interpolation of rigid motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.resampling import interpolate_poses, resample
from sbam.errors import DemonstrationError

TIME = np.array([0.0, 0.5, 0.7, 2.0])
POSES = RigidTransform.from_components(
    [[0, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, -3]],
    Rotation.from_euler("z", [[170.0], [190.0], [250.0], [250.0]], degrees=True),
)


def test_positions_linearly_rotations_the_short_way_at_even_speed():
    found = interpolate_poses(TIME, POSES, np.array([0.125, 0.6, 1.35]))
    np.testing.assert_allclose(found.translation, [[0.25, 0, 0], [1, 1, 0], [1, 2, -1.5]])
    np.testing.assert_allclose(np.degrees(found.rotation.as_euler("zyx")[:, 0]) % 360, [175, 220, 250])


def test_ends_are_held_and_same_times_change_nothing():
    found = interpolate_poses(TIME, POSES, np.array([-1.0, 3.0]))
    np.testing.assert_allclose(found.as_matrix(), POSES.as_matrix()[[0, 3]], atol=1e-12)
    assert interpolate_poses(TIME, POSES, TIME.copy()) is POSES
    single = interpolate_poses(TIME[:1], POSES[:1], TIME)
    np.testing.assert_allclose(single.as_matrix(), POSES.as_matrix()[[0, 0, 0, 0]], atol=1e-12)


@settings(deadline=None)
@given(st.floats(1.0, 500.0))
def test_resampled_at_an_even_rate(rate):
    old = Demonstration("d", TIME, {"cup": POSES}, {"left": POSES}, RigidTransform.identity(), notes=("n",))
    new = resample(old, rate)
    np.testing.assert_allclose(np.diff(new.time), 1 / rate, rtol=1e-6)
    assert new.time[0] == 0 and 2.0 - 1 / rate < new.time[-1] + 1e-9 and new.time[-1] <= 2.0 + 1e-9
    expected = [np.interp(new.time, TIME, axis) for axis in POSES.translation.T]
    np.testing.assert_allclose(new.T_world_object["cup"].translation, np.transpose(expected), atol=1e-12)
    assert len(new.T_world_hand["left"]) == len(new.time)
    assert new.notes == old.notes


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf, 0.4])
def test_senseless_rates(rate):
    old = Demonstration("d", TIME, {"cup": POSES}, {}, RigidTransform.identity())
    with pytest.raises(DemonstrationError, match="Hz"):
        resample(old, rate)
