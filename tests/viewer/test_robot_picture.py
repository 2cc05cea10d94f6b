"""A robot alone is drawn at home, with the axes of its hands."""

from pathlib import Path

import numpy as np
import pytest

from sbam.errors import RenderingError
from sbam.robots import load_robot
from sbam.viewer.robot_picture import draw_robot


def test_robot_table_and_axes_are_seen(tmp_path: Path) -> None:
    from matplotlib.image import imread

    try:
        with_meshes = draw_robot(load_robot("armar7"), tmp_path / "robot.png", (320, 280))
    except RenderingError as error:
        pytest.skip(str(error))
    assert not with_meshes
    image = (255 * imread(tmp_path / "robot.png")[..., :3]).astype(int)
    assert image.shape == (280, 640, 3)
    for half in (image[:, :320], image[:, 320:]):
        red, green, blue = np.moveaxis(half, -1, 0)
        hands = (green > red + 25) & (green > blue + 10)
        assert 0.001 < hands.mean() < 0.1  # drawn green
        assert (half.std(axis=(0, 1)) > 15).all()
