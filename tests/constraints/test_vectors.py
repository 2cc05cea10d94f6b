"""Vectors from channels, densities of any relation, and what region pairs say of themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from sbam.constraints import CONSTRAINT_TYPES, Cylindrical, RegionPair, RegionReference, SpatialRelation, Symbolic
from sbam.constraints.base import smooth_radius, wrap
from sbam.constraints.symbolic import _linear_form

coordinate = st.floats(-0.6, 0.6).filter(lambda value: abs(value) > 1e-2)
vectors = st.tuples(coordinate, coordinate, coordinate).map(np.array)
lengths = st.floats(-0.5, 0.5)
spreads = st.floats(0.05, 0.4)


@pytest.mark.parametrize("name", list(CONSTRAINT_TYPES))
@settings(max_examples=40, deadline=None)
@given(d=vectors)
def test_the_vector_of_a_vector_s_channels_is_the_vector(name, d):
    constraint = CONSTRAINT_TYPES[name]
    np.testing.assert_allclose(constraint.vector(constraint.channels(d)), d, atol=1e-6)
    several = np.stack([[d, -d], [0.5 * d, 2.0 * d]])
    np.testing.assert_allclose(constraint.vector(constraint.channels(several)), several, atol=1e-6)


def test_vectors_by_hand():
    cylindrical = Cylindrical().vector(np.array([[0.2, 0.5 * np.pi, 0.1], [0.5, np.arctan2(-3.0, -4.0), -0.3]]))
    np.testing.assert_allclose(cylindrical, [[0.0, 0.2, 0.1], [-0.4, -0.3, -0.3]], atol=1e-15)
    # The log-densities of a vector 25 cm behind, changed by what none of the relations can say (all alike).
    behind = Symbolic().channels(np.array([0.0, 0.25, -0.1]))
    np.testing.assert_allclose(Symbolic().vector(behind), [0.0, 0.25, -0.1], atol=1e-6)


def test_a_radius_below_zero_is_none():
    """Where log-densities contradict, least squares may ask for one."""
    target = Symbolic().channels(np.array([0.0, 0.0, 0.1]))
    target[Symbolic.channel_names.index("far_away")] -= 5.0
    found = Symbolic().vector(target)
    np.testing.assert_allclose(found[:2], 0.0, atol=1e-9)
    assert found[2] == pytest.approx(0.1, abs=0.02)


@settings(max_examples=50, deadline=None)
@given(
    d=vectors,
    mean_rho=st.floats(0.0, 0.5),
    mean_phi=st.floats(-3.0, 3.0),
    mean_z=lengths,
    std_rho=spreads,
    std_z=spreads,
    kappa=st.floats(1e-5, 30.0),
)
def test_log_densities_of_any_relation_are_those_of_scipy(d, mean_rho, mean_phi, mean_z, std_rho, std_z, kappa):
    relation = SpatialRelation("any", mean_rho, std_rho, mean_phi, kappa, mean_z, std_z)
    matrix, offset = _linear_form((relation, relation))
    assert (matrix.shape, offset.shape) == ((6, 2), (2,))
    rho, phi = np.hypot(d[0], d[1]), np.arctan2(d[1], d[0])
    features = np.array([rho**2, rho, np.cos(phi), np.sin(phi), d[2] ** 2, d[2]])
    expected = (
        stats.norm.logpdf(1e3 * rho, 1e3 * mean_rho, 1e3 * std_rho)
        + stats.vonmises.logpdf(phi, kappa=kappa, loc=mean_phi)
        + stats.norm.logpdf(1e3 * d[2], 1e3 * mean_z, 1e3 * std_z)
    )
    np.testing.assert_allclose(features @ matrix + offset, [expected, expected], rtol=1e-9, atol=1e-9)


def test_the_smooth_radius_by_hand():
    """rho 0.3 and delta 0.4: D = 0.5, radius 0.09 / 0.5, slope (0.09 + 2 0.16) / 0.125 times (x, y)."""
    radius, slope, denominator = smooth_radius(np.array([0.18, 0.24, 7.0]), 0.4)
    assert (radius, denominator) == (pytest.approx(0.18), pytest.approx(0.5))
    np.testing.assert_allclose(slope, 3.28 * np.array([0.18, 0.24]))
    exact = smooth_radius(np.array([0.18, 0.24, 7.0]), 0.0)
    assert (exact[0], exact[2]) == (pytest.approx(0.3), pytest.approx(0.3))
    np.testing.assert_allclose(exact[1], [0.6, 0.8])
    # On the axis itself there is no slope, and nothing is divided by zero.
    axis = smooth_radius(np.zeros(3), 0.0)
    assert (axis[0], axis[1].tolist(), axis[2]) == (0.0, [0.0, 0.0], pytest.approx(1e-12))


def test_angles_are_wrapped():
    np.testing.assert_allclose(wrap(np.array([0.0, 4.0, -4.0, 7.0])), [0, 4 - 2 * np.pi, 2 * np.pi - 4, 7 - 2 * np.pi])
    assert wrap(np.array(np.pi)) == -np.pi


def test_weights_of_the_cylinder_by_hand():
    """Arcs of 0.3 rad at 10 cm, 30 mm, with the floor of 40 mm: 10 cm / 50 mm. The radius may be given negative."""
    cylindrical = Cylindrical(length_floor=0.04)
    for rho in (0.1, -0.1):
        weight = cylindrical.weights(np.array([0.03, 0.3, 0.0]), np.array([rho, 1.0, 2.0]))
        np.testing.assert_allclose(weight, [20.0, 2.0, 25.0])
    paper = Cylindrical(mode="paper").weights(np.array([0.003, 3.0, 0.0]), np.array([0.1, 1.0, 2.0]))
    np.testing.assert_allclose(paper, [250.0, 0.25, 1000.0])


SPOUT, FOOT = RegionReference("bottle", "pour from"), RegionReference("bottle", "place")
CUP = RegionReference("cup", "pour into")


def test_what_pairs_say_of_themselves():
    assert str(RegionPair(SPOUT, CUP)) == "pour from of bottle -> pour into of cup"
    assert str(RegionPair(SPOUT, None)) == "pour from of bottle -> own start"
    kinds = {
        pair: (pair.is_own_start, pair.is_same_object, pair.roles)
        for pair in map(RegionPair, *zip((SPOUT, CUP), (SPOUT, FOOT), (SPOUT, None), strict=True))
    }
    assert kinds == {
        RegionPair(SPOUT, CUP): (False, False, ("bottle", "cup")),
        RegionPair(SPOUT, FOOT): (False, True, ("bottle",)),
        RegionPair(SPOUT, None): (True, False, ("bottle",)),
    }


@pytest.mark.parametrize("name", list(CONSTRAINT_TYPES))
def test_another_mode_changes_nothing_else(name):
    constraint = type(CONSTRAINT_TYPES[name])(length_floor=0.02, log_floor=0.3)
    paper = constraint.in_mode("paper")
    assert (paper.mode, paper.length_floor, paper.log_floor) == ("paper", 0.02, 0.3)
    assert paper.in_mode("default") == constraint


def test_the_smoothed_azimuth_by_hand():
    """At 0.3, 0.4 m with delta 1.2 m, D is 1.3: 5 cos falls from 3 to 1.5 / 1.3 and rho from 0.5 to 0.25 / 1.3."""
    symbolic, d = Symbolic(mode="paper"), np.array([0.3, 0.4, 0.1])
    moved = symbolic.residual(d, symbolic.channels(d), np.ones(8), delta_rho=1.2)
    expected = np.zeros(8)
    expected[4:] = 5.0 * (1.0 / 1.3 - 1.0 / 0.5) * np.array([-0.4, 0.4, -0.3, 0.3])
    expected[Symbolic.channel_names.index("far_away")] = (0.25 / 1.3 - 0.5) * 0.5 / 0.1**2
    np.testing.assert_allclose(moved, expected, atol=1e-4)


@pytest.mark.parametrize("mode", ["default", "paper"])
@pytest.mark.parametrize("name", list(CONSTRAINT_TYPES))
def test_one_target_and_weight_for_many_vectors(name, mode):
    constraint = CONSTRAINT_TYPES[name].in_mode(mode)
    d = np.random.default_rng(2).normal(size=(4, 5, 3))
    target = constraint.channels(np.array([0.1, -0.2, 0.3]))
    weight = constraint.weights(np.full_like(target, 0.1), target)
    residual, jacobian = constraint.residual(d, target, weight), constraint.residual_jacobian(d, target, weight)
    assert jacobian.shape == (*residual.shape, 3)
    np.testing.assert_allclose(jacobian[3, 4], constraint.residual_jacobian(d[3, 4], target, weight))
    np.testing.assert_allclose(residual[3, 4], constraint.residual(d[3, 4], target, weight))
