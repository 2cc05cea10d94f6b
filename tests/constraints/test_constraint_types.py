import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from sbam.constraints import CONSTRAINT_TYPES, SPATIAL_RELATIONS, ConstraintType, Cylindrical, constraint_type
from sbam.constraints.symbolic import VERTICAL
from sbam.errors import UnknownNameError

VARIANTS = [constraint.in_mode(mode) for constraint in CONSTRAINT_TYPES.values() for mode in ("default", "paper")]
both = pytest.mark.parametrize("constraint", VARIANTS, ids=lambda c: f"{c.name}-{c.mode}")

coordinate = st.floats(-0.6, 0.6).filter(lambda value: abs(value) > 1e-3)
vectors = st.tuples(coordinate, coordinate, coordinate).map(np.array)
angles = st.floats(-np.pi, np.pi)


def differences(function, d, step=1e-6):
    columns = [(function(d + e) - function(d - e)) / (2 * step) for e in step * np.eye(3)]
    return np.stack(columns, axis=-1)


def rotated(d, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * d[..., 0] - s * d[..., 1], s * d[..., 0] + c * d[..., 1], d[..., 2]], axis=-1)


def similarity(constraint: ConstraintType, d, target, weight, delta_rho=0.0):
    return np.sum(constraint.residual(d, target, weight, delta_rho) ** 2, axis=-1)


@both
@settings(max_examples=40, deadline=None)
@given(d=vectors)
def test_jacobian_agrees_with_finite_differences(constraint, d):
    expected = differences(constraint.channels, d)
    # A step across the azimuth's jump at +-pi tells nothing.
    if np.abs(expected).max() < 1e5:
        np.testing.assert_allclose(constraint.jacobian(d), expected, rtol=1e-4, atol=1e-4)


@both
@settings(max_examples=60, deadline=None)
@given(d=vectors, goal=vectors, std=st.floats(0, 0.3), delta=st.sampled_from([0.0, 0.001, 0.05]))
def test_residual_jacobian_agrees_with_finite_differences(constraint, d, goal, std, delta):
    target = constraint.channels(goal)
    weight = constraint.weights(np.full_like(target, std), target)
    opposite = abs(d[0] * goal[1] - d[1] * goal[0]) < 1e-4 and d[:2] @ goal[:2] < 0
    if constraint.mode == "paper" and opposite:
        return  # the kink of the paper's similarity
    expected = differences(lambda v: constraint.residual(v, target, weight, delta), d)
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(
        constraint.residual_jacobian(d, target, weight, delta), expected, rtol=1e-4, atol=1e-5 * scale
    )


@both
def test_residual_is_smooth_on_the_axis(constraint):
    d = np.array([0.0, 0.0, 0.1])
    target = constraint.channels(np.array([0.02, -0.01, 0.15]))
    weight = constraint.weights(np.full_like(target, 0.01), target)
    analytic = constraint.residual_jacobian(d, target, weight, 0.003)
    expected = differences(lambda v: constraint.residual(v, target, weight, 0.003), d, 1e-8)
    np.testing.assert_allclose(analytic, expected, rtol=1e-3, atol=1e-2)
    for delta in (0.0, 0.003):
        assert np.all(np.isfinite(constraint.residual(d, target, weight, delta)))
        assert np.all(np.isfinite(constraint.residual_jacobian(d, target, weight, delta)))
    assert np.all(np.isfinite(constraint.jacobian(d)))


@both
@settings(max_examples=30, deadline=None)
@given(d=vectors)
def test_similarity_is_zero_at_the_target_and_nowhere_negative(constraint, d):
    target = constraint.channels(d)
    weight = constraint.weights(np.full_like(target, 0.02), target)
    assert similarity(constraint, d, target, weight) == pytest.approx(0, abs=1e-18 * np.max(weight) ** 2)
    assert similarity(constraint, d + 0.01, target, weight) > 0


@both
def test_leading_axes_are_independent(constraint):
    rng = np.random.default_rng(1)
    d, goal = rng.normal(size=(2, 5, 4, 3)) * 0.2
    target = constraint.channels(goal)
    weight = constraint.weights(rng.uniform(0, 0.1, target.shape), target)
    residual = constraint.residual(d, target, weight, 1e-3)
    jacobian = constraint.residual_jacobian(d, target, weight, 1e-3)
    assert jacobian.shape == (*residual.shape, 3)
    for index in np.ndindex(5, 4):
        one = d[index], target[index], weight[index], 1e-3
        np.testing.assert_allclose(residual[index], constraint.residual(*one))
        np.testing.assert_allclose(jacobian[index], constraint.residual_jacobian(*one))


