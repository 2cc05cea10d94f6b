"""Figures of a plan show what was planned."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.constraints import constraint_type
from sbam.planning.plan import Plan
from sbam.plots import plot_comparison, plot_scene_path, plot_trajectory


def line(axes, label: str):
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return found


def test_executed_curves_are_those_of_the_trajectory(small_plan: Plan, assert_readable) -> None:
    figure = plot_comparison(small_plan)
    assert_readable(figure)
    assert "synthetic" in figure._suptitle.get_text()
    bottle, cup = (small_plan.T_agent_object[name] for name in ("apple_juice", "cup_large"))
    objects = small_plan.task.scene.objects
    spout = bottle.apply(objects["apple_juice"].region("pour from").center)
    rim = cup.apply(objects["cup_large"].region("pour into").center)
    for axis, axes in enumerate(figure.axes[:3]):
        executed = line(axes, "executed")
        expected = 1000 * np.interp(executed.get_xdata(), small_plan.model_time, (spout - rim)[:, axis])
        assert np.abs(executed.get_ydata() - expected).max() < 1.0
        demonstrated = [one for one in axes.lines if one.get_color() == "#888888"]
        assert len(demonstrated) == len(small_plan.task.model.demonstrations)


def test_demonstrated_curves_meet_the_learned_one_at_events(small_plan: Plan) -> None:
    """The learned mean is the mean of what is drawn of the demonstrations."""
    figure = plot_comparison(small_plan, [small_plan.task.model.changes[0].pair])
    for axes in figure.axes:
        learned = line(axes, "mean, keypoints")
        curves = [one for one in axes.lines if one.get_color() == "#888888"]
        at = np.array([anchor.time for anchor in small_plan.task.model.anchors])
        mean = np.mean([np.interp(at, curve.get_xdata(), curve.get_ydata()) for curve in curves], axis=0)
        assert np.abs(mean - np.interp(at, learned.get_xdata(), learned.get_ydata())).max() < 15.0


def test_azimuths_are_drawn_on_the_learned_turn(small_plan: Plan) -> None:
    """A learned azimuth may be a whole turn off what the arc tangent gives; the curves must still lie together."""
    model = small_plan.task.model
    kind = constraint_type("cylindrical")
    change = model.changes[0]
    time = change.channels[0].time
    mean, _ = change.at(time)
    values = kind.channels(mean)
    values[:, 1] = np.unwrap(values[:, 1]) + 4 * np.pi
    channels = tuple(
        replace(channel, name=name, unit=unit, time=time, mean=values[:, k], std=0.01 + 0 * time)
        for k, (channel, name, unit) in enumerate(
            zip(change.channels, kind.channel_names, kind.channel_units, strict=True)
        )
    )
    turned = replace(change, constraint="cylindrical", channels=channels)
    plain = tuple(replace(sketch, candidates=()) for sketch in model.demonstrations)
    task = replace(small_plan.task, model=replace(model, changes=(turned,), demonstrations=plain))
    axes = plot_comparison(replace(small_plan, task=task)).axes[1]
    executed, learned = line(axes, "executed"), line(axes, "mean, keypoints")
    assert abs(executed.get_ydata().mean() - learned.get_ydata().mean()) < 180.0
    assert executed.get_ydata().mean() > 360.0


def test_joints_are_drawn_within_their_limits(small_plan: Plan, assert_readable) -> None:
    figure = plot_trajectory(small_plan)
    assert_readable(figure)
    assert "synthetic" in figure._suptitle.get_text()
    robot, trajectory = small_plan.robot, small_plan.trajectory
    for axes in figure.axes:
        name, _, unit = axes.get_ylabel().partition("\n")
        if unit == "deg":
            joint = trajectory.joint_names.index(name)
            drawn = axes.lines[0]
            expected = np.degrees(np.interp(drawn.get_xdata(), trajectory.time, trajectory.position[:, joint]))
            assert np.allclose(drawn.get_ydata(), expected, atol=1e-6)
            edges = {round(patch.get_extents().transformed(axes.transData.inverted()).y0, 3) for patch in axes.patches}
            assert round(float(np.degrees(robot.upper[joint])), 3) in edges
    shown = {axes.get_ylabel().partition("\n")[0] for axes in figure.axes}
    assert set(trajectory.joint_names) <= shown


def test_a_robot_with_a_torso_has_columns_for_it(small_plan: Plan, assert_readable) -> None:
    robot = small_plan.robot.placed(small_plan.robot.T_world_base)
    robot.torso_indices = np.array([0, 1])
    robot.lower, robot.upper = robot.lower.copy(), robot.upper.copy()
    robot.lower[0], robot.upper[0] = -np.inf, np.inf  # a continuous joint
    figure = plot_trajectory(replace(small_plan, robot=robot))
    assert_readable(figure)
    assert "torso: velocity" in {axes.get_title() for axes in figure.axes}


def test_paths_are_seen_from_above_and_from_the_side_at_one_scale(small_plan: Plan, assert_readable) -> None:
    figure = plot_scene_path(small_plan)
    assert_readable(figure)
    above, beside = figure.axes
    spout = small_plan.task.scene.objects["apple_juice"].region("pour from").center
    path = 1000 * small_plan.T_agent_object["apple_juice"].apply(spout)
    for axes, plane in ((above, (0, 1)), (beside, (1, 2))):
        drawn = line(axes, "pour from of apple_juice")
        assert drawn.get_xdata()[0] == pytest.approx(path[0, plane[0]])
        assert drawn.get_ydata().max() == pytest.approx(path[:, plane[1]].max(), abs=1.0)
        low, high = axes.get_xlim()
        assert low < path[:, plane[0]].min() and path[:, plane[0]].max() < high
    inches = figure.get_size_inches()
    scales = []
    for axes in (above, beside):
        box = axes.get_position()
        scales += [box.width * inches[0] / np.ptp(axes.get_xlim()), box.height * inches[1] / np.ptp(axes.get_ylim())]
    assert np.allclose(scales, scales[0])
