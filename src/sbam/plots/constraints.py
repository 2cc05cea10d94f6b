"""What the symbolic spatial relations mean (paper, figure of the evaluation)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from sbam.constraints import SPATIAL_RELATIONS, SpatialRelation
from sbam.plots.style import BLUE, RED, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = 4
RANGE = 800.0  # mm shown to each side


def sample_relation(
    relation: SpatialRelation, count: int, generator: np.random.Generator
) -> Float[np.ndarray, "samples 3"]:
    """Random vectors that a relation describes: radius and height normal, azimuth von Mises.

    Args:
        relation: the relation.
        count: how many.
        generator: source of chance.

    Returns:
        Vectors from the reference region, agent frame, m.
    """
    rho = np.abs(generator.normal(relation.mean_rho, relation.std_rho, count))
    phi = generator.vonmises(relation.mean_phi, relation.kappa_phi, count)
    z = generator.normal(relation.mean_z, relation.std_z, count)
    return np.column_stack([rho * np.cos(phi), rho * np.sin(phi), z])


def plot_spatial_relations(count: int = 2000, seed: int = 0) -> Figure:
    """Random samples of each spatial relation around its reference, in space.

    Args:
        count: samples of each relation.
        seed: of the samples.
    """
    generator = np.random.default_rng(seed)
    rows = -(-len(SPATIAL_RELATIONS) // COLUMNS)
    title = f"Symbolic spatial relations: {count} random samples each, agent frame, mm"
    figure = new_figure(3.4 * COLUMNS, 3.5 * rows, title, synthetic=False)
    for index, relation in enumerate(SPATIAL_RELATIONS):
        axes = figure.add_subplot(rows, COLUMNS, index + 1, projection="3d")
        x, y, z = 1000.0 * sample_relation(relation, count, generator).T
        axes.plot(x, y, z, linestyle="none", marker=".", markersize=1.6, color=BLUE, alpha=0.5)
        axes.plot([0.0], [0.0], [0.0], linestyle="none", marker="o", markersize=6, color=RED, zorder=10)
        axes.set_title(relation.name.replace("_", " "), fontsize=11, pad=-4)
        for name, label in (("x", "right"), ("y", "forward"), ("z", "up")):
            getattr(axes, f"set_{name}lim")(-RANGE, RANGE)
            getattr(axes, f"set_{name}ticks")([-500, 0, 500])
            getattr(axes, f"set_{name}label")(label, fontsize=8, labelpad=-4)
        axes.tick_params(labelsize=7, pad=-2)
        axes.set_box_aspect((1.0, 1.0, 1.0))
        axes.view_init(elev=22, azim=-70)
    return figure
