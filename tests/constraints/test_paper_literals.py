"""The paper's table of spatial relations, and similarities worked out by hand."""

import numpy as np
import pytest

from sbam.constraints import CONSTRAINT_TYPES, SPATIAL_RELATIONS, Cartesian, Cylindrical, Symbolic

ANY, HALF, FULL = 1e-5, 0.5 * np.pi, np.pi

# mu_rho, sigma_rho (mm), mu_phi (rad), kappa_phi, mu_z, sigma_z (mm), as printed.
TABLE_I = {
    "above": (0, 250, 0, ANY, 250, 100),
    "below": (0, 250, 0, ANY, -250, 100),
    "close": (0, 100, 0, ANY, 0, 250),
    "far_away": (500, 100, 0, ANY, 0, 250),
    "in_front": (0, 250, 3 / 2 * np.pi, 5, 0, 250),
    "behind": (0, 250, 1 / 2 * np.pi, 5, 0, 250),
    "left": (0, 250, np.pi, 5, 0, 250),
    "right": (0, 250, 0, 5, 0, 250),
}


def similarity(constraint, d, target, std):
    """|residual|^2 with the weights of standard deviations."""
    d, target, std = np.array(d), np.array(target), np.array(std)
    return np.square(constraint.residual(d, target, constraint.weights(std, target))).sum()


def test_the_relations_are_those_of_the_table():
    assert tuple(TABLE_I) == Symbolic.channel_names == tuple(relation.name for relation in SPATIAL_RELATIONS)
    for relation in SPATIAL_RELATIONS:
        mean_rho, std_rho, mean_phi, kappa, mean_z, std_z = TABLE_I[relation.name]
        lengths = (relation.mean_rho, relation.std_rho, relation.mean_z, relation.std_z)
        assert np.array(lengths) * 1000.0 == pytest.approx(np.array([mean_rho, std_rho, mean_z, std_z]), rel=1e-12)
        assert (relation.mean_phi, relation.kappa_phi) == pytest.approx((mean_phi, kappa), rel=1e-12)


def test_log_densities_by_hand():
    """At rho 500, phi 0.927 (3 right, 4 behind) and z 100 mm; -ln(s sqrt(2 pi)) is -5.5241 for 100, -6.4404 for 250.

    Von Mises: -ln(2 pi) = -1.8379 for kappa near 0; 5 cos(phi - mu) - ln(2 pi I_0(5)), I_0(5) = 27.2399, -5.1426 with
    5 cos = 3 (right), 4 (behind), -3 (left), -4 (in front).
    """
    by_hand = {
        "above": -2.0 - 6.440400 - 1.837877 - 1.125 - 5.524109,
        "below": -2.0 - 6.440400 - 1.837877 - 6.125 - 5.524109,
        "close": -12.5 - 5.524109 - 1.837877 - 0.08 - 6.440400,
        "far_away": 0.0 - 5.524109 - 1.837877 - 0.08 - 6.440400,
        "in_front": -2.0 - 6.440400 - 4.0 - 5.142559 - 0.08 - 6.440400,
        "behind": -2.0 - 6.440400 + 4.0 - 5.142559 - 0.08 - 6.440400,
        "left": -2.0 - 6.440400 - 3.0 - 5.142559 - 0.08 - 6.440400,
        "right": -2.0 - 6.440400 + 3.0 - 5.142559 - 0.08 - 6.440400,
    }
    found = Symbolic().channels(np.array([0.3, 0.4, 0.1]))
    assert dict(zip(Symbolic.channel_names, found, strict=True)) == pytest.approx(by_hand, abs=1e-5)


