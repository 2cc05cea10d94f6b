"""Films and pictures of what happened in physics, drawn by MuJoCo without a screen."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import mujoco
import numpy as np
from jaxtyping import UInt8

from sbam.errors import MissingExtraError, SimulationError
from sbam.files import write_atomically
from sbam.simulation.simulate import SimulationResult
from sbam.viewer.camera import LOOK_AT, heading_deg, view_named
from sbam.viewer.pictures import open_offscreen

Image = UInt8[np.ndarray, "height width 3"]

FRAMES_PER_SECOND = 25
WEB_FRAMES_PER_SECOND = 12.5
SIZE = (640, 480)
MOMENTS = 6
NEAR = 0.55  # of the distance of a view
ABOVE = 0.08  # m above the objects' origins, which are at their feet


def write_film(
    result: SimulationResult,
    path: str | Path,
    view: str = "opposite",
    between: tuple[float, float] | None = None,
    size: tuple[int, int] = SIZE,
    close: bool = False,
) -> None:
    """Write a film in real time (``.mp4``: H.264; ``.webp``: for web pages), or moments side by side (``.png``).

    Args:
        result: what happened.
        path: where to; its suffix says what.
        view: one of `sbam.viewer.camera.VIEWS`.
        between: first and last time of a film, s; by default all of it.
        size: width and height of a film, pixels.
        close: look from near at what moves in a film.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
        MissingExtraError: if PyAV, which writes ``.mp4``, is not installed.
        SimulationError: for another suffix.
        OutputError: if the file cannot be written.
    """
    path = Path(path)
    first, last = between or (0.0, float(result.record.time[-1]))
    if path.suffix == ".png":
        write_atomically(path, picture(result, moments(result), view))
    elif path.suffix == ".mp4":
        times = np.arange(first, last, 1.0 / FRAMES_PER_SECOND)
        write_atomically(path, _mp4(images(result, frames_at(result, times), view, size, close), size))
    elif path.suffix == ".webp":
        times = np.arange(first, last, 1.0 / WEB_FRAMES_PER_SECOND)
        write_atomically(path, _webp(images(result, frames_at(result, times), view, size, close)))
    else:
        raise SimulationError(f"{path}: a film is .mp4 or .webp, a picture .png")


def moments(result: SimulationResult, count: int = MOMENTS) -> list[int]:
    """Frames that show the action: from the first motion of an object to the last, evenly."""
    poses = result.record.T_world_object.values()
    away = np.max([np.linalg.norm(pose.translation - pose.translation[0], axis=1) for pose in poses], axis=0)
    moved = np.flatnonzero(away > 0.01)
    first, last = (int(moved[0]), int(moved[-1])) if len(moved) else (0, len(away) - 1)
    return np.linspace(first, last, count).round().astype(int).tolist()


def frames_at(result: SimulationResult, times: Iterable[float]) -> list[int]:
    """The frames of the record nearest to times, s."""
    return [int(np.abs(result.record.time - time).argmin()) for time in times]


def images(
    result: SimulationResult,
    frames: Sequence[int],
    view: str = "opposite",
    size: tuple[int, int] = SIZE,
    close: bool = False,
) -> Iterator[Image]:
    """Pictures (height, width, 3) of frames of the record.

    Args:
        result: what happened.
        frames: which.
        view: one of `sbam.viewer.camera.VIEWS`.
        size: width and height, pixels.
        close: look from near at the middle of what moves.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
    """
    model, T_world_agent = result.world.model, result.action.scene.T_world_agent
    width, height = size
    context, gl = open_offscreen(model, width, height)
    try:
        wanted = view_named(view)
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = T_world_agent.apply(LOOK_AT)
        camera.azimuth = wanted.azimuth_deg + heading_deg(T_world_agent)
        camera.elevation, camera.distance = wanted.elevation_deg, wanted.distance
        if close:
            places = [pose.translation[list(frames)] for pose in result.record.T_world_object.values()]
            camera.lookat[:] = np.mean(places, axis=(0, 1)) + np.array([0.0, 0.0, ABOVE])
            camera.distance *= NEAR
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


def _mp4(frames: Iterator[Image], size: tuple[int, int]) -> bytes:
    try:
        import av
    except ImportError as error:
        raise MissingExtraError("films", "av", "video") from error
    content = io.BytesIO()
    with av.open(content, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(FRAMES_PER_SECOND))
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": "23", "preset": "fast"}
        for image in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode())
    return content.getvalue()


def _webp(frames: Iterator[Image]) -> bytes:
    from PIL.Image import fromarray  # comes with matplotlib

    first, *others = (fromarray(frame) for frame in frames)
    content = io.BytesIO()
    duration = round(1000 / WEB_FRAMES_PER_SECOND)
    first.save(content, "WEBP", save_all=True, append_images=others, duration=duration, loop=0, quality=75, method=4)
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
