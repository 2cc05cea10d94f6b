import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.demonstrations.synthetic.motion import (
    PEAK_SPEED_RATIO,
    UP,
    SubMovement,
    about,
    between,
    lean,
    minimum_jerk,
    put_back,
    reach,
    sample_times,
    standing_still,
    superpose,
    upright,
    wander,
)

TIME = np.linspace(0.0, 4.0, 4001)
onsets = st.floats(0.2, 1.5)
durations = st.floats(0.2, 2.0)
vectors = st.tuples(*[st.floats(-0.5, 0.5)] * 3).map(np.array)


@given(onsets, durations)
def test_minimum_jerk_is_at_rest_outside_and_bell_shaped_inside(onset, duration):
    course = minimum_jerk(TIME, onset, duration)
    assert np.all(course[onset >= TIME] == 0.0)
    assert np.allclose(course[onset + duration <= TIME], 1.0, rtol=0, atol=1e-12)
    speed = np.gradient(course, TIME)
    assert speed.min() > -1e-9
    assert speed.max() == pytest.approx(PEAK_SPEED_RATIO / duration, rel=0.01)
    assert TIME[speed.argmax()] == pytest.approx(onset + duration / 2, abs=0.01)


def test_minimum_jerk_is_the_polynomial_with_rest_at_both_ends():
    # The minimum-jerk course solves d^6 x / dt^6 = 0: it is the polynomial of degree 5 with rest at both ends.
    phase = np.linspace(0.0, 1.0, 50)
    fitted = np.polynomial.Polynomial.fit(phase, minimum_jerk(phase, 0.0, 1.0), 5).convert()
    for order, at_ends in ((0, (0.0, 1.0)), (1, (0.0, 0.0)), (2, (0.0, 0.0))):
        derivative = fitted.deriv(order) if order else fitted
        assert np.allclose(derivative(np.array([0.0, 1.0])), at_ends, atol=1e-9)


def test_between_rises_and_falls():
    envelope = between(TIME, (0.5, 0.5), (2.0, 1.0))
    assert envelope[TIME <= 0.5].max() == 0.0
    assert np.allclose(envelope[(TIME >= 1.0) & (TIME <= 2.0)], 1.0)
    assert np.allclose(envelope[TIME >= 3.0], 0.0)


@given(vectors, vectors, onsets, durations, vectors)
def test_reach_arrives_and_rests(start, displacement, onset, duration, detour):
    movements = reach(
        np.random.default_rng(0),
        onset,
        duration,
        displacement,
        horizontal=(0.1, 0.9),
        vertical=(0.2, 1.0),
        detour=detour,
    )
    path = superpose(TIME, start, movements)
    assert np.allclose(path[onset >= TIME], start)
    assert np.allclose(path[onset + duration + 1e-9 <= TIME], start + displacement)


def test_reach_departs_by_the_detour():
    path = superpose(TIME, np.zeros(3), reach(np.random.default_rng(0), 0.5, 2.0, (0.4, 0, 0), detour=(0.0, -0.1, 0.0)))
    assert path[:, 1].min() == pytest.approx(-0.1, abs=0.035)


def test_overlapping_movements_add():
    movements = [SubMovement(0.5, 1.0, np.array([1.0, 0, 0])), SubMovement(0.8, 1.0, np.array([0, 2.0, 0]))]
    path = superpose(TIME, np.array([0.0, 0.0, 3.0]), movements)
    alone = [superpose(TIME, np.zeros(3), [movement]) for movement in movements]
    assert np.allclose(path - (0.0, 0.0, 3.0), sum(alone))


def test_wander_keeps_to_its_band_and_size():
    time = np.arange(0.0, 60.0, 0.01)
    noise = wander(np.random.default_rng(1), time, 0.002, (6.0, 11.0))
    assert noise.std(axis=0) == pytest.approx(0.002, rel=0.1)
    power = np.abs(np.fft.rfft(noise * np.hanning(len(time))[:, None], axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(time), 0.01)
    inside = (frequency > 5.9) & (frequency < 11.1)
    assert power[inside].sum() > 0.999 * power.sum()


@given(vectors.filter(lambda v: np.linalg.norm(v) > 0.05), st.floats(-3.0, 3.0))
def test_upright_points_up(up, yaw):
    up = up / np.linalg.norm(up)
    assert upright(up, yaw).apply(up) == pytest.approx(UP, abs=1e-9)


@pytest.mark.parametrize("up", [(0, 0, 1.0), (0, 0, -1.0)])
def test_upright_when_already_along_the_vertical(up):
    assert upright(np.array(up)).apply(up) == pytest.approx(UP)


@given(st.floats(-3.0, 3.0), st.floats(0.01, 1.5))
def test_lean_moves_the_top_towards_the_direction(direction, angle):
    top = Rotation.from_rotvec(lean(direction, angle)).apply(UP)
    assert np.arccos(top[2]) == pytest.approx(angle, abs=1e-6)
    assert top[:2] == pytest.approx(np.sin(angle) * np.array([np.cos(direction), np.sin(direction)]), abs=1e-9)


def test_about_an_axis():
    assert about("z", np.array([0.0, np.pi / 2])).apply([1.0, 0, 0]) == pytest.approx(
        np.array([[1.0, 0, 0], [0, 1.0, 0]]), abs=1e-12
    )


def test_things_are_put_back_near_and_at_the_same_height():
    rng = np.random.default_rng(0)
    places = np.array([put_back(rng, np.array([0.1, 0.2, 0.3])) for _ in range(500)])
    assert np.all(places[:, 2] == 0.3)
    assert 0.011 < places[:, 0].std() < 0.015
    assert np.abs(places - (0.1, 0.2, 0.3)).max() <= 0.03


def test_sample_times_and_standing_still():
    time = sample_times(1.234)
    assert time[0] == 0 and time[-1] == pytest.approx(1.23) and np.allclose(np.diff(time), 0.01)
    pose = RigidTransform.from_components([1.0, 2, 3], Rotation.from_rotvec([0.1, 0.2, 0.3]))
    poses = standing_still(pose, 5)
    assert len(poses) == 5
    assert np.allclose(poses.as_matrix(), pose.as_matrix())
