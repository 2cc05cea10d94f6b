"""Optimising keypoints: the default solver against the paper's, on the same objective, in the same run.

Thirty keypoints, ten pairs of regions, two Panda arms, the objects in the hands: `python benchmarks/planning.py`.
"""

from __future__ import annotations

import argparse
import os
import platform
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np

import sbam
from sbam.evaluation import random_pouring_scene
from sbam.planning.build import build_problem
from sbam.planning.problem import Problem
from sbam.planning.settings import PlanSettings
from sbam.planning.solvers.nelder_mead import solve_nelder_mead
from sbam.planning.solvers.whole_trajectory import solve_whole_trajectory
from sbam.planning.task import bind

KEYPOINTS, REPEATS = 30, 5


def problem_of(constraint: str, mode: str, seed: int) -> tuple[Problem, np.ndarray]:
    """The problem with the pairs of a learning mode, and the configuration that holds the objects at their start."""
    demonstrations = sbam.built_in_demonstrations("pouring", seed)
    scene = random_pouring_scene(seed)
    grasped = sbam.plan(sbam.learn(demonstrations), scene, robot="panda_dual")
    model = sbam.learn(demonstrations, constraint=constraint, mode=mode)
    times = np.linspace(0.0, model.duration, KEYPOINTS)
    grasps = {key: grasp.T_object_tcp for key, grasp in grasped.grasps.items()}
    task = bind(model, scene)
    return build_problem(task, grasped.robot, grasps, PlanSettings(), times), grasped.solution.configurations[0]


def floor(problem: Problem, start: np.ndarray) -> float:
    """Seconds for kinematics and Jacobians of all keypoints alone."""
    q = np.tile(start, (problem.count, 1))
    seconds = []
    for _ in range(50):
        begin = time.perf_counter()
        state = problem.state(q)
        _ = state.region_jacobian
        seconds.append(time.perf_counter() - begin)
    return min(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--constraints", nargs="+", default=["cartesian", "cylindrical", "symbolic"])
    parser.add_argument(
        "--modes", nargs="+", default=["paper", "default"], help="learning modes, which set the objective"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--without-paper-solver", action="store_true", help="it takes minutes")
    arguments = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, one used; synthetic demonstrations, seed {arguments.seed}")
    print(f"{KEYPOINTS} keypoints, panda_dual; seconds of wall time (median of {REPEATS} for the default solver)")
    print("objective   constraint    pairs   floor ms   default s    paper s    ratio   default J    paper J")
    for mode in arguments.modes:
        for constraint in arguments.constraints:
            problem, start = problem_of(constraint, mode, arguments.seed)
            pairs = sum(len(term.groups()) for term in problem.terms if term.name == "similarity")
            starts = [start]
            found = [solve_whole_trajectory(problem, starts) for _ in range(REPEATS)]
            seconds = float(np.median([solution.seconds for solution in found]))
            row = f"{mode:10s}  {constraint:12s}  {pairs:5d}  {1e3 * floor(problem, start):9.2f}  {seconds:10.3f}"
            if arguments.without_paper_solver:
                print(f"{row}  {'':9s}  {'':7s}  {found[0].objective:10.2f}", flush=True)
                continue
            paper = solve_nelder_mead(problem, start)
            print(
                f"{row}  {paper.seconds:9.1f}  {paper.seconds / seconds:7.0f}  {found[0].objective:10.2f}  "
                f"{paper.objective:9.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
