"""Figures of a plan: demonstrated, learned and executed; the joints' motion; the objects' paths."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import RigidTransform

from sbam.constraints import RegionPair, RegionReference, constraint_type
from sbam.learning.anchors import locate_anchors, warp
from sbam.learning.generalization import GeneralizedChange, pair_vector
from sbam.learning.sketch import DemonstrationSketch, constraint_values
from sbam.planning.plan import Plan
from sbam.plots.learning import channel_grid, draw_channel, legend_below
from sbam.plots.style import BLUE, GREEN, GREY, LIGHT, ORANGE, PURPLE, RED, SHOWN, SKY, new_figure
from sbam.scene import ObjectModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PHASE_COLORS = {"approach": SKY, "grasp": ORANGE, "manipulate": GREEN, "place": ORANGE, "retreat": SKY}
PATH_COLORS = (BLUE, RED, GREEN, PURPLE)
MARGIN = 40.0  # mm around what is shown of the scene
POINTS = 1500
"""Samples of the trajectory that are drawn, at most."""


def plot_comparison(plan: Plan, pairs: Sequence[RegionPair] | None = None) -> Figure:
    """Every pair as demonstrated (where the model kept it), learned and executed, on the model's time axis.

    Args:
        plan: the plan.
        pairs: some of the model's pairs; None: all of them.
    """
    model = plan.task.model
    changes = [change for change in model.changes if pairs is None or change.pair in pairs]
    title = f"{model.name}: demonstrated, learned and executed in {plan.task.scene.name!r} by {plan.robot.name}"
    figure, cells = channel_grid(changes, title, model.synthetic)
    rows = _thinned(len(plan.model_time))
    for change, row in zip(changes, cells, strict=True):
        executed = _executed(plan, change, rows)
        demonstrated = [_demonstrated(plan, sketch, change) for sketch in model.demonstrations]
        for column, (axes, channel) in enumerate(zip(row, change.channels, strict=True)):
            factor, _ = SHOWN[channel.unit]
            label: str | None = "demonstrated"
            for curves in demonstrated:
                if curves:
                    time, value = curves[column]
                    axes.plot(time, factor * value, color=GREY, linewidth=0.6, alpha=0.7, label=label)
                    label = None
            draw_channel(axes, channel)
            axes.plot(plan.model_time[rows], factor * executed[:, column], color=RED, linewidth=1.6, label="executed")
            axes.set_xlim(0.0, model.duration)
    legend_below(figure, cells[0][0])
    return figure


def _executed(
    plan: Plan, change: GeneralizedChange, rows: Int[np.ndarray, " rows"]
) -> Float[np.ndarray, "rows channels"]:
    """Channels of a pair along the trajectory; azimuths on the learned turn."""
    first = _region_path(plan, change.pair.first, rows)
    if change.pair.second is None:
        second = plan.task.region_at_start(change.pair.first)[None]
    else:
        second = _region_path(plan, change.pair.second, rows)
    values = constraint_values(change.constraint, pair_vector(first, second, change.from_agent))
    learned, _ = change.at(np.clip(plan.model_time[rows], 0.0, plan.task.model.duration))
    circular = constraint_type(change.constraint).circular
    turns = np.round(np.mean(learned - values, axis=0) / (2 * np.pi))
    values[:, circular] += 2 * np.pi * turns[circular]
    return values


def _region_path(plan: Plan, reference: RegionReference, rows: Int[np.ndarray, " rows"]) -> Float[np.ndarray, "rows 3"]:
    name = plan.task.binding[reference.role]
    if name in plan.T_agent_object:
        return plan.T_agent_object[name][rows].apply(plan.task.region_center(reference))
    return np.tile(plan.task.region_at_start(reference), (len(rows), 1))


def _demonstrated(
    plan: Plan, sketch: DemonstrationSketch, change: GeneralizedChange
) -> list[tuple[Float[np.ndarray, " samples"], Float[np.ndarray, " samples"]]]:
    """Polylines of a demonstration, one a channel: times on the model's axis and values; empty if not kept."""
    model = plan.task.model
    for candidates in sketch.candidates:
        if candidates.pair == change.pair:
            break
    else:
        return []
    on_model = np.array([anchor.time for anchor in model.anchors])
    own = locate_anchors(
        [anchor.kind for anchor in model.anchors],
        [anchor.role for anchor in model.anchors],
        on_model,
        sketch.events,
        sketch.duration,
    )
    curves = []
    for channel, learned in zip(candidates.channels, change.channels, strict=True):
        time = warp(channel.time, own, on_model)
        value = channel.value
        if learned.unit == "rad":
            off = np.interp(time, learned.time, learned.mean) - value
            value = value + 2 * np.pi * np.round(np.mean(off) / (2 * np.pi))
        curves.append((time, value))
    return curves


