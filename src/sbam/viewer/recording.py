"""A self-contained web page that plays a plan; it opens from disk, offline, in any browser."""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float32, UInt32

from sbam.files import write_atomically
from sbam.planning.plan import Plan
from sbam.robots.composition import OBJECT_PREFIX
from sbam.scene import AffordanceRegion
from sbam.viewer.camera import LOOK_AT, VIEWS
from sbam.viewer.playback import Playback, ellipse_rotation

if TYPE_CHECKING:
    from viser import SceneApi

RATE = 30.0
"""Pictures per second."""

PAUSE = 1.0  # s for which the page stands still before it starts anew
STILL_POSITION = 2e-5  # m: a body that moved less than this since it was last sent is not sent again
STILL_QUATERNION = 2e-5
REGION_COLOR = (230, 110, 20)
LIFT = 0.0015  # m by which an ellipse is drawn before its surface


def write_recording(plan: Plan, path: str | Path) -> None:
    """Write a page with play, pause and a time bar, and free view: robot, objects, affordance regions, phases.

    Args:
        plan: the plan.
        path: where to (``.html``).

    Raises:
        OutputError: if the file cannot be written.
    """
    write_atomically(path, recording_html(plan))


def recording_html(plan: Plan) -> str:
    """The page as text, 3 to 4 MB. The server that builds it listens on this machine only, and no longer than that."""
    from viser import ViserServer

    playback = Playback(plan)
    with redirect_stdout(io.StringIO()):  # the server announces itself, but nobody is to visit it
        server = ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            _set_stage(server, playback)
            bodies = _Bodies(server.scene, playback)
            serializer = server.get_scene_serializer()
            bodies.record(serializer)
            return serializer.as_html()
        finally:
            server.stop()


def _set_stage(server: Any, playback: Playback) -> None:
    """Camera and floor."""
    T_world_agent = playback.plan.T_world_agent
    server.scene.set_up_direction("+z")
    server.initial_camera.position = tuple(T_world_agent.apply(VIEWS["opposite"].position()))
    server.initial_camera.fov = np.radians(50.0)
    server.initial_camera.look_at = tuple(T_world_agent.apply(LOOK_AT))
    server.initial_camera.up = (0.0, 0.0, 1.0)
    center = T_world_agent.apply([0.0, 0.4, 0.0])
    server.scene.add_grid(
        "/floor",
        width=4.0,
        height=4.0,
        cell_size=0.1,
        section_size=0.5,
        cell_color=(225, 225, 225),
        section_color=(190, 190, 190),
        plane_color=(245, 245, 245),
        plane_opacity=1.0,
        position=(float(center[0]), float(center[1]), playback.floor),
    )


class _Bodies:
    """A frame for every body that has shapes, with its shapes and regions below it."""

    def __init__(self, scene: SceneApi, playback: Playback) -> None:
        self._playback = playback
        model = playback.model
        count = max(2, int(np.ceil(RATE * playback.duration)) + 1)
        self._times = np.linspace(0.0, playback.duration, count)
        self._frames = playback.frames(self._times)
        self._handles: dict[int, Any] = {}
        objects = playback.plan.task.scene.objects
        for body in range(model.nbody):
            geoms = np.flatnonzero(model.geom_bodyid == body)
            name = model.body(body).name
            if not len(geoms):
                continue
            of_object = name.startswith(OBJECT_PREFIX)
            node = "/objects/" + _node(name.removeprefix(OBJECT_PREFIX)) if of_object else "/robot/" + _node(name)
            self._handles[body] = scene.add_frame(node, show_axes=False, **self._pose(body, 0))
            for geom in geoms:
                _add_shape(scene, f"{node}/{geom}", playback, int(geom))
            if of_object:
                for region in objects[name.removeprefix(OBJECT_PREFIX)].affordance_regions:
                    movable = objects[name.removeprefix(OBJECT_PREFIX)].movable
                    _add_region(scene, f"{node}/{_node(region.affordance)}", region, opacity=0.55 if movable else 0.08)
        position = playback.plan.T_world_agent.apply([0.0, 0.36, 0.78])
        self._label = scene.add_label("/phase", self._text(0), position=tuple(position), anchor="bottom-center")

    def record(self, serializer: Any) -> None:
        """Play all bodies' motion into the recording."""
        frames = self._frames
        sent_position, sent_quaternion = frames.position[0].copy(), frames.quaternion_wxyz[0].copy()
        text = self._text(0)
        step = float(self._times[1] - self._times[0])
        for row in range(1, len(self._times)):
            serializer.insert_sleep(step)
            for body, handle in self._handles.items():
                pose = self._pose(body, row)
                if np.abs(frames.position[row, body] - sent_position[body]).max() > STILL_POSITION:
                    handle.position, sent_position[body] = pose["position"], frames.position[row, body]
                if np.abs(frames.quaternion_wxyz[row, body] - sent_quaternion[body]).max() > STILL_QUATERNION:
                    handle.wxyz, sent_quaternion[body] = pose["wxyz"], frames.quaternion_wxyz[row, body]
            if self._text(row) != text:
                text = self._label.text = self._text(row)
        serializer.insert_sleep(PAUSE)

    def _pose(self, body: int, row: int) -> dict[str, Any]:
        # Numbers of single precision leave zeros that compress well.
        position = self._frames.position[row, body].astype(np.float32)
        quaternion_wxyz = self._frames.quaternion_wxyz[row, body].astype(np.float32)
        return {"position": tuple(map(float, position)), "wxyz": tuple(map(float, quaternion_wxyz))}

    def _text(self, row: int) -> str:
        plan = self._playback.plan
        origin = " (learned from synthetic demonstrations)" if plan.task.model.synthetic else ""
        return f"{self._playback.label(float(self._times[row]))}{origin}"


