"""How natural the arms' postures are, and what that costs: `python benchmarks/human_likeness.py --help`.

Without t_h, with it in the form for any robot, and with SOA_q over ARMAR's joints. Means over keypoints and scenes.
"""

from __future__ import annotations

import argparse
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np

import sbam
from sbam.errors import SbamError
from sbam.planning.report import plan_report
from sbam.robots.human_likeness import PERSON_SWIVEL_DEG
from sbam.tasks import random_pouring_scene, random_rolling_scene

FORMS = (
    ("without t_h", {"human_likeness": 0.0}),
    ("directions", {"posture": "directions"}),
    ("joints", {"posture": "joints", "human_likeness": 1.0}),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", nargs="+", default=["armar6", "armar7"])
    parser.add_argument("--tasks", nargs="+", default=["pouring", "rolling"])
    parser.add_argument("--constraint", default="cartesian")
    parser.add_argument("--scenes", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0, help="of the synthetic demonstrations")
    arguments = parser.parse_args()
    print(f"synthetic demonstrations, seed {arguments.seed}; {arguments.scenes} random scenes; degrees but for t_s")
    print(f"people's swivel angles: left {PERSON_SWIVEL_DEG['left']:+.0f}, right {PERSON_SWIVEL_DEG['right']:+.0f}")
    print("robot    task     t_h          weight  ok      upper arm L/R   forearm L/R   swivel L/R    SOA_q L/R    t_s")
    for task in arguments.tasks:
        model = sbam.learn(sbam.built_in_demonstrations(task, arguments.seed), constraint=arguments.constraint)
        scene_of = random_pouring_scene if task == "pouring" else random_rolling_scene
        for robot in arguments.robots:
            for name, form in FORMS:
                found, similarity, ok = [], [], 0
                for seed in range(arguments.scenes):
                    try:
                        plan = sbam.plan(model, scene_of(seed), robot, sbam.PlanSettings(**form))
                    except SbamError:
                        continue
                    ok += plan.ok
                    report = plan_report(plan)["human_likeness"]
                    keys = ("upper_arm_deg", "forearm_deg", "swivel_deg", "soa_q")
                    found.append([[np.mean(arm[key] or [np.nan]) for key in keys] for arm in report["arms"]])
                    similarity.append(sum(cost.sum() for cost in plan.solution.terms["similarity"].values()))
                if not found:
                    print(f"{robot:8s} {task:8s} {name:12s} none planned")
                    continue
                (left, right), weight = np.mean(found, axis=0), report["weight"]
                cells = "   ".join(f"{a:5.1f} /{b:6.1f}" for a, b in zip(left, right, strict=True))
                print(
                    f"{robot:8s} {task:8s} {name:12s} {weight:5.1f}  {ok} of {arguments.scenes}  {cells}  "
                    f"{np.mean(similarity):6.1f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
