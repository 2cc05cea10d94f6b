"""The map of places from which a robot reaches a task."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sbam.planning.placement.search import BaseMap, Place
from sbam.plots.planning import draw_outline
from sbam.plots.style import BLUE, GREY, LIGHT, PURPLE, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

FARTHEST = 300.0  # mm: a hand that stays farther away than this is drawn like this


def plot_base_map(found: BaseMap) -> Figure:
    """One map from above for each turn of the base: where its frame could stand in the agent frame.

    Green: both hands reach; the darker, the more grasps do. Yellow to brown: how far the worse hand stays away.
    Hatched: the base would stand in something.

    Args:
        found: the result of `sbam.planning.placement.search.search_base`.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    count = len(found.turn)
    title = f"{found.task.model.name} in {found.task.scene.name!r}: places of {found.robot.name}'s base"
    figure = new_figure(4.0 * count + 2.2, 7.2, title, found.task.model.synthetic)
    figure.set_layout_engine("compressed")
    grid = figure.subplots(1, count, squeeze=False, sharey=True)[0]
    x, y = (
        1e3 * (found.robot.T_world_base.translation[i] + steps) for i, steps in ((0, found.right), (1, found.forward))
    )
    images: tuple[ScalarMappable, ...] = ()
    for index, axes in enumerate(grid):
        images = _draw_cells(axes, found, index, x, y)
        for name, model in found.task.scene.objects.items():
            draw_outline(axes, model, found.task.T_agent_object[name], (0, 1), GREY if model.movable else LIGHT, "-")
        _mark(axes, found, found.here, index, "x", BLUE)
        if found.base is not None and found.base is not found.here:
            _mark(axes, found, found.base, index, "*", PURPLE)
        axes.set(
            xlabel="right / mm", title=f"turned by {found.turn[index]:+.0f}°" if found.turn[index] else "not turned"
        )
        axes.set_aspect("equal")
        movable = [
            pose.translation[:2]
            for name, pose in found.task.T_agent_object.items()
            if found.task.scene.objects[name].movable
        ]
        places = 1e3 * np.array(movable).reshape(-1, 2)
        half = 1e3 * _cell(found) / 2
        axes.set_xlim(min(x[0], *places[:, 0]) - half - 60, max(x[-1], *places[:, 0]) + half + 60)
        axes.set_ylim(y[0] - half - 20, max(y[-1] + half, *places[:, 1]) + 120)
    grid[0].set_ylabel("forward / mm")
    for image, label in zip(
        images, ("a hand stays away by / mm", "grasps of the worse hand that reach / %"), strict=True
    ):
        figure.colorbar(image, ax=list(grid), label=label, shrink=0.7, pad=0.01)
    handles = [
        Line2D([], [], color=BLUE, marker="x", linestyle="", label="stands here"),
        Line2D([], [], color=PURPLE, marker="*", markersize=11, linestyle="", label="nearest place that does"),
        Patch(facecolor="none", edgecolor=GREY, hatch="////", label="no room"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    return figure


def _draw_cells(
    axes: Axes, found: BaseMap, index: int, x: np.ndarray, y: np.ndarray
) -> tuple[ScalarMappable, ScalarMappable]:
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Rectangle

    miss, share = 1e3 * found.miss[index], 100.0 * found.share[index]
    reached = miss == 0.0
    greens = ListedColormap(colormaps["Greens"](np.linspace(0.35, 1.0, 128)))
    away = axes.pcolormesh(
        x, y, np.ma.masked_where(reached, np.minimum(miss, FARTHEST)), cmap="YlOrBr", vmin=0.0, vmax=FARTHEST
    )
    grasps = axes.pcolormesh(
        x, y, np.ma.masked_where(~reached, share), cmap=greens, vmin=0.0, vmax=max(1.0, 100.0 * found.share.max())
    )
    half = 0.5e3 * _cell(found)
    for row, column in np.argwhere(~found.room[index]):
        corner = (float(x[column]) - half, float(y[row]) - half)
        axes.add_patch(Rectangle(corner, 2 * half, 2 * half, fill=False, hatch="////", edgecolor=GREY, linewidth=0.0))
    return away, grasps


def _cell(found: BaseMap) -> float:
    """Side of a map's cells, m; 5 cm where a single place was looked at."""
    return next((float(steps[1] - steps[0]) for steps in (found.right, found.forward) if len(steps) > 1), 0.05)


def _mark(axes: Axes, found: BaseMap, place: Place, index: int, marker: str, color: str) -> None:
    """Mark a place on the map of the turn that is nearest to its own."""
    if int(np.argmin(np.abs(found.turn - place.turn))) == index:
        at = 1e3 * np.add(found.robot.T_world_base.translation[:2], [place.right, place.forward])
        axes.plot(*at, marker=marker, markersize=12, color=color, markeredgewidth=2 if marker == "x" else 0.5)