def _node(name: str) -> str:
    """A name without what separates the nodes of a scene."""
    return name.replace("/", " ")


def _add_shape(scene: SceneApi, node: str, playback: Playback, geom: int) -> None:
    import mujoco

    model = playback.model
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    style: dict[str, Any] = {
        "color": tuple(round(255 * float(part)) for part in rgba[:3]),
        "opacity": None if rgba[3] >= 1.0 else float(rgba[3]),
        "position": tuple(map(float, model.geom_pos[geom])),
        "wxyz": tuple(map(float, model.geom_quat[geom])),
    }
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        scene.add_box(node, dimensions=2 * size, **style)
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        scene.add_icosphere(node, radius=float(size[0]), subdivisions=2, **style)
    elif kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        scene.add_icosphere(
            node, radius=1.0, subdivisions=2, scale=(float(size[0]), float(size[1]), float(size[2])), **style
        )
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        scene.add_cylinder(node, radius=float(size[0]), height=float(2 * size[1]), **style)
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        vertices, faces = _capsule(float(size[0]), float(size[1]))
        scene.add_mesh_simple(node, vertices, faces, **style)
    elif kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        first_face, face_count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        vertices = model.mesh_vert[first : first + count]
        scene.add_mesh_simple(node, vertices, model.mesh_face[first_face : first_face + face_count], **style)


def _capsule(
    radius: float, half_length: float
) -> tuple[Float32[np.ndarray, "vertices 3"], UInt32[np.ndarray, "faces 3"]]:
    """Vertices and faces of a capsule along z about the origin."""
    import trimesh

    mesh = trimesh.creation.capsule(height=2 * half_length, radius=radius, count=[20, 12])
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    vertices[:, 2] -= 0.5 * (vertices[:, 2].max() + vertices[:, 2].min())
    return vertices.astype(np.float32), np.asarray(mesh.faces, dtype=np.uint32)


def _add_region(scene: SceneApi, node: str, region: AffordanceRegion, opacity: float) -> None:
    """An ellipse, filled and outlined, and its name."""
    rotation = ellipse_rotation(region)
    angle = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    rim = np.column_stack([region.half_axes[0] * np.cos(angle), region.half_axes[1] * np.sin(angle), 0 * angle])
    around = np.arange(len(angle))
    following = np.roll(around, -1)
    faces = np.column_stack([np.zeros_like(around), 1 + around, 1 + following])
    position = region.center + LIFT * region.normal
    scene.add_mesh_simple(
        node,
        np.concatenate([[[0.0, 0.0, 0.0]], rim]).astype(np.float32),
        faces.astype(np.uint32),
        color=REGION_COLOR,
        opacity=opacity,
        side="double",
        cast_shadow=False,
        position=position,
        wxyz=rotation.as_quat(scalar_first=True),
    )
    scene.add_line_segments(
        f"{node}/outline",
        np.stack([rim, np.roll(rim, -1, axis=0)], axis=1).astype(np.float32),
        colors=REGION_COLOR,
        thickness=0.0015,
    )
    scene.add_label(f"{node}/name", region.affordance, font_screen_scale=0.8, anchor="bottom-center")
