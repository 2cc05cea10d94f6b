import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sbam.learning.anchors import warp

steps = st.lists(st.floats(0.05, 3.0), min_size=2, max_size=8)


@given(steps, st.data())
def test_there_and_back(own_steps, data):
    model_steps = data.draw(st.lists(st.floats(0.05, 3.0), min_size=len(own_steps), max_size=len(own_steps)))
    own, model = np.r_[0.0, np.cumsum(own_steps)], np.r_[0.0, np.cumsum(model_steps)]
    time = np.linspace(0, own[-1], 50)
    there = warp(time, own, model)
    assert np.all(np.diff(there) > 0)
    np.testing.assert_allclose(warp(there, model, own), time, atol=1e-9)
    np.testing.assert_allclose(warp(own, own, model), model, atol=1e-12)


def test_between_anchors_it_is_linear_and_outside_it_is_clamped():
    np.testing.assert_allclose(
        warp(np.array([-1.0, 0.5, 1.5, 9.0]), np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 6.0])),
        [0.0, 1.0, 4.0, 6.0],
    )


@pytest.mark.parametrize(
    ("own", "model"),
    [([0, 1], [0, 1, 2]), ([0], [0]), ([0, 1, 1], [0, 1, 2]), ([0, 1, 2], [0, 2, 1]), ([0, np.nan, 2], [0, 1, 2])],
)
def test_anchors_that_do_not_correspond_are_refused(own, model):
    with pytest.raises(ValueError, match="anchor times"):
        warp(np.zeros(1), np.array(own, dtype=float), np.array(model, dtype=float))