@pytest.mark.parametrize(
    ("d", "goal", "deviations"),
    [
        # Quarter turn: kappa (cos(0 - mu) - cos(pi/2 - mu)).
        ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (ANY, ANY, ANY, ANY, 5.0, -5.0, -5.0, 5.0)),
        # From 250 below to 250 above: 500^2 / (2 100^2).
        ((0.25, 0.0, 0.25), (0.25, 0.0, -0.25), (12.5, -12.5, 0, 0, 0, 0, 0, 0)),
        # From 600 to 100 aside: 350000 / (2 250^2), 350000 / (2 100^2), (100^2 - 400^2) / (2 100^2).
        ((0.1, 0.0, 0.0), (0.6, 0.0, 0.0), (2.8, 2.8, 17.5, -7.5, 2.8, 2.8, 2.8, 2.8)),
    ],
)
def test_symbolic_similarity_by_hand(d, goal, deviations):
    """Standard deviations of 1 weigh 1/2 in mode ``paper``; those of 0.12 weigh 1/0.13 in mode ``default``."""
    target = Symbolic().channels(np.array(goal))
    np.testing.assert_allclose(Symbolic().channels(np.array(d)) - target, deviations, atol=1e-5)
    square = np.square(deviations).sum()
    assert similarity(Symbolic(mode="paper"), d, target, np.ones(8)) == pytest.approx(square / 4, rel=1e-5)
    assert similarity(Symbolic(), d, target, np.full(8, 0.12)) == pytest.approx(square / 0.13**2, rel=1e-5)


def test_cartesian_similarity_by_hand():
    """Paper: weights 1/10, 1/20, 1/40 per mm times 30, 40, -80 mm. Default: 1/13, 1/5, 1/5 times 26, 10, -15 mm."""
    goal = [0.2, -0.3, 0.4]
    paper = similarity(Cartesian(mode="paper"), np.add(goal, [0.03, 0.04, -0.08]), goal, [0.009, 0.019, 0.039])
    assert paper == pytest.approx(3**2 + 2**2 + 2**2)
    default = similarity(Cartesian(), np.add(goal, [0.026, 0.01, -0.015]), goal, [0.012, 0.0, 0.0])
    assert default == pytest.approx(2**2 + 2**2 + 3**2)


def test_cylindrical_similarity_by_hand():
    """A quarter turn short, 300 instead of 400 aside, 40 mm too high.

    Paper: weights 1/10 per mm, 1/2, 1/20 per mm, so that the turn counts as an eighth: the law of cosines gives
    (300^2 + 400^2 - 2 300 400 cos 45 deg) / 10^2 + (40 / 20)^2.
    Default: weights 1/13 per mm, 400/13 (of 12 mm along the arc) and 1/5 per mm; the chord of a quarter turn is sqrt 2.
    """
    d, goal = (0.3, 0.0, 0.14), (0.4, HALF, 0.1)
    paper = similarity(Cylindrical(mode="paper"), d, goal, [0.009, 1.0, 0.019])
    assert paper == pytest.approx(2500.0 - 2400.0 / np.sqrt(2.0) + 4.0)
    default = similarity(Cylindrical(), d, goal, [0.012, 0.03, 0.0])
    assert default == pytest.approx((100 / 13) ** 2 + 2.0 * (400 / 13) ** 2 + 8.0**2)


def test_cylindrical_channels_by_hand():
    found = Cylindrical().channels(np.array([[0.3, 0.4, -0.1], [0.0, -0.2, 0.0], [-0.1, 0.0, 0.5]]))
    np.testing.assert_allclose(found, [[0.5, np.arctan(4 / 3), -0.1], [0.2, -HALF, 0.0], [0.1, FULL, 0.5]], atol=1e-15)


def test_what_the_channels_are_called():
    assert {name: type_.channel_units for name, type_ in CONSTRAINT_TYPES.items()} == {
        "cartesian": ("m", "m", "m"),
        "cylindrical": ("m", "rad", "m"),
        "symbolic": ("log",) * 8,
    }
    assert [type_.circular.tolist() for type_ in CONSTRAINT_TYPES.values()] == [
        [False, False, False],
        [False, True, False],
        [False] * 8,
    ]
    assert Cartesian.channel_names == ("x", "y", "z")
    assert Cylindrical.channel_names == ("rho", "phi", "z")
