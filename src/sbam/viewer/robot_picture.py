"""A picture of a robot alone, at home, to see whether its description is right."""

from __future__ import annotations

import io
from pathlib import Path

import mujoco
import numpy as np
from jaxtyping import Float, UInt8
from scipy.spatial.transform import RigidTransform

from sbam.errors import FileFormatError
from sbam.files import write_atomically
from sbam.robots import Robot
from sbam.robots.composition import compile_spec
from sbam.robots.lighting import light
from sbam.viewer.camera import VIEWS
from sbam.viewer.pictures import open_offscreen

AXES = ((0.85, 0.1, 0.1, 1.0), (0.1, 0.65, 0.1, 1.0), (0.15, 0.25, 0.9, 1.0))  # red x, green y, blue z
AXIS_SIZE = (0.008, 0.008, 0.2)  # m
TABLE = (0.45, 0.33, 0.001)  # m: half sizes of the sheet that shows where the table top would be
TABLE_AT = (0.0, 0.55, -0.001)  # m, agent frame: 0.22 m before the agent it begins


def draw_robot(robot: Robot, path: str | Path, size: tuple[int, int] = (640, 560)) -> bool:
    """Write a PNG picture of a robot at home, from opposite and from its left, with the axes of its TCPs.

    Args:
        robot: the robot.
        path: where to.
        size: width and height of each view, pixels.

    Returns:
        Whether the robot's own meshes are drawn; else its collision shapes are.

    Raises:
        RenderingError: if the machine has no OpenGL that works without a screen.
        OutputError: if the file cannot be written.
    """
    from matplotlib.figure import Figure

    robot = robot.placed_for(RigidTransform.identity())
    try:
        model, with_meshes = _lit(robot, meshes=True), True
    except FileFormatError:  # a mesh that is there but broken
        model, with_meshes = _lit(robot, meshes=False), False
    drawn = np.flatnonzero((model.geom_contype | model.geom_conaffinity) == 0)
    with_meshes = with_meshes and bool((model.geom_type[drawn] == mujoco.mjtGeom.mjGEOM_MESH).any())
    images = [_image(robot, model, view, size, with_meshes) for view in ("opposite", "left")]
    figure = Figure(figsize=(2 * size[0] / 100, size[1] / 100), dpi=100)
    for axes, image in zip(figure.subplots(1, 2), images, strict=True):
        axes.imshow(image)
        axes.set_axis_off()
    figure.subplots_adjust(left=0.0, right=1.0, bottom=0.0, top=1.0, wspace=0.01)
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_atomically(path, content.getvalue())
    return with_meshes


def _lit(robot: Robot, meshes: bool) -> mujoco.MjModel:
    spec = robot.spec(meshes=meshes)
    light(spec, RigidTransform.identity())
    return compile_spec(spec, robot.description.path)


def _image(
    robot: Robot, model: mujoco.MjModel, view: str, size: tuple[int, int], with_meshes: bool
) -> UInt8[np.ndarray, "height width 3"]:
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home
    mujoco.mj_kinematics(model, data)
    context, gl = open_offscreen(model, *size)
    scene, option = mujoco.MjvScene(model, maxgeom=2000), mujoco.MjvOption()
    option.geomgroup[:] = 1
    option.sitegroup[:] = 0
    camera, wanted = mujoco.MjvCamera(), VIEWS[view]
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (0.0, 0.15, 0.15)
    camera.azimuth, camera.elevation, camera.distance = wanted.azimuth_deg, wanted.elevation_deg, 2.8
    try:
        mujoco.mjv_updateScene(model, data, option, mujoco.MjvPerturb(), camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
        if with_meshes:
            _fade_collision_shapes(model, scene)
        _add(scene, mujoco.mjtGeom.mjGEOM_BOX, TABLE, np.array(TABLE_AT), np.eye(3), (0.66, 0.62, 0.56, 0.7))
        kinematics = robot.kinematics(robot.home[None], [arm.tcp_frame for arm in robot.arms.values()])
        for position, rotation in zip(kinematics.position[0], kinematics.rotation[0], strict=True):
            for axis, color in enumerate(AXES):
                # an arrow points along its own z axis
                turn = rotation[:, [(axis + 1) % 3, (axis + 2) % 3, axis]]
                _add(scene, mujoco.mjtGeom.mjGEOM_ARROW, AXIS_SIZE, position, turn, color)
        rectangle = mujoco.MjrRect(0, 0, *size)
        mujoco.mjr_render(rectangle, scene, context)
        image = np.empty((size[1], size[0], 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, rectangle, context)
        return image[::-1]
    finally:
        context.free()
        gl.free()


def _fade_collision_shapes(model: mujoco.MjModel, scene: mujoco.MjvScene) -> None:
    """Let the capsules and boxes that stand for the meshes in collision checks shine through."""
    for i in range(scene.ngeom):
        geom = scene.geoms[i]
        of_model = geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and geom.objid >= 0
        if of_model and model.geom_contype[geom.objid] | model.geom_conaffinity[geom.objid]:
            geom.rgba[3] = 0.2
            geom.transparent = 1


def _add(
    scene: mujoco.MjvScene,
    kind: mujoco.mjtGeom,
    size: tuple[float, float, float],
    position: Float[np.ndarray, " 3"],
    rotation: Float[np.ndarray, "3 3"],
    rgba: tuple[float, float, float, float],
) -> None:
    mujoco.mjv_initGeom(
        scene.geoms[scene.ngeom],
        int(kind),
        np.array(size),
        np.array(position),
        np.ascontiguousarray(rotation).ravel(),
        np.array(rgba, dtype=np.float32),
    )
    scene.ngeom += 1
