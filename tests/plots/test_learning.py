"""Figures of the learning show what was learned."""

from dataclasses import replace

import numpy as np
import pytest

from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.learning import ActionModel, LearningSettings, learn
from sbam.plots import plot_generalized_changes, plot_keypoints, plot_segmentation
from sbam.plots.write import demonstrated_channels


@pytest.fixture(scope="module")
def demonstrations():
    return built_in_demonstrations("pouring")[::4]


@pytest.fixture(scope="module")
def model(demonstrations) -> ActionModel:
    return learn(demonstrations, name="pouring")


def test_segmentation_steps_come_nearer_to_the_data(model, demonstrations, assert_readable) -> None:
    values = demonstrated_channels(model, demonstrations[0], model.changes[0].pair, "cartesian")[:, 0]
    time = demonstrations[0].time
    figure = plot_segmentation(time, values, "spout to rim, x", "m", synthetic=True)
    assert_readable(figure)
    assert "synthetic" in figure._suptitle.get_text()
    areas = []
    for axes in figure.axes:
        recorded, chords = axes.lines
        assert np.allclose(recorded.get_ydata(), 1000 * values)
        count = int(axes.get_title().split("=")[1].split(",")[0])
        assert len(chords.get_xdata()) == count + 1
        between = np.interp(time, chords.get_xdata(), chords.get_ydata())
        areas.append(np.abs(between - recorded.get_ydata()).mean())
    assert len(areas) == 4
    assert areas[-1] < 0.2 * areas[0]
    assert (np.diff(areas) < 1e-9).all()


def test_a_constant_channel_has_one_segment() -> None:
    figure = plot_segmentation(np.linspace(0, 5, 100), np.full(100, 0.3), "nothing, z", "m")
    assert [axes.get_title() for axes in figure.axes] == ["n = 1, final"]
    assert "synthetic" not in figure._suptitle.get_text()


def test_generalised_changes_are_drawn_with_their_bands(model, assert_readable) -> None:
    figure = plot_generalized_changes(model)
    assert_readable(figure)
    assert "synthetic" in figure._suptitle.get_text()
    channels = [channel for change in model.changes for channel in change.channels]
    assert len(figure.axes) == len(channels)
    for axes, channel in zip(figure.axes, channels, strict=True):
        assert np.allclose(axes.lines[0].get_ydata(), 1000 * channel.mean)
        (band,) = axes.collections
        top = band.get_paths()[0].vertices[:, 1].max()
        assert top == pytest.approx(1000 * (channel.mean + 1.96 * channel.std).max())


def test_symbolic_channels_take_several_rows(demonstrations, assert_readable) -> None:
    from_center = replace(LearningSettings(), supports="center")  # else one pair alone is symbolic
    symbolic = learn(demonstrations[:2], constraint="symbolic", settings=from_center)
    changes = [change for change in symbolic.changes if change.constraint == "symbolic"][:2]
    figure = plot_generalized_changes(symbolic, changes)
    assert_readable(figure)
    assert len(figure.axes) == 16
    assert len({round(axes.get_position().x0, 3) for axes in figure.axes}) == 4
    assert figure.axes[3].get_ylabel() == "far away / log density"


def test_keypoints_stand_where_the_model_has_them(model, assert_readable) -> None:
    figure = plot_keypoints(model)
    assert_readable(figure)
    (axes,) = figure.axes
    lines = {line.get_label(): line for line in axes.lines}
    assert np.array_equal(lines["chosen keypoints"].get_xdata(), model.keypoint_times)
    bars = sum(bar.get_height() for bar in axes.patches)
    assert bars == sum(len(channel.time) for change in model.changes for channel in change.channels)
    assert lines["chosen keypoints"].get_ydata().max() < lines["low-pass filtered"].get_ydata().min()
