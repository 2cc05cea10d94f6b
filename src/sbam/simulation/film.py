"""Films and pictures of what happened in physics, drawn by MuJoCo without a screen."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from sbam.errors import MissingExtraError, SimulationError
from sbam.files import write_atomically
from sbam.simulation.simulate import SimulationResult
from sbam.viewer.camera import LOOK_AT, heading_deg, view_named
from sbam.viewer.pictures import open_offscreen

Image = NDArray[np.uint8]

FRAMES_PER_SECOND = 25
SIZE = (640, 480)
MOMENTS = 6


def write_film(result: SimulationResult, path: str | Path, view: str = "opposite") -> None:
    """Write a film (``.mp4``, H.264, in real time) or a picture of moments side by side (``.png``).

    Args:
        result: what happened.
        path: where to; its suffix says what.
        view: one of `sbam.viewer.camera.VIEWS`.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
        MissingExtraError: if PyAV, which writes films, is not installed.
        SimulationError: for another suffix.
        OutputError: if the file cannot be written.
    """
    path = Path(path)
    if path.suffix == ".png":
        write_atomically(path, picture(result, moments(result), view))
    elif path.suffix == ".mp4":
        write_atomically(path, _film(result, view))
    else:
        raise SimulationError(f"{path}: a film is .mp4, a picture .png")


def moments(result: SimulationResult, count: int = MOMENTS) -> list[int]:
    """Frames that show the action: from the first motion of an object to the last, evenly."""
    poses = result.record.T_world_object.values()
    away = np.max([np.linalg.norm(pose.translation - pose.translation[0], axis=1) for pose in poses], axis=0)
    moved = np.flatnonzero(away > 0.01)
    first, last = (int(moved[0]), int(moved[-1])) if len(moved) else (0, len(away) - 1)
    return np.linspace(first, last, count).round().astype(int).tolist()


def frames_at(result: SimulationResult, times: Sequence[float]) -> list[int]:
    """The frames of the record nearest to times, s."""
    return [int(np.abs(result.record.time - time).argmin()) for time in times]


def images(result: SimulationResult, frames: Sequence[int], view: str = "opposite") -> Iterator[Image]:
    """Pictures (height, width, 3) of frames of the record.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
    """
    model, T_world_agent = result.world.model, result.action.scene.T_world_agent
    width, height = SIZE
    context, gl = open_offscreen(model, width, height)
    try:
        wanted = view_named(view)
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = T_world_agent.apply(LOOK_AT)
        camera.azimuth = wanted.azimuth_deg + heading_deg(T_world_agent)
        camera.elevation, camera.distance = wanted.elevation_deg, wanted.distance
        scene, option, data = mujoco.MjvScene(model, maxgeom=2000), mujoco.MjvOption(), mujoco.MjData(model)
        option.sitegroup[:] = 0
        rectangle = mujoco.MjrRect(0, 0, width, height)
        for frame in frames:
            data.qpos[:] = result.record.qpos[frame]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_camlight(model, data)
            mujoco.mjv_updateScene(model, data, option, mujoco.MjvPerturb(), camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
            mujoco.mjr_render(rectangle, scene, context)
            image = np.empty((height, width, 3), dtype=np.uint8)
            mujoco.mjr_readPixels(image, None, rectangle, context)
            yield np.ascontiguousarray(image[::-1])
    finally:
        context.free()
        gl.free()


def _film(result: SimulationResult, view: str) -> bytes:
    try:
        import av
    except ImportError as error:
        raise MissingExtraError("films", "av", "video") from error
    time = result.record.time
    frames = np.searchsorted(time, np.arange(0.0, time[-1], 1.0 / FRAMES_PER_SECOND)).tolist()
    content = io.BytesIO()
    with av.open(content, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(FRAMES_PER_SECOND))
        stream.width, stream.height = SIZE
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": "23", "preset": "fast"}
        for image in images(result, frames, view):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode())
    return content.getvalue()


def picture(result: SimulationResult, frames: Sequence[int], view: str = "opposite", columns: int = 3) -> bytes:
    """Frames side by side with their times, as PNG.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
    """
    from matplotlib.figure import Figure

    rows = -(-len(frames) // columns)
    width, height = SIZE[0] / 100, SIZE[1] / 100
    figure = Figure(figsize=(columns * width, rows * (height + 0.3)), dpi=100)
    grid = figure.subplots(rows, columns, squeeze=False)
    figure.subplots_adjust(left=0.004, right=0.996, bottom=0.004, top=0.96, wspace=0.012, hspace=0.3 / height)
    for axes, image, frame in zip(grid.flat, images(result, frames, view), frames, strict=False):
        axes.imshow(image)
        axes.set_title(f"{result.record.time[frame]:.1f} s", fontsize=11, pad=4)
    for axes in grid.flat:
        axes.set_axis_off()
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()
