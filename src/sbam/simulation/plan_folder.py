"""Reading back what `sbam plan` wrote, as far as physics needs it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from sbam.errors import FileFormatError, SimulationError
from sbam.export import read_trajectory_npz
from sbam.robots.options import options_text
from sbam.robots.registry import ROBOTS, load_robot
from sbam.scene import ObjectLibrary, load_scene
from sbam.tasks.action import Action, Arms, Grip

TRAJECTORY, REPORT, SCENE = "trajectory.npz", "report.json", "scene.yaml"


class _Pose(msgspec.Struct):
    position: tuple[float, float, float]
    quaternion_wxyz: tuple[float, float, float, float]

    def transform(self) -> RigidTransform:
        return RigidTransform.from_components(
            self.position, Rotation.from_quat(self.quaternion_wxyz, scalar_first=True)
        )


class _Grasp(msgspec.Struct):
    hand: Literal["left", "right"]
    role: str
    object: str
    region: str
    T_object_tcp: _Pose


class _Robot(msgspec.Struct):
    name: str
    T_world_base: _Pose
    file: str = ""
    options: dict[str, float] = {}


class _Model(msgspec.Struct):
    name: str


class _Report(msgspec.Struct):
    robot: _Robot
    roles: dict[str, str]
    grasps: list[_Grasp]
    model: _Model


def read_plan_folder(folder: str | Path, library: ObjectLibrary | None = None) -> Action:
    """The action of a plan that was written into a folder.

    Args:
        folder: with ``trajectory.npz``, ``report.json`` and ``scene.yaml``.
        library: models of its objects; by default the built-in ones.

    Raises:
        SimulationError: if a file is missing.
        FileFormatError: if a file is not what `sbam plan` writes, or the robot has other joints.
        UnknownNameError: if the library lacks an object, or the robot is not known any more.
    """
    folder = Path(folder)
    missing = [name for name in (TRAJECTORY, REPORT, SCENE) if not (folder / name).is_file()]
    if missing:
        raise SimulationError(
            f"{folder} lacks {', '.join(missing)}: give the folder that `sbam plan -o` wrote with npz"
        )
    try:
        report = msgspec.json.decode((folder / REPORT).read_bytes(), type=_Report)
    except (msgspec.DecodeError, OSError) as error:
        raise FileFormatError(folder / REPORT, "", str(error), "the report of `sbam plan`") from error
    saved = read_trajectory_npz(folder / TRAJECTORY)
    scene = load_scene(folder / SCENE, library)
    known = report.robot.name in ROBOTS or not report.robot.file
    source = report.robot.name if known else report.robot.file
    options = options_text(report.robot.options)
    robot = load_robot(f"{source}:{options}" if options else source).placed(report.robot.T_world_base.transform())
    if robot.joint_names != saved.trajectory.joint_names:
        found, wanted = ", ".join(saved.trajectory.joint_names), ", ".join(robot.joint_names)
        raise FileFormatError(folder / TRAJECTORY, "joint_names", f"are {found}", wanted)
    grips = []
    for grasp in report.grasps:
        phases = {p.name: p for p in saved.phases if p.hand == grasp.hand and p.role == grasp.role}
        regions = {region.name: region for region in scene.objects[grasp.object].grasp_regions}
        if not {"grasp", "manipulate", "place"} <= set(phases) or grasp.region not in regions:
            where = f"grasp of {grasp.object} by the {grasp.hand} hand"
            raise FileFormatError(folder / REPORT, where, "has no phases or no region", "files of one plan")
        grips.append(
            Grip(
                hand=grasp.hand,
                object=grasp.object,
                T_object_tcp=grasp.T_object_tcp.transform(),
                width=regions[grasp.region].width,
                start=phases["manipulate"].start,
                end=phases["manipulate"].end,
                closing=phases["grasp"].start,
                opened=phases["place"].end,
            )
        )
    return Action(
        name=f"{report.model.name} in {scene.name} by {robot.name}",
        scene=scene,
        roles=report.roles,
        time=np.asarray(saved.trajectory.time),
        T_world_object=saved.T_world_object,
        arms=Arms(robot, saved.trajectory, tuple(grips)),
    )
