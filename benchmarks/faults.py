"""The two faults of the paper's executions, for its way and ours: `python benchmarks/faults.py --help`.

An abrupt move at the end, and a carton tilted beside the cup; at the speed of the demonstrations.
"""

from __future__ import annotations

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np

import sbam
from sbam.errors import SbamError
from sbam.evaluation.executed_motion import ExecutedMotion
from sbam.evaluation.person import person_motion
from sbam.planning.bind import bind
from sbam.planning.keypoints.objective import build_problem
from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead
from sbam.planning.start import in_agent_frame
from sbam.tasks import random_pouring_scene
from sbam.tasks.faults import measure_faults

CONDITIONS = (("paper", "paper"), ("paper", "default"), ("default", "default"))
"""How it is learned, and how it is solved."""


def as_demonstrated(model: sbam.ActionModel, demonstration: sbam.Demonstration) -> ExecutedMotion:
    """A demonstration as if it were an execution of the model in its own scene."""
    library = sbam.ObjectLibrary.built_in()
    clock = np.linspace(0.0, model.duration, round(100 * model.duration) + 1)
    person = person_motion(demonstration, model, library)
    poses = person.poses_at(person.aligned(clock))
    task = bind(model, sbam.scene_from_demonstration(demonstration))
    paths = {moved.name: poses[moved.role] for moved in task.moved}
    return ExecutedMotion(task, poses, clock, clock, paths, 0.0, None, None, ())


def as_the_paper(model: sbam.ActionModel, scene: sbam.Scene, robot: str) -> ExecutedMotion:
    """Solved as in the paper with the grasps of our plan, its joints interpolated linearly between keypoints."""
    ours = sbam.plan(model, scene, robot)
    grasps = {key: grasp.T_object_tcp for key, grasp in ours.grasps.items()}
    problem = build_problem(ours.task, in_agent_frame(ours.robot), grasps, sbam.PlanSettings(solver="paper"))
    solution = solve_nelder_mead(problem, ours.solution.configurations[0])
    times = model.keypoint_times
    clock = np.linspace(0.0, model.duration, round(100 * model.duration) + 1)
    joints = np.stack([np.interp(clock, times, column) for column in solution.configurations.T], axis=-1)
    at_keypoints = problem.state(solution.configurations).object_poses()
    poses = problem.state(joints).object_poses()
    paths = {moved.name: poses[moved.role] for moved in ours.task.moved}
    return ExecutedMotion(ours.task, at_keypoints, clock, clock, paths, solution.objective, None, None, ())


def row(found: list[list[float]]) -> str:
    """Medians and largest values."""
    if not found:
        return ""
    end, before, beside = np.array(found).T
    return (
        f"{np.median(end):8.0f} (most {end.max():5.0f})   {np.median(before):12.0f}   "
        f"{np.median(beside):6.2f} (most {beside.max():.2f})"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="panda_dual")
    parser.add_argument("--scenes", type=int, default=3)
    parser.add_argument("--constraints", nargs="+", default=["cartesian", "cylindrical", "symbolic"])
    parser.add_argument("--seed", type=int, default=0, help="of the synthetic demonstrations")
    parser.add_argument("--without-paper-solver", action="store_true", help="it takes a minute a scene")
    arguments = parser.parse_args()
    print(f"synthetic demonstrations of pouring, seed {arguments.seed}; {arguments.robot}, {arguments.scenes} scenes")
    print("learned  solved   constraint    planned  speed at the end, mm/s   before, mm/s   tilted beside the cup, s")
    demonstrations = sbam.built_in_demonstrations("pouring", arguments.seed)
    people = [list(measure_faults(as_demonstrated(sbam.learn(demonstrations), one)).values()) for one in demonstrations]
    print(f"the demonstrations themselves              {row(people)}")
    for mode, solver in CONDITIONS:
        if solver == "paper" and arguments.without_paper_solver:
            continue
        for constraint in arguments.constraints:
            model = sbam.learn(demonstrations, constraint=constraint, mode=mode)
            found = []
            for scene in range(arguments.scenes):
                try:
                    execute = as_the_paper if solver == "paper" else sbam.plan
                    motion = execute(model, random_pouring_scene(scene), arguments.robot)
                except SbamError as error:
                    print(f"  scene {scene}: {error}")
                    continue
                found.append(list(measure_faults(motion).values()))
            print(
                f"{mode:8s} {solver:8s} {constraint:12s}  {len(found)} of {arguments.scenes}  {row(found)}", flush=True
            )


if __name__ == "__main__":
    main()
