"""Pictures of a plan, drawn by MuJoCo without a screen."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import mujoco
import numpy as np
from jaxtyping import UInt8

from sbam.errors import RenderingError
from sbam.files import write_atomically
from sbam.planning.plan import Plan
from sbam.viewer.camera import LOOK_AT, heading_deg, view_named
from sbam.viewer.playback import Playback, ellipse_rotation

Image = UInt8[np.ndarray, "height width 3"]

REGION_COLOR = (0.90, 0.35, 0.05, 0.65)
REGION_THICKNESS = 0.001


def render_plan(
    plan: Plan,
    path: str | Path,
    times: Sequence[float] | None = None,
    view: str = "opposite",
    size: tuple[int, int] = (560, 460),
    columns: int = 3,
) -> None:
    """Write a PNG picture with moments of a plan side by side, each labelled with its time and phases.

    Args:
        plan: the plan.
        path: where to.
        times: s on the trajectory's time axis; by default six that show the action.
        view: one of `sbam.viewer.camera.VIEWS`.
        size: width and height of each moment, pixels.
        columns: moments in a row.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
        UnknownNameError: for an unknown view.
        OutputError: if the file cannot be written.
    """
    from matplotlib.figure import Figure

    playback = Playback(plan)
    moments = [float(time) for time in (playback.moments() if times is None else times)]
    with SceneRenderer(playback, *size) as renderer:
        images = [renderer.image(time, view) for time in moments]
    rows = -(-len(images) // columns)
    columns = min(columns, len(images))
    width, height = size[0] / 100, size[1] / 100
    figure = Figure(figsize=(columns * width, rows * (height + 0.3)), dpi=100)
    grid = figure.subplots(rows, columns, squeeze=False)
    figure.subplots_adjust(left=0.004, right=0.996, bottom=0.004, top=1 - 0.3 / (rows * (height + 0.3)), wspace=0.012)
    figure.subplots_adjust(hspace=0.3 / height)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, image, time in zip(grid.flat, images, moments, strict=False):
        axes.imshow(image)
        axes.set_title(f"{time:.1f} s   {playback.label(time)}", fontsize=11, pad=4)
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_atomically(path, content.getvalue())


class SceneRenderer:
    """Draws a playback offscreen; use it as a context manager, which frees the OpenGL context."""

    def __init__(self, playback: Playback, width: int, height: int, regions: bool = True) -> None:
        """Open an OpenGL context.

        Args:
            playback: what is drawn.
            width: pixels, at most 2048.
            height: pixels, at most 2048.
            regions: draw the affordance regions as ellipses.

        Raises:
            RenderingError: if there is none.
        """
        self._playback, self._regions = playback, regions
        model = playback.model
        self._context, self._gl = open_offscreen(model, width, height)
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=2000)
        self._option = mujoco.MjvOption()
        self._option.sitegroup[:] = 0
        self._data = mujoco.MjData(model)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._context.free()
        self._gl.free()

    def image(self, time: float, view: str = "opposite") -> Image:
        """The picture (height, width, 3) at a time, s; raises `UnknownNameError` for an unknown view."""
        playback, model = self._playback, self._playback.model
        playback.set_time(self._data, time)
        camera = self._camera(view)
        scene = self._scene
        mujoco.mjv_updateScene(
            model, self._data, self._option, mujoco.MjvPerturb(), camera, mujoco.mjtCatBit.mjCAT_ALL, scene
        )
        self._add_floor()
        if self._regions:
            self._add_regions(time)
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 1
        mujoco.mjr_render(self._rectangle, scene, self._context)
        image = np.empty((self._rectangle.height, self._rectangle.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, self._rectangle, self._context)
        return image[::-1]

    def _camera(self, view: str) -> mujoco.MjvCamera:
        wanted = view_named(view)
        T_world_agent = self._playback.plan.T_world_agent
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = T_world_agent.apply(LOOK_AT)
        camera.azimuth = wanted.azimuth_deg + heading_deg(T_world_agent)
        camera.elevation, camera.distance = wanted.elevation_deg, wanted.distance
        return camera

    def _add(self, kind: Any, size: Sequence[float], position: Any, rotation: Any, rgba: Any) -> Any:
        geom = self._scene.geoms[self._scene.ngeom]
        mujoco.mjv_initGeom(
            geom,
            int(kind),
            np.asarray(size, dtype=np.float64),
            np.asarray(position, dtype=np.float64),
            np.asarray(rotation, dtype=np.float64).ravel(),
            np.asarray(rgba, dtype=np.float32),
        )
        self._scene.ngeom += 1
        return geom

    def _add_floor(self) -> None:
        center = self._playback.plan.T_world_agent.translation.copy()
        center[2] = self._playback.floor
        self._add(mujoco.mjtGeom.mjGEOM_PLANE, (3.0, 3.0, 1.0), center, np.eye(3), (0.86, 0.87, 0.88, 1.0))

    def _add_regions(self, time: float) -> None:
        scene = self._playback.plan.task.scene
        for name, poses in self._playback.object_poses(time).items():
            if not scene.objects[name].movable:
                continue  # a whole table top would only hide what stands on it
            for region in scene.objects[name].affordance_regions:
                self._add(
                    mujoco.mjtGeom.mjGEOM_ELLIPSOID,
                    (*region.half_axes, REGION_THICKNESS),
                    poses[0].apply(region.center),
                    (poses[0].rotation * ellipse_rotation(region)).as_matrix(),
                    REGION_COLOR,
                )


def open_offscreen(model: mujoco.MjModel, width: int, height: int) -> tuple[mujoco.MjrContext, Any]:
    """An offscreen OpenGL context and MuJoCo's resources in it; free both.

    Raises:
        RenderingError: if the machine has none.
    """
    try:
        if sys.platform == "linux" and not os.environ.get("MUJOCO_GL"):
            from mujoco.egl import GLContext  # MuJoCo's own choice would want a screen
        else:
            from mujoco import GLContext
        gl = GLContext(width, height)
        gl.make_current()
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
    except Exception as error:  # each backend fails in its own ways: missing library, no device, no display
        raise RenderingError(f"{type(error).__name__}: {error}") from error
    return context, gl
