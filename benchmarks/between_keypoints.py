"""What runs between keypoints, and how near that is to people: `python benchmarks/between_keypoints.py --help`.

Some demonstrations are left out, one after the other. *Own keypoints*: the poses that the person left out had at the
model's keypoints are joined by each method, and compared with what the person did in between. *Executed*: the action is
planned for hands without arms where the person began. *Joints*: planned for a robot, how far its hands stray.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from scipy.spatial.transform import RigidTransform

import sbam
from sbam.errors import SbamError
from sbam.evaluation.executed_motion import flight
from sbam.evaluation.person import person_motion
from sbam.planning.bind import bind
from sbam.planning.motion.object_path import acting_point, object_path, shapes_of

STEP = 0.02  # s


def differences(person: RigidTransform, found: RigidTransform, point: np.ndarray) -> list[float]:
    """Mean and largest distance of a point, mm, and angle, degrees, where the person's object is on its way."""
    path = person.apply(point)
    away = np.linalg.norm(path - path[0], axis=1) > 0.01
    off = 1e3 * np.linalg.norm(found.apply(point) - path, axis=1)[away]
    angle = np.rad2deg((found.rotation.inv() * person.rotation).magnitude())[away]
    return [off.mean(), off.max(), angle.mean(), angle.max()]


def compare(demonstrations: Sequence[sbam.Demonstration], left_out: int) -> dict[tuple[str, str], list[list[float]]]:
    """(measure, method) -> one row per moved object."""
    test = demonstrations[left_out]
    model = sbam.learn([one for index, one in enumerate(demonstrations) if index != left_out])
    task = bind(model, sbam.scene_from_demonstration(test))
    model = task.model  # it may leave out demonstrations that take their objects in another order
    person = person_motion(test, model, sbam.ObjectLibrary.built_in())
    clock = STEP * np.arange(round(model.duration / STEP) + 1)
    did, did_at = (person.poses_at(person.aligned(times)) for times in (clock, model.keypoint_times))
    rows: dict[tuple[str, str], list[list[float]]] = {}
    for method in ("poses", "primitive"):
        shapes = shapes_of(task) if method == "primitive" else {}
        executed = flight(task, sbam.PlanSettings(between=method))
        samples = np.searchsorted(executed.model_time, clock).clip(0, len(executed.model_time) - 1)
        for moved in task.moved:
            role, point = moved.role, acting_point(task, moved)
            lift, place = person.poses_at(person.aligned(np.array([moved.lift, moved.place])))[role]
            theirs = replace(moved, start=lift, put_down=place)
            joined = object_path(task, theirs, model.keypoint_times, did_at[role], clock, shapes.get(role)).pose
            rows.setdefault(("own keypoints", method), []).append(differences(did[role], joined, point))
            went = executed.T_agent_object[task.binding[role]][samples]
            rows.setdefault(("executed", method), []).append(differences(did[role], went, point))
    return rows


def straying(model: sbam.ActionModel, scene: sbam.Scene, robot: str) -> None:
    """Print how well each method keeps the objects' paths and two-handed grasps."""
    for method in ("poses", "primitive", "splines", "lines"):
        try:
            plan = sbam.plan(model, scene, robot, sbam.PlanSettings(between=method, avoid_collisions=False))
        except SbamError as error:
            print(f"  {method:10s} not planned: {error}")
            continue
        worst = {
            name: max((1e3 * check.worst for check in plan.checks if name in check.name), default=0.0)
            for name in ("follows its path", "keeps its place")
        }
        shown = ", ".join(f"{name} within {value:.1f} mm" for name, value in worst.items())
        print(f"  {method:10s} {shown}; {plan.trajectory.duration:.1f} s; {'verified' if plan.ok else 'not verified'}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", nargs="*", help="of one task; default: the built-in tasks, which are synthetic")
    parser.add_argument("--folds", type=int, default=4)
    parser.add_argument("--robot", default="panda_dual")
    arguments = parser.parse_args()
    for name in arguments.recordings[:1] or ("built-in:pouring", "built-in:rolling"):
        demonstrations = list(sbam.load(arguments.recordings or [name]))
        kind = "synthetic" if demonstrations[0].synthetic else "recorded"
        print(f"{name}: {len(demonstrations)} {kind} demonstrations; mean (largest) mm, mean (largest) degrees")
        rows: dict[tuple[str, str], list[list[float]]] = {}
        for left_out in np.unique(np.linspace(0, len(demonstrations) - 1, arguments.folds).round().astype(int)):
            for key, found in compare(demonstrations, int(left_out)).items():
                rows.setdefault(key, []).extend(found)
        for (measure, method), found in sorted(rows.items()):
            off, most, angle, most_angle = np.mean(found, axis=0)
            print(
                f"  {measure:14s} {method:10s} {off:6.1f} ({most:6.1f})   {angle:5.1f} ({most_angle:5.1f})", flush=True
            )
        if not arguments.recordings:
            scene = "built-in:pouring_new_layout" if "pouring" in name else "built-in:rolling"
            print(f"  joints of {arguments.robot} in {scene}")
            straying(sbam.learn(demonstrations), sbam.load_scene(scene), arguments.robot)


if __name__ == "__main__":
    main()