def plot_trajectory(plan: Plan) -> Figure:
    """Positions and velocities of all joints against their limits; phases as coloured bars above.

    Grey areas are beyond the limits; velocities are measured against the share of the limits that was granted.
    """
    robot, trajectory = plan.robot, plan.trajectory
    groups = {hand: list(arm.joint_indices) for hand, arm in robot.arms.items()}
    if len(robot.torso_indices):
        groups["torso"] = list(robot.torso_indices)
    count = max(len(joints) for joints in groups.values())
    title = f"{robot.name}, {plan.task.model.name} in {plan.task.scene.name!r}: joints against their limits"
    figure = new_figure(4.2 * 2 * len(groups), 1.25 * count + 1.4, title, plan.task.model.synthetic)
    ratios = [0.35, *[1.0] * count]
    grid = figure.subplots(count + 1, 2 * len(groups), squeeze=False, sharex=True, height_ratios=ratios)
    rows = _thinned(len(trajectory.time))
    time = trajectory.time[rows]
    for index, (group, joints) in enumerate(groups.items()):
        for axes in grid[0, 2 * index : 2 * index + 2]:
            _draw_phases(axes, plan, group)
        for row in range(count):
            pair = grid[row + 1, 2 * index : 2 * index + 2]
            if row >= len(joints):
                for axes in pair:
                    axes.set_axis_off()
                continue
            joint = int(joints[row])
            factor, unit = SHOWN["m" if robot.is_prismatic[joint] else "rad"]
            lower, upper = factor * robot.lower[joint], factor * robot.upper[joint]
            fastest = factor * plan.settings.speed * robot.velocity_limit[joint]
            _draw_within(pair[0], time, factor * trajectory.position[rows, joint], lower, upper)
            _draw_within(pair[1], time, factor * trajectory.velocity[rows, joint], -fastest, fastest)
            pair[0].set_ylabel(f"{trajectory.joint_names[joint]}\n{unit}", fontsize=7.5)
            pair[1].set_ylabel(f"{unit}/s", fontsize=7.5)
        for axes in grid[-1, 2 * index : 2 * index + 2]:
            axes.set_xlabel("time / s", fontsize=9)
        grid[0, 2 * index].set_title(f"{group}: position", fontsize=10)
        grid[0, 2 * index + 1].set_title(f"{group}: velocity", fontsize=10)
    return figure


def _draw_within(
    axes: Axes, time: Float[np.ndarray, " samples"], value: Float[np.ndarray, " samples"], lower: float, upper: float
) -> None:
    axes.plot(time, value, color=BLUE, linewidth=1.2)
    axes.tick_params(labelsize=7)
    axes.set_xlim(0.0, time[-1])
    if np.isfinite(lower) and np.isfinite(upper):
        margin = 0.08 * (upper - lower)
        axes.axhspan(lower - margin, lower, color=LIGHT, linewidth=0)
        axes.axhspan(upper, upper + margin, color=LIGHT, linewidth=0)
        axes.set_ylim(min(lower - margin, float(value.min())), max(upper + margin, float(value.max())))


def _draw_phases(axes: Axes, plan: Plan, hand: str) -> None:
    for phase in plan.phases:
        if phase.hand == hand:
            axes.axvspan(phase.start, phase.end, color=PHASE_COLORS.get(phase.name, LIGHT), alpha=0.55, linewidth=0)
            if phase.end - phase.start > 0.12 * plan.trajectory.duration:
                axes.text(0.5 * (phase.start + phase.end), 0.5, phase.name, ha="center", va="center", fontsize=7.5)
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([])
    axes.tick_params(bottom=False)
    for side in axes.spines.values():
        side.set_visible(False)


