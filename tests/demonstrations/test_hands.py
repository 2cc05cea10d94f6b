"""Hand poses from markers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.hands import HAND_MARKERS, fit_hand

SHAPE = {"little_knuckle": (-0.04, 0), "thumb_knuckle": (0.04, 0), "little_wrist": (-0.03, -0.07)}
SHAPE |= {"thumb_wrist": (0.03, -0.07)}


def moving_hand(seed: int, frames: int = 30) -> RigidTransform:
    rng = np.random.default_rng(seed)
    phase = np.linspace(0, 1, frames)
    rotation = Rotation.from_rotvec(np.outer(phase, rng.uniform(-2, 2, 3))) * Rotation.from_quat(rng.normal(size=4))
    return RigidTransform.from_components(np.outer(phase, rng.uniform(-1, 1, 3)), rotation)


def markers_on(T_world_hand: RigidTransform, hand, bend: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Markers of a hand that lies palm down with the fingers forward in its frame; the wrist bends by ``bend`` rad."""
    side = 1 if hand == "left" else -1
    markers = {}
    for name, (x, y) in SHAPE.items():
        point = np.tile([side * x, y, 0.0], (len(T_world_hand), 1))
        if bend is not None and "wrist" in name:
            # The joint lies between the wrist markers: bending up and down turns them about the line through it.
            joint = np.array([0.0, -0.07, 0.0])
            point = joint + Rotation.from_euler("x", bend[:, None]).apply(point - joint)
        markers[getattr(HAND_MARKERS[hand], name)] = T_world_hand.apply(point)
    return markers


@pytest.mark.parametrize("hand", ["left", "right"])
@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6))
def test_the_frame_is_found(hand, seed):
    truth = moving_hand(seed)
    position, xyzw = fit_hand(markers_on(truth, hand), hand)
    np.testing.assert_allclose(position, truth.translation, atol=1e-9)
    assert (Rotation.from_quat(xyzw) * truth.rotation.inv()).magnitude().max() < 1e-7


def test_bending_the_wrist_leaves_the_frame_in_the_palm():
    truth = moving_hand(3)
    position, xyzw = fit_hand(markers_on(truth, "left", np.linspace(-0.8, 0.8, 30)), "left")
    np.testing.assert_allclose(position, truth.translation, atol=1e-9)
    assert (Rotation.from_quat(xyzw) * truth.rotation.inv()).magnitude().max() < 1e-7


def test_noise_of_a_millimetre():
    truth = moving_hand(5, 200)
    rng = np.random.default_rng(0)
    markers = {n: p + rng.normal(scale=1e-3, size=p.shape) for n, p in markers_on(truth, "right").items()}
    position, xyzw = fit_hand(markers, "right")
    assert np.linalg.norm(position - truth.translation, axis=1).max() < 0.004
    assert np.degrees((Rotation.from_quat(xyzw) * truth.rotation.inv()).magnitude().max()) < 5


def test_missing_and_mistaken_markers_give_no_pose():
    truth = moving_hand(7)
    markers = markers_on(truth, "left")
    markers["LHPS"][4] = np.nan
    markers["LHTS"][9] += 0.2
    position, xyzw = fit_hand(markers, "left")
    lost = np.isnan(position).any(axis=1)
    assert list(np.flatnonzero(lost)) == [4, 9]
    assert np.isnan(xyzw[lost]).all() and np.isfinite(xyzw[~lost]).all()


def test_no_marker_ever_seen():
    markers = {name: np.full((5, 3), np.nan) for name in HAND_MARKERS["left"]}
    position, xyzw = fit_hand(markers, "left")
    assert np.isnan(position).all() and np.isnan(xyzw).all()