@pytest.mark.parametrize("mode", ["default", "paper"])
@settings(max_examples=50, deadline=None)
@given(d=vectors, goal=vectors, turn=angles)
def test_cylindrical_similarity_does_not_depend_on_where_azimuth_is_measured_from(mode, d, goal, turn):
    constraint = Cylindrical(mode=mode)
    std = np.array([0.01, 0.4, 0.02])

    def value(v, g):
        target = constraint.channels(g)
        return similarity(constraint, v, target, constraint.weights(std, target))

    assert value(rotated(d, turn), rotated(goal, turn)) == pytest.approx(value(d, goal), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("mode", ["default", "paper"])
def test_cylindrical_similarity_is_continuous_across_the_wrap(mode):
    constraint = Cylindrical(mode=mode)
    target = np.array([0.2, 3.0, 0.0])
    weight = constraint.weights(np.array([0.01, 0.3, 0.01]), target)
    # Both where the azimuth jumps (pi) and where the difference does (3.0 - pi).
    for azimuth in (np.pi, 3.0 - np.pi):
        before, after = (np.array([np.cos(a), np.sin(a), 0.0]) * 0.3 for a in (azimuth - 1e-9, azimuth + 1e-9))
        assert similarity(constraint, before, target, weight) == pytest.approx(
            similarity(constraint, after, target, weight), rel=1e-6
        )


@settings(max_examples=50, deadline=None)
@given(d=vectors, goal=vectors, std_phi=st.floats(0, 1))
def test_paper_cylindrical_similarity_is_the_papers_formula_where_nothing_wraps(d, goal, std_phi):
    constraint = Cylindrical(mode="paper")
    rho, phi, z = constraint.channels(d)
    target = constraint.channels(goal)
    if abs(phi - target[1]) > np.pi:
        return
    std = np.array([0.02, std_phi, 0.03])
    w_rho, w_phi, w_z = 1 / (1 + 20.0), 1 / (1 + std_phi), 1 / (1 + 30.0)  # std in mm
    first = np.array([w_rho * 1e3 * rho * np.cos(w_phi * phi), w_rho * 1e3 * rho * np.sin(w_phi * phi), w_z * 1e3 * z])
    second = np.array(
        [
            w_rho * 1e3 * target[0] * np.cos(w_phi * target[1]),
            w_rho * 1e3 * target[0] * np.sin(w_phi * target[1]),
            w_z * 1e3 * target[2],
        ]
    )
    expected = np.sum((first - second) ** 2)
    actual = similarity(constraint, d, target, constraint.weights(std, target))
    assert actual == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_default_cylindrical_azimuth_counts_as_a_length():
    constraint = Cylindrical()
    target = np.array([0.3, 0.5, 0.0])
    weight = constraint.weights(np.zeros(3), target)
    angle = 0.01
    d = np.array([0.3 * np.cos(0.5 + angle), 0.3 * np.sin(0.5 + angle), 0.0])
    assert similarity(constraint, d, target, weight) == pytest.approx((2 * np.sin(angle / 2) * 0.3 / 0.005) ** 2)
    assert constraint.weights(np.zeros(3), np.zeros(3))[1] == 0.0


@settings(max_examples=50, deadline=None)
@given(d=vectors)
def test_symbolic_channels_agree_with_scipy(d):
    rho, phi = np.hypot(d[0], d[1]), np.arctan2(d[1], d[0])
    expected = [
        stats.norm.logpdf(1e3 * rho, 1e3 * r.mean_rho, 1e3 * r.std_rho)
        + stats.vonmises.logpdf(phi, kappa=r.kappa_phi, loc=r.mean_phi)
        + stats.norm.logpdf(1e3 * d[2], 1e3 * r.mean_z, 1e3 * r.std_z)
        for r in SPATIAL_RELATIONS
    ]
    faded = max(r.kappa_phi for r in SPATIAL_RELATIONS) * (1.0 - rho / np.hypot(rho, VERTICAL))
    np.testing.assert_allclose(CONSTRAINT_TYPES["symbolic"].channels(d), expected, rtol=1e-9, atol=faded)


def test_symbolic_channels_are_continuous_where_the_azimuth_is_not():
    """Around the vertical they differ by less than a rounding of the vector is worth, and have no derivative there."""
    symbolic = CONSTRAINT_TYPES["symbolic"]
    vertical = np.array([0.0, 0.0, 0.2])
    for turn in np.linspace(0.0, 2.0 * np.pi, 7):
        beside = vertical + 1e-9 * np.array([np.cos(turn), np.sin(turn), 0.0])
        np.testing.assert_allclose(symbolic.channels(beside), symbolic.channels(vertical), atol=1e-4)
    north, south = (symbolic.channels(np.array([0.0, y, 0.2])) for y in (10 * VERTICAL, -10 * VERTICAL))
    assert (north - south)[symbolic.channel_names.index("behind")] == pytest.approx(10.0, rel=0.01)


def test_symbolic_relations_point_where_their_names_say():
    symbolic = CONSTRAINT_TYPES["symbolic"]
    places = {
        "above": (0, 0, 0.25),
        "below": (0, 0, -0.25),
        "right": (0.2, 0, 0),
        "left": (-0.2, 0, 0),
        "behind": (0, 0.2, 0),
        "in_front": (0, -0.2, 0),
        "far_away": (0.35, 0.35, 0),
    }
    values = symbolic.channels(np.array(list(places.values()), dtype=float))
    for column, name in enumerate(symbolic.channel_names):
        if name in places:
            assert np.argmax(values[:, column]) == list(places).index(name)


def test_weights():
    cartesian, symbolic = CONSTRAINT_TYPES["cartesian"], CONSTRAINT_TYPES["symbolic"]
    std = np.array([0.0, 0.012, 0.1])
    np.testing.assert_allclose(cartesian.weights(std, std), 1 / np.hypot(std, 0.005))
    # The paper's weights mean millimetres.
    np.testing.assert_allclose(cartesian.in_mode("paper").weights(std, std), 1e3 / (1 + 1e3 * std))
    np.testing.assert_allclose(symbolic.weights(std, std), 1 / np.hypot(std, 0.05))
    np.testing.assert_allclose(symbolic.in_mode("paper").weights(std, std), 1 / (1 + std))


def test_unknown_type_names_the_known_ones():
    with pytest.raises(UnknownNameError, match=r"cartesian.*cylindrical.*symbolic"):
        constraint_type("polar")


def test_the_spread_of_a_pair_counts_angles_as_arcs():
    mean, std = np.array([[0.3, 2.0, 0.1], [0.3, -9.0, 0.1]]), np.array([[0.01, 0.1, 0.02], [0.0, 0.1, 0.0]])
    expected = [np.linalg.norm([0.01, 0.03, 0.02]), 0.03]
    np.testing.assert_allclose(CONSTRAINT_TYPES["cylindrical"].spread(std, mean), expected, rtol=1e-9)
    np.testing.assert_allclose(CONSTRAINT_TYPES["cartesian"].spread(std, mean), np.linalg.norm(std, axis=1))


def test_an_azimuth_without_a_radius_spreads_nothing():
    mean, std = np.array([0.0, 1.0, 0.1]), np.array([0.0, 2.0, 0.01])
    assert CONSTRAINT_TYPES["cylindrical"].spread(std, mean) == pytest.approx(0.01)


def test_log_densities_have_a_spread_of_their_own():
    symbolic = CONSTRAINT_TYPES["symbolic"]
    assert (symbolic.spread_unit, symbolic.spread_floor) == ("log", symbolic.log_floor)
    assert symbolic.spread(np.full(8, 0.5), np.zeros(8)) == pytest.approx(np.sqrt(2.0))


@pytest.mark.parametrize(
    ("names", "units", "said"),
    [(("a",), ("deg",), "unknown unit 'deg'"), (("a", "b"), ("m",), "each of the channel_names")],
)
def test_units_that_nobody_knows_are_refused(names, units, said):
    with pytest.raises(TypeError, match=said):
        type("Odd", (ConstraintType,), {"channel_names": names, "channel_units": units})