def plot_scene_path(plan: Plan) -> Figure:
    """Paths of the moved objects' regions from above and from the side, in the agent frame.

    Objects are outlined where they start (solid) and end (dashed); the regions' paths are drawn from a dot to a square.
    """
    title = f"{plan.task.model.name} in {plan.task.scene.name!r}: paths of the regions, agent frame"
    shown = 1000.0 * np.concatenate(_extents(plan))
    lower, upper = shown.min(axis=0) - MARGIN, shown.max(axis=0) + MARGIN
    figure, (above, beside) = _same_scale(upper - lower, title, plan.task.model.synthetic)
    views = ((above, (0, 1)), (beside, (1, 2)))
    for name, model in plan.task.scene.objects.items():
        start = plan.task.T_agent_object[name]
        poses = plan.T_agent_object.get(name)
        for axes, plane in views:
            draw_outline(axes, model, start, plane, GREY if model.movable else LIGHT, "-")
            if poses is not None:
                draw_outline(axes, model, poses[-1], plane, GREY, "--")
    rows = _thinned(len(plan.model_time))
    for color, (label, path) in zip(_cycle(), _paths(plan, rows), strict=False):
        for axes, (right, up) in views:
            x, y = 1000.0 * path[:, right], 1000.0 * path[:, up]
            axes.plot(x, y, color=color, linewidth=1.5, label=label)
            axes.plot(x[:1], y[:1], marker="o", markersize=5, color=color)
            axes.plot(x[-1:], y[-1:], marker="s", markersize=5, color=color)
    for style, label in (("-", "objects at the start"), ("--", "objects at the end")):
        above.plot([], [], color=GREY, linewidth=0.9, linestyle=style, label=label)
    above.set(xlabel="right / mm", ylabel="forward / mm", title="from above")
    beside.set(xlabel="forward / mm", ylabel="up / mm", title="from the agent's right")
    for axes, plane in views:
        axes.set_xlim(lower[plane[0]], upper[plane[0]])
        axes.set_ylim(lower[plane[1]], upper[plane[1]])
        axes.grid(color="#EEEEEE")
        axes.set_axisbelow(True)
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(6, len(handles)), fontsize=9, frameon=False)
    return figure


def _paths(plan: Plan, rows: Int[np.ndarray, " rows"]) -> Iterator[tuple[str, Float[np.ndarray, "rows 3"]]]:
    for moved in plan.task.moved:
        for region in moved.model.affordance_regions:
            yield f"{region.affordance} of {moved.name}", plan.T_agent_object[moved.name][rows].apply(region.center)


def _same_scale(size: Float[np.ndarray, " 3"], title: str, synthetic: bool) -> tuple[Figure, list[Axes]]:
    """A view from above and one from the side, at one scale, of a box of ``size``, mm."""
    width, gap, below, over = 12.0, 0.9, 1.1, 0.85  # inches: of the figure, beside, below and above the axes
    scale = min((width - 2 * gap - 0.2) / (size[0] + size[1]), 5.5 / max(size[1], size[2]))
    height = scale * max(size[1], size[2]) + below + over
    figure = new_figure(width, height, title, synthetic)
    figure.set_layout_engine("none")
    left = 0.5 * (width - scale * (size[0] + size[1]) - gap) + 0.25
    cells = [(left, size[0], size[1]), (left + scale * size[0] + gap, size[1], size[2])]
    return figure, [
        figure.add_axes((x / width, below / height, scale * across / width, scale * up / height))
        for x, across, up in cells
    ]


def _extents(plan: Plan) -> list[Float[np.ndarray, "points 3"]]:
    """Points all around what moves, agent frame, m; the table is shown no further than that."""
    points = []
    for moved in plan.task.moved:
        poses = plan.T_agent_object[moved.name][_thinned(len(plan.model_time))]
        for primitive in moved.model.geometry:
            surface = primitive.T_object_primitive.apply(_surface(primitive.kind, primitive.size))
            points += [poses.apply(point) for point in surface[:: max(1, len(surface) // 64)]]
    return points


def _cycle() -> Iterator[str]:
    while True:
        yield from PATH_COLORS


def draw_outline(
    axes: Axes, model: ObjectModel, pose: RigidTransform, plane: tuple[int, int], color: str, style: str
) -> None:
    """Draw the outlines of an object's primitives, seen along the third axis, in mm."""
    from scipy.spatial import ConvexHull

    for primitive in model.geometry:
        points = 1000.0 * (pose * primitive.T_object_primitive).apply(_surface(primitive.kind, primitive.size))
        seen = points[:, plane]
        hull = seen[ConvexHull(seen).vertices]
        closed = np.concatenate([hull, hull[:1]])
        if not model.movable:
            axes.fill(*closed.T, color="#F4F1EC", zorder=0)
        axes.plot(*closed.T, color=color, linewidth=0.9, linestyle=style)


def _surface(kind: str, size: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "points 3"]:
    """Points whose convex hull is the primitive, m."""
    if kind == "box":
        return size * np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    angle = np.linspace(0.0, 2 * np.pi, 32, endpoint=False)
    circle = size[0] * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    if kind == "cylinder":
        end = np.array([0.0, 0.0, size[1]])
        return np.concatenate([circle - end, circle + end])
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 13)
    ball = np.concatenate([np.cos(a) * circle + np.array([0.0, 0.0, size[0] * np.sin(a)]) for a in latitude])
    if kind == "sphere":
        return ball
    end = np.array([0.0, 0.0, size[1]])
    return np.concatenate([ball - end, ball + end])


def _thinned(count: int) -> Int[np.ndarray, " rows"]:
    return np.unique(np.linspace(0, count - 1, min(count, POINTS)).round().astype(np.int64))
