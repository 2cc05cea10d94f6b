"""Optimising keypoints: the default solver against the paper's and against SLSQP, on the same objective.

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
from measuring import floor, grasped, least_seconds, peak_megabytes, problem_of, with_pairs
from scipy.optimize import minimize

import sbam
from sbam.planning.keypoints.problem import Problem
from sbam.planning.keypoints.solvers.linearization import evaluate, linearize
from sbam.planning.keypoints.solvers.nelder_mead import solve_nelder_mead
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory
from sbam.planning.keypoints.state import State
from sbam.planning.keypoints.terms import Smoothing
from sbam.tasks import random_pouring_scene

KEYPOINTS, REPEATS = 30, 7
NEARLY_EXACT = Smoothing(1e-6, 1e-6, 1e-9)  # SLSQP needs a derivative everywhere


def solve_slsqp(problem: Problem, start: np.ndarray) -> tuple[float, float]:
    """Objective and seconds of scipy's SLSQP with the analytic gradient, keypoint by keypoint as in the paper."""
    begin = time.process_time()
    previous: State | None = None
    configurations = []
    for k in range(problem.count):
        alone = problem.at(k, previous)

        def merit(q: np.ndarray, alone: Problem = alone) -> tuple[float, np.ndarray]:
            at = evaluate(alone, alone.state(alone.project(q[None])), NEARLY_EXACT)
            return at.merit, linearize(alone, at, NEARLY_EXACT).gradient[0]

        bounds = list(zip(alone.lower, alone.upper, strict=True))
        start = minimize(merit, start, jac=True, method="SLSQP", bounds=bounds, options={"maxiter": 100}).x
        previous = alone.state(alone.project(start[None]))
        configurations.append(previous.configurations[0])
    seconds = time.process_time() - begin
    return problem.objective(problem.state(np.array(configurations))), seconds


def compare(constraints: list[str], modes: list[str], seed: int, *, with_paper_solver: bool) -> None:
    """The table of solvers."""
    print(
        f"{KEYPOINTS} keypoints, panda_dual; processor seconds from one posture (default: least of {REPEATS}), "
        "objective J; SLSQP and the paper's solver go keypoint by keypoint"
    )
    print(
        "objective  constraint   pairs  floor ms  default s  / floor  solves  SLSQP s  paper s  "
        "default J   SLSQP J   paper J"
    )
    for mode in modes:
        for constraint in constraints:
            problem, start = problem_of(constraint, mode, seed)  # pyright: ignore[reportArgumentType]
            pairs = sum(len(term.groups()) for term in problem.terms if term.name == "similarity")
            solution = solve_whole_trajectory(problem, [start])
            seconds = least_seconds(lambda p=problem, s=start: solve_whole_trajectory(p, [s]), REPEATS)
            least = floor(problem, start)
            slsqp, slsqp_seconds = solve_slsqp(problem, start)
            row = (
                f"{mode:9s}  {constraint:11s}  {pairs:5d}  {1e3 * least:8.2f}  {seconds:9.3f}  {seconds / least:7.0f}  "
                f"{solution.iterations:6d}  {slsqp_seconds:7.2f}"
            )
            if not with_paper_solver:
                print(f"{row}  {'':7s}  {solution.objective:9.2f} {slsqp:9.2f}", flush=True)
                continue
            begin = time.process_time()
            paper = solve_nelder_mead(problem, start)
            print(
                f"{row}  {time.process_time() - begin:7.1f}  {solution.objective:9.2f} {slsqp:9.2f} "
                f"{paper.objective:9.2f}",
                flush=True,
            )


def growth(seed: int) -> None:
    """How the default solver's time and memory grow."""
    print("\nGrowth (Cartesian, the paper's objective): milliseconds, solves, MB at most")
    for keypoints in (10, 30, 100, 300):
        _grown(f"{keypoints} keypoints", *problem_of("cartesian", "paper", seed, keypoints))
    problem, start = problem_of("cartesian", "paper", seed)
    for pairs in (5, 10, 20, 40):
        _grown(f"{pairs} pairs", with_pairs(problem, pairs), start)


def _grown(what: str, problem: Problem, start: np.ndarray) -> None:
    solution = solve_whole_trajectory(problem, [start])
    seconds = least_seconds(lambda: solve_whole_trajectory(problem, [start]))
    memory = peak_megabytes(lambda: solve_whole_trajectory(problem, [start]))
    print(f"  {what:16s} {1e3 * seconds:8.1f}  {solution.iterations:4d}  {memory:6.1f}", flush=True)


def whole_plan(seed: int) -> None:
    """Seconds of each stage of a plan, and its memory."""
    model = sbam.learn(sbam.built_in_demonstrations("pouring", seed))
    scene, robot = random_pouring_scene(seed), grasped(seed).robot

    def run() -> sbam.Plan:
        return sbam.plan(model, scene, robot=robot)

    plan = run()
    seconds = least_seconds(run)
    stages = ", ".join(f"{name} {taken:.2f}" for name, taken in plan.seconds.items())
    print(f"\nA whole plan of pouring: {seconds:.2f} processor seconds, {peak_megabytes(run):.0f} MB at most")
    print(f"  wall seconds of its stages: {stages}")


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
    compare(
        arguments.constraints, arguments.modes, arguments.seed, with_paper_solver=not arguments.without_paper_solver
    )
    growth(arguments.seed)
    whole_plan(arguments.seed)


if __name__ == "__main__":
    main()
