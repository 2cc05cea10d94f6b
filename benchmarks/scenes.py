"""Plan many random scenes and measure whether the task is done: `python benchmarks/scenes.py --help`."""

from __future__ import annotations

import argparse
import os
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
import joblib
import numpy as np

import sbam
from sbam.errors import SbamError
from sbam.planning.placement.search import reach_where_it_stands
from sbam.tasks import (
    measure_pouring,
    measure_put_down,
    measure_rolling,
    random_pouring_scene,
    random_rolling_scene,
)


def run(task: str, constraint: str, seed: int, model: sbam.ActionModel, robot: str) -> dict[str, object]:
    scene = random_pouring_scene(seed) if task == "pouring" else random_rolling_scene(seed)
    begin = time.perf_counter()
    try:
        plan = sbam.plan(model, scene, robot=robot)
    except SbamError as error:
        miss = max(reach_where_it_stands(model, scene, robot).miss.values())
        why = f"out of reach by {1e3 * miss:.0f} mm" if miss else "within reach"
        return {
            "task": task,
            "constraint": constraint,
            "seed": seed,
            "problems": [f"{error} ({why})"],
            "values": {},
            "seconds": 0,
        }
    seconds = time.perf_counter() - begin
    measures = [measure_put_down(plan), measure_pouring(plan) if task == "pouring" else measure_rolling(plan)]
    return {
        "task": task,
        "constraint": constraint,
        "seed": seed,
        "problems": [*plan.problems, *(p for m in measures for p in m.problems)],
        "values": {k: v for m in measures for k, v in m.values.items()},
        "seconds": seconds,
        "stages": dict(plan.seconds),
        "verified": plan.ok,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=["pouring", "rolling"])
    parser.add_argument("--constraints", nargs="+", default=["cartesian", "cylindrical", "symbolic"])
    parser.add_argument("--robot", default="panda_dual")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the synthetic demonstrations")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    print(f"learned from the built-in synthetic demonstrations, seed {arguments.seed}; robot {arguments.robot}")
    for task in arguments.tasks:
        demonstrations = sbam.built_in_demonstrations(task, arguments.seed)
        for constraint in arguments.constraints:
            model = sbam.learn(demonstrations, constraint=constraint)
            jobs = (
                joblib.delayed(run)(task, constraint, seed, model, arguments.robot) for seed in range(arguments.scenes)
            )
            rows = joblib.Parallel(n_jobs=arguments.jobs)(jobs)
            done = [row for row in rows if not row["problems"]]
            verified = sum(bool(row.get("verified")) for row in rows)
            print(f"\n{task}, {constraint}: {len(done)} of {len(rows)} done, {verified} trajectories verified")
            for key in sorted({key for row in rows for key in row["values"]}):
                found = np.array([row["values"][key] for row in rows if key in row["values"]])
                print(f"  {key:48s} min {found.min():8.1f}  median {np.median(found):8.1f}  max {found.max():8.1f}")
            took = np.array([row["seconds"] for row in rows if row["seconds"]])
            if len(took):
                spread = f"min {took.min():8.2f}  median {np.median(took):8.2f}  max {took.max():8.2f}"
                print(f"  {'seconds per plan':48s} {spread}")
            for row in rows:
                for problem in row["problems"]:
                    print(f"  scene {row['seed']}: {problem}")


if __name__ == "__main__":
    main()
