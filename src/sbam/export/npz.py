"""``trajectory.npz``: NumPy arrays without pickled objects.

Arrays of format version 1 (N samples, n joints, K keypoints, P phases, M moved objects):

| key | shape | content |
|---|---|---|
| ``format_version`` | () | integer, 1 |
| ``time`` | (N,) | s, strictly increasing from 0 |
| ``joint_names`` | (n,) | text, the order of the columns |
| ``position``, ``velocity``, ``acceleration`` | (N, n) | rad, rad/s, rad/s^2 (m for prismatic joints) |
| ``model_time`` | (N,) | the same samples on the model's time axis, s |
| ``keypoint_time``, ``keypoint_index`` | (K,) | when the model's keypoints are passed, s, and the nearest sample |
| ``phase_hand``, ``phase_name``, ``phase_role`` | (P,) | text |
| ``phase_start``, ``phase_end`` | (P,) | s |
| ``object_names`` | (M,) | text |
| ``object_position`` | (N, M, 3) | m, world, z up |
| ``object_quaternion_wxyz`` | (N, M, 4) | unit quaternions, scalar first |
| ``meta`` | () | JSON text: see `Meta` |
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, FileVersionError
from sbam.plain import plain, pose_dict
from sbam.planning.motion.motion import Phase
from sbam.planning.plan import Plan
from sbam.planning.trajectory.trajectory import JointTrajectory

FORMAT_VERSION = 1
FILE = "trajectory.npz"
UNITS = {
    "time": "s",
    "position": "rad, or m for prismatic joints",
    "velocity": "rad/s, or m/s",
    "acceleration": "rad/s^2, or m/s^2",
    "object_position": "m",
}


class Meta(msgspec.Struct):
    """What the arrays do not hold.

    Attributes:
        task: name of the action model.
        robot: name of the robot.
        scene: name of the scene.
        synthetic: whether any demonstration behind it was synthetic.
        ok: whether the trajectory passed all its checks.
        problems: what is wrong, a sentence each.
        units: array -> unit.
        T_world_base: the robot's frame (x forward, y left, z up) in the world.
        standing_objects: object -> pose in the world, of those that do not move.
    """

    task: str
    robot: str
    scene: str
    synthetic: bool
    ok: bool
    problems: tuple[str, ...]
    units: dict[str, str]
    T_world_base: dict[str, Any]
    standing_objects: dict[str, dict[str, Any]]


@dataclass(frozen=True)
class SavedTrajectory:
    """What `trajectory.npz` holds.

    Attributes:
        trajectory: the timed joint trajectory.
        model_time: on the model's axis, s.
        keypoint_time: on the trajectory's axis, s.
        phases: what each hand does when.
        T_world_object: moved object -> poses.
        meta: names, units, the objects that stand still.
    """

    trajectory: JointTrajectory
    model_time: Float[np.ndarray, " samples"]
    keypoint_time: Float[np.ndarray, " keypoints"]
    phases: tuple[Phase, ...]
    T_world_object: Mapping[str, RigidTransform]
    meta: Meta


def encode(plan: Plan) -> Mapping[str, bytes]:
    """File name -> content."""
    trajectory, scene = plan.trajectory, plan.task.scene
    poses = plan.object_poses()
    count = len(trajectory.time)
    keypoint_time = np.interp(plan.task.model.keypoint_times, plan.model_time, trajectory.time)
    meta = Meta(
        task=plan.task.model.name,
        robot=plan.robot.name,
        scene=scene.name,
        synthetic=plan.task.model.synthetic,
        ok=plan.ok,
        problems=plan.problems,
        units=UNITS,
        T_world_base=pose_dict(plan.robot.T_world_base),
        standing_objects={name: pose_dict(pose) for name, pose in scene.T_world_object.items() if name not in poses},
    )
    arrays: dict[str, NDArray[Any]] = {
        "format_version": np.array(FORMAT_VERSION),
        "time": trajectory.time,
        "joint_names": np.array(trajectory.joint_names, dtype=str),
        "position": trajectory.position,
        "velocity": trajectory.velocity,
        "acceleration": trajectory.acceleration,
        "model_time": plan.model_time,
        "keypoint_time": keypoint_time,
        "keypoint_index": np.abs(trajectory.time - keypoint_time[:, None]).argmin(axis=1),
        "phase_hand": np.array([phase.hand for phase in plan.phases], dtype=str),
        "phase_name": np.array([phase.name for phase in plan.phases], dtype=str),
        "phase_role": np.array([phase.role for phase in plan.phases], dtype=str),
        "phase_start": np.array([phase.start for phase in plan.phases]),
        "phase_end": np.array([phase.end for phase in plan.phases]),
        "object_names": np.array(list(poses), dtype=str),
        "object_position": np.stack([T.translation for T in poses.values()], 1) if poses else np.empty((count, 0, 3)),
        "object_quaternion_wxyz": np.stack([quaternions_wxyz(T) for T in poses.values()], 1)
        if poses
        else np.empty((count, 0, 4)),
        "meta": np.array(msgspec.json.encode(plain(msgspec.to_builtins(meta))).decode()),
    }
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return {FILE: content.getvalue()}


def quaternions_wxyz(T: RigidTransform) -> Float[np.ndarray, "samples 4"]:
    """Unit quaternions, scalar first, whose signs do not jump along time."""
    quaternions = np.array(T.rotation.as_quat(scalar_first=True))
    flips = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    quaternions[1:] *= np.cumprod(flips)[:, None]
    return quaternions


def read_trajectory_npz(path: str | Path) -> SavedTrajectory:
    """Read a file that `sbam.export.write_plan` wrote.

    Raises:
        FileFormatError: if it is not such a file, or an array is missing, not finite or of wrong shape.
        FileVersionError: if a later version wrote it.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except (ValueError, OSError, EOFError, KeyError, zipfile.BadZipFile, NotImplementedError) as error:
        raise FileFormatError(path, "", f"not a readable NPZ file: {error}", "arrays saved without pickle") from error
    reader = _Arrays(path, arrays)
    version = int(reader.numbers("format_version", ()))
    if version > FORMAT_VERSION:
        raise FileVersionError(path, version, FORMAT_VERSION)
    joints, objects = reader.texts("joint_names"), reader.texts("object_names")
    time = reader.numbers("time", (None,))
    count = len(time)
    trajectory = JointTrajectory(
        joints, time, *(reader.numbers(key, (count, len(joints))) for key in ("position", "velocity", "acceleration"))
    )
    positions = reader.numbers("object_position", (count, len(objects), 3))
    quaternions = reader.numbers("object_quaternion_wxyz", (count, len(objects), 4))
    hands, names, roles = (reader.texts(f"phase_{key}") for key in ("hand", "name", "role"))
    starts, ends = (reader.numbers(f"phase_{key}", (len(hands),)).tolist() for key in ("start", "end"))
    phases = [
        Phase("left" if hand == "left" else "right", name, start, end, role)
        for hand, name, start, end, role in zip(hands, names, starts, ends, roles, strict=True)
    ]
    try:
        meta = msgspec.json.decode(str(reader.array("meta").item()), type=Meta)
    except (msgspec.DecodeError, ValueError) as error:
        raise FileFormatError(path, "meta", str(error), "JSON text") from error
    return SavedTrajectory(
        trajectory=trajectory,
        model_time=reader.numbers("model_time", (count,)),
        keypoint_time=reader.numbers("keypoint_time", (None,)),
        phases=tuple(phases),
        T_world_object={
            name: RigidTransform.from_components(
                positions[:, k], Rotation.from_quat(quaternions[:, k], scalar_first=True)
            )
            for k, name in enumerate(objects)
        },
        meta=meta,
    )


