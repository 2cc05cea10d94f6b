"""Figures of the learning: segmentation, generalised changes, keypoints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, Int

from sbam.learning.generalization import GeneralizedChange, GeneralizedChannel
from sbam.learning.keypoints import keypoint_histogram
from sbam.learning.model import ActionModel
from sbam.learning.segmentation import segment
from sbam.learning.settings import LearningSettings
from sbam.plots.style import BLUE, GREEN, GREY, ORANGE, RED, SHOWN, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CHANNELS_IN_A_ROW = 4

CONFIDENCE = 1.96
"""Standard deviations to each side of the mean: 95 % of a normal distribution."""


def plot_segmentation(
    time: Float[np.ndarray, " samples"],
    value: Float[np.ndarray, " samples"],
    name: str,
    unit: str,
    settings: LearningSettings | None = None,
    synthetic: bool = False,
) -> Figure:
    """Steps of the piecewise-linear segmentation of one channel: 2, 3 and more segments, and the final ones.

    Events, which the learning keeps in any case, are left out here.

    Args:
        time: s, strictly increasing.
        value: in ``unit``.
        name: what the channel is.
        unit: ``m``, ``rad`` or ``log``.
        settings: of the learning, for the final threshold; None: those of mode ``default``.
        synthetic: whether the data are.
    """
    settings = settings or LearningSettings.default()
    factor, shown = SHOWN[unit]
    amplitude = max(float(np.ptp(value)), settings.amplitude_floor(unit))
    final = segment(time, value, settings.segmentation_epsilon * amplitude * float(time[-1] - time[0]))
    steps = [kept for kept in (_with_segments(time, value, count) for count in (2, 3, 5)) if len(kept) < len(final)]
    figure = new_figure(3.3 * (len(steps) + 1), 3.2, f"Segmentation of {name}", synthetic)
    grid = figure.subplots(1, len(steps) + 1, sharey=True, squeeze=False)
    for axes, kept in zip(grid[0], [*steps, final], strict=True):
        chords = np.interp(time, time[kept], value[kept])
        axes.fill_between(
            time, factor * value, factor * chords, color=ORANGE, alpha=0.5, linewidth=0, label="area between"
        )
        axes.plot(time, factor * value, color=BLUE, linewidth=1.5, label="recorded")
        axes.plot(time[kept], factor * value[kept], color=RED, marker="o", markersize=4, linewidth=1.2, label="chords")
        title = f"n = {len(kept) - 1}"
        axes.set_title(f"{title}, final" if kept is final else title, fontsize=10)
        axes.set_xlabel("time / s")
    grid[0, 0].set_ylabel(f"{name.split(',')[-1].strip()} / {shown}")
    legend_below(figure, grid[0, 0])
    return figure


def _with_segments(
    time: Float[np.ndarray, " samples"], value: Float[np.ndarray, " samples"], count: int
) -> Int[np.ndarray, " points"]:
    """Segmentation with the highest threshold that gives at least so many segments."""
    low, high = 0.0, float(np.ptp(value)) * float(time[-1] - time[0])
    kept = segment(time, value, high)
    for _ in range(25):
        middle = 0.5 * (low + high)
        found = segment(time, value, middle)
        if len(found) - 1 >= count:
            low, kept = middle, found
        else:
            high = middle
        if len(found) - 1 == count:
            break
    return kept


def plot_generalized_changes(model: ActionModel, changes: Sequence[GeneralizedChange] | None = None) -> Figure:
    """Mean, confidence band and keypoints of every channel of every pair; vertical lines are the anchors.

    Args:
        model: the model.
        changes: some of its changes; None: all of them.
    """
    changes = model.changes if changes is None else changes
    title = f"{model.name}: {model.constraint} constraints generalised over {len(model.demonstrations)} demonstrations"
    figure, cells = channel_grid(changes, title, model.synthetic)
    for change, row in zip(changes, cells, strict=True):
        for axes, channel in zip(row, change.channels, strict=True):
            draw_channel(axes, channel)
            for anchor in model.anchors:
                axes.axvline(anchor.time, color=GREY, linewidth=0.6, linestyle=":")
    legend_below(figure, cells[0][0])
    return figure


def channel_grid(changes: Sequence[GeneralizedChange], title: str, synthetic: bool) -> tuple[Figure, list[list[Axes]]]:
    """A figure with a cell for every channel of every change; a change with many channels takes several rows.

    Returns:
        The figure, and for each change its cells.
    """
    columns = min(CHANNELS_IN_A_ROW, max(len(change.channels) for change in changes))
    heights = [-(-len(change.channels) // columns) for change in changes]
    figure = new_figure(3.0 * columns, 1.55 * sum(heights) + 1.0, title, synthetic)
    grid = figure.subplots(sum(heights), columns, squeeze=False, sharex=True)
    cells: list[list[Axes]] = []
    first = 0
    for change, height in zip(changes, heights, strict=True):
        own = list(grid[first : first + height].flat)
        for axes in own[len(change.channels) :]:
            axes.set_axis_off()
        own[0].set_title(str(change.pair), loc="left", fontsize=8.5)
        cells.append(own[: len(change.channels)])
        first += height
    for axes in grid[-1]:
        axes.set_xlabel("model's time / s", fontsize=9)
    return figure, cells


def draw_channel(axes: Axes, channel: GeneralizedChannel) -> None:
    """Mean, confidence band and keypoints of one channel."""
    factor, unit = SHOWN[channel.unit]
    mean, spread = factor * channel.mean, factor * CONFIDENCE * channel.std
    axes.fill_between(
        channel.time,
        mean - spread,
        mean + spread,
        color=BLUE,
        alpha=0.2,
        linewidth=0,
        label=f"mean ± {CONFIDENCE} standard deviations",
    )
    axes.plot(channel.time, mean, color=BLUE, marker="o", markersize=2.5, linewidth=1.2, label="mean, keypoints")
    axes.set_ylabel(f"{channel.name.replace('_', ' ')} / {unit}", fontsize=8)
    axes.ticklabel_format(useOffset=False)
    axes.tick_params(labelsize=7)
    axes.margins(x=0.01)


def plot_keypoints(model: ActionModel) -> Figure:
    """Histogram of all keypoint candidates, low-pass filtered, its peaks, and the keypoints that were chosen."""
    histogram = keypoint_histogram(model.changes, model.duration, model.settings)
    title = f"{model.name}: {len(model.keypoint_times)} keypoints"
    figure = new_figure(9.0, 4.0, title, model.synthetic)
    axes = figure.subplots()
    width = float(histogram.edges[1] - histogram.edges[0])
    axes.bar(histogram.centers, histogram.counts, width, color="#C8D8E4", label="keypoint candidates")
    axes.plot(histogram.centers, histogram.filtered, color=BLUE, linewidth=1.4, label="low-pass filtered")
    peaks = histogram.peaks
    axes.plot(
        histogram.centers[peaks],
        histogram.filtered[peaks],
        linestyle="none",
        marker="v",
        markersize=6,
        color=RED,
        label="peaks",
    )
    top = 1.08 * max(float(histogram.counts.max()), float(histogram.filtered.max()))
    bottom = min(0.0, float(histogram.filtered.min()))  # the filter overshoots
    axes.plot(
        model.keypoint_times,
        np.full(len(model.keypoint_times), bottom - 0.05 * top),
        linestyle="none",
        marker="|",
        markersize=12,
        markeredgewidth=1.8,
        color="black",
        label="chosen keypoints",
    )
    anchors = [anchor.time for anchor in model.anchors]
    axes.vlines(anchors, 0.0, top, color=GREEN, linewidth=0.9, linestyle=":", label="anchors (events)")
    axes.set_ylim(bottom - 0.1 * top, top)
    axes.set_xlim(-0.01 * model.duration, 1.01 * model.duration)
    axes.set_xlabel("model's time / s")
    axes.set_ylabel(f"candidates per {1000 * width:.0f} ms")
    legend_below(figure, axes)
    return figure


def legend_below(figure: Figure, axes: Axes) -> None:
    """One legend for the whole figure, where it covers no data."""
    handles: list[Any]
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(handles), fontsize=8, frameon=False)
