"""Pictures show robot and objects; machines without OpenGL get a clear error."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sbam.errors import RenderingError, UnknownNameError
from sbam.planning.plan import Plan
from sbam.viewer.camera import VIEWS
from sbam.viewer.pictures import SceneRenderer, render_plan
from sbam.viewer.playback import Playback


@pytest.fixture(scope="module")
def renderer(small_plan: Plan):
    try:
        opened = SceneRenderer(Playback(small_plan), 320, 260)
    except RenderingError as error:
        pytest.skip(str(error))
    with opened as renderer:
        yield renderer


def share(image: np.ndarray, color: str) -> float:
    """Share of the pixels whose hue is that of the juice (orange) or of the cup (blue)."""
    red, green, blue = np.moveaxis(image.astype(int), -1, 0)
    hit = (blue > red + 40) & (blue > green + 20) if color == "blue" else (red > blue + 60) & (green > blue + 30)
    return float(hit.mean())


def test_the_objects_are_seen_from_the_front(renderer: SceneRenderer) -> None:
    image = renderer.image(0.0)
    assert image.shape == (260, 320, 3)
    assert 0.002 < share(image, "blue") < 0.05
    assert 0.004 < share(image, "orange") < 0.1


def test_views_and_times_differ(renderer: SceneRenderer, small_plan: Plan) -> None:
    start = renderer.image(0.0)
    assert np.array_equal(start, renderer.image(0.0))
    assert (start != renderer.image(0.5 * small_plan.trajectory.duration)).mean() > 0.02
    images = [renderer.image(0.0, view) for view in VIEWS]
    for i, one in enumerate(images):
        assert all((one != other).mean() > 0.2 for other in images[:i])
    with pytest.raises(UnknownNameError, match="'below'; known: 'opposite'"):
        renderer.image(0.0, "below")


def test_regions_are_drawn_on_the_objects(renderer: SceneRenderer, small_plan: Plan) -> None:
    with SceneRenderer(Playback(small_plan), 320, 260, regions=False) as plain:
        changed = (renderer.image(0.0, "above") != plain.image(0.0, "above")).any(axis=-1).mean()
    assert 0.001 < changed < 0.05


def test_a_strip_of_moments_is_written(renderer: SceneRenderer, small_plan: Plan, tmp_path: Path) -> None:
    from matplotlib.image import imread

    path = tmp_path / "strip.png"
    render_plan(small_plan, path, times=[1.0, 8.0, 12.0, 20.0], size=(200, 160), columns=2)
    height, width = imread(path).shape[:2]
    assert width == pytest.approx(400, abs=2)
    assert 320 < height < 420


def test_without_opengl_the_error_says_what_to_install() -> None:
    program = (
        "import mujoco\n"
        "from sbam.errors import RenderingError\n"
        "from sbam.viewer.pictures import open_offscreen\n"
        "try:\n"
        "    open_offscreen(mujoco.MjModel.from_xml_string('<mujoco/>'), 10, 10)\n"
        "except RenderingError as error:\n"
        "    print(error)\n"
    )
    environment = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}
    environment["MUJOCO_EGL_DEVICE_ID"] = "99"  # no such device
    run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    if sys.platform == "linux":
        assert "pictures cannot be drawn" in run.stdout
        assert "apt install libegl1" in run.stdout