class _Arrays:
    """Arrays of a file, checked on access."""

    def __init__(self, path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
        self._path, self._arrays = path, arrays

    def array(self, key: str) -> NDArray[Any]:
        if key not in self._arrays:
            known = ", ".join(self._arrays) or "none"
            raise FileFormatError(self._path, key, f"is missing (arrays: {known})", "a file written by `sbam plan`")
        return self._arrays[key]

    def numbers(self, key: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
        array = self.array(key)
        fits = array.ndim == len(shape) and all(n is None or n == m for n, m in zip(shape, array.shape, strict=True))
        if not fits or array.dtype.kind not in "fiu":
            wanted = ", ".join("any" if n is None else str(n) for n in shape)
            problem = f"is {array.dtype} of shape {array.shape}"
            raise FileFormatError(self._path, key, problem, f"numbers of shape ({wanted})")
        if not np.isfinite(array).all():
            raise FileFormatError(self._path, key, "holds numbers that are not finite")
        return array

    def texts(self, key: str) -> tuple[str, ...]:
        array = self.array(key)
        if array.ndim != 1 or (array.dtype.kind != "U" and array.size):
            raise FileFormatError(self._path, key, f"is {array.dtype} of shape {array.shape}", "a list of text")
        return tuple(str(name) for name in array)
