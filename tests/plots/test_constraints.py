"""Samples of the symbolic relations are distributed as the relations say."""

import numpy as np
import pytest
from scipy import stats

from sbam.constraints import SPATIAL_RELATIONS, constraint_type
from sbam.plots import plot_spatial_relations
from sbam.plots.constraints import sample_relation


@pytest.mark.parametrize("relation", SPATIAL_RELATIONS, ids=lambda relation: relation.name)
def test_samples_follow_the_distributions(relation) -> None:
    x, y, z = sample_relation(relation, 4000, np.random.default_rng(3)).T
    rho, phi = np.hypot(x, y), np.arctan2(y, x)
    folded = stats.foldnorm(relation.mean_rho / relation.std_rho, scale=relation.std_rho)
    assert stats.kstest(rho, folded.cdf).pvalue > 1e-3
    assert stats.kstest(z, stats.norm(relation.mean_z, relation.std_z).cdf).pvalue > 1e-3
    from_mean = (phi - relation.mean_phi + np.pi) % (2 * np.pi) - np.pi
    assert stats.kstest(from_mean, stats.vonmises(relation.kappa_phi).cdf).pvalue > 1e-3


def test_samples_look_likely_to_the_constraint() -> None:
    """What is drawn as left is, on average, more likely left than right, and so on."""
    kind = constraint_type("symbolic")
    generator = np.random.default_rng(5)
    opposite = {"above": "below", "left": "right", "in_front": "behind", "close": "far_away"}
    names = list(kind.channel_names)
    for one, other in [*opposite.items(), *((b, a) for a, b in opposite.items())]:
        relation = SPATIAL_RELATIONS[names.index(one)]
        values = kind.channels(sample_relation(relation, 500, generator)).mean(axis=0)
        assert values[names.index(one)] > values[names.index(other)]


def test_every_relation_has_its_panel(assert_readable) -> None:
    figure = plot_spatial_relations(200)
    assert_readable(figure)
    assert [axes.get_title() for axes in figure.axes] == [r.name.replace("_", " ") for r in SPATIAL_RELATIONS]
    assert all(len(axes.lines[0].get_xdata()) == 200 for axes in figure.axes)
