"""A real recording as the only demonstration, executed where it was recorded and where things stand elsewhere.

The recordings are third-party and not part of the project: `python benchmarks/real_recordings.py FOLDER` with the
folder that holds `kit_bimanual` and `mmlfd_pouring` (default: the environment variable SBAM_DATA).
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from scipy.spatial.transform import RigidTransform

import sbam
from sbam.errors import SbamError
from sbam.tasks import GeometryResult, measure_pouring, measure_put_down, measure_rolling
from sbam.tasks.pouring.geometry import mouth_path

MOVED = 0.10  # m
POUR, ROLL = "Pour_files_motions_2967_Pour1_cs_ms_0_20l_04", "RollOut_files_motions_3113_Roll1_dough_start_07"


def displaced(scene: sbam.Scene, names: Sequence[str], right: float, forward: float) -> sbam.Scene:
    """The scene with some objects moved in the agent's axes, m."""
    shift = RigidTransform.from_translation(scene.T_world_agent.rotation.apply([right, forward, 0.0]))
    poses = {name: shift * pose if name in names else pose for name, pose in scene.T_world_object.items()}
    return replace(scene, T_world_object=poses)


def demonstrated(demonstration: sbam.Demonstration, bottle: str, cup: str) -> str:
    """What a person's own pour measures, by the same rules."""
    library = sbam.ObjectLibrary.built_in()
    rim = demonstration.T_world_object[cup].apply(library[cup].region("pour into").center)
    mouth = mouth_path(library[bottle], demonstration.T_world_object[bottle], rim)
    aside, above = 1e3 * mouth.aside[mouth.may_flow], 1e3 * mouth.above[mouth.may_flow]
    return f"mouth aside, worst {aside.max():.0f} mm, above {above.min():.0f} to {above.max():.0f} mm"


def report(
    name: str, model: sbam.ActionModel, scene: sbam.Scene, measures: Sequence[Callable[..., GeometryResult]]
) -> None:
    begin = time.perf_counter()
    try:
        plan = sbam.plan(model, scene, robot="panda_dual")
    except SbamError as error:
        print(f"  {name:34s} {model.constraint:12s} not planned: {error}")
        return
    found = [measure(plan) for measure in measures]
    values = {key: value for measure in found for key, value in measure.values.items() if "put down" not in key}
    problems = [*plan.problems, *(problem for measure in found for problem in measure.problems)]
    shown = ", ".join(f"{key} {value:.0f}" for key, value in values.items())
    print(f"  {name:34s} {model.constraint:12s} {time.perf_counter() - begin:4.1f} s  {shown}")
    for problem in problems:
        print(f"    PROBLEM {problem}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    default = os.environ.get("SBAM_DATA", Path(__file__).parents[2] / "shared" / "data")
    parser.add_argument("folder", type=Path, nargs="?", default=default)
    parser.add_argument("--constraints", nargs="+", default=["cartesian", "cylindrical", "symbolic"])
    arguments = parser.parse_args()
    kit, mmlfd = arguments.folder / "kit_bimanual", arguments.folder / "mmlfd_pouring"
    if not kit.is_dir():
        print(f"no recordings at {kit}; name their folder, or set SBAM_DATA")
        return
    print("real recordings, executed on panda_dual")
    tasks = (
        (
            "KIT Pour",
            kit / "Pour_files_motions_2967_Pour1_cs_ms_0_20l_04.xml",
            ("cup_small", "milk_small"),
            measure_pouring,
        ),
        ("KIT RollOut", kit / "RollOut_files_motions_3113_Roll1_dough_start_07.xml", ("rolling_pin",), measure_rolling),
    )
    for title, path, objects, measure in tasks:
        demonstrations = list(sbam.load(path))
        scene = sbam.scene_from_demonstration(demonstrations[0])
        for constraint in arguments.constraints:
            model = sbam.learn(demonstrations, constraint=constraint)
            measures = (measure_put_down, measure)
            report(f"{title}, own scene", model, scene, measures)
            diagonal = MOVED / 2**0.5
            report(f"{title}, all 10 cm away", model, displaced(scene, objects, diagonal, -diagonal), measures)
            if len(objects) > 1:
                report(f"{title}, carton 10 cm right", model, displaced(scene, objects[1:], MOVED, 0.0), measures)
    demonstrations = [demonstration for path in sorted(mmlfd.glob("*.csv")) for demonstration in sbam.load(path)]
    scene = sbam.scene_from_demonstration(demonstrations[0])
    for demonstration in demonstrations:
        print(f"  {demonstration.name} as the person did it: {demonstrated(demonstration, 'bottle', 'mug')}")
    for constraint in arguments.constraints:
        model = sbam.learn(demonstrations, constraint=constraint)
        report(f"MMLfD, {len(demonstrations)} pours, one hand", model, scene, (measure_put_down, measure_pouring))


if __name__ == "__main__":
    main()
