"""Does every deviation from the paper earn its place? Each alone switched off, and switched on in the paper's way."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from rich.progress import track

from sbam.evaluation.cross_validation import evaluate_folds, leave_one_out
from sbam.evaluation.evaluate import default_cache, recordings_for
from sbam.evaluation.fold import FLYING_HANDS, Condition, FoldResult
from sbam.evaluation.tables import bootstrap_interval, mean_distance, relevant_distance
from sbam.learning.settings import LearningSettings
from sbam.planning.settings import PlanSettings

DEFAULT, PAPER = LearningSettings.default(), LearningSettings.paper()
PLAN = PlanSettings()

LEARNING_OFF = {
    "time by start and end only": {"time_alignment": "phase"},
    "time in seconds": {"time_alignment": "seconds"},
    "one order for all": {"variants": False},
    "no own-start pairs": {"own_start_pairs": False},
    "all pairs": {"pairs": "all"},
    "weights of the paper": {"mode": "paper"},
    "update rule of the paper": {"update_rule": "paper"},
    "supports from their centre": {"supports": "center"},
    "upright pairs of the model's type": {"upright_as_cartesian": False},
    "all samples": {"segmentation_rate": None},
    "strokes as they are": {"equalize_strokes": False},
}
"""Deviations of the learning, switched off; ``mode`` also brings the paper's damping, targets and rests."""

PLANNING_OFF = {
    "no damping": {"damping": 0.0},
    "no smoothness": {"smoothness": 0.0},
    "places whatever the start": {"slide_supports": False},
    "no proximity": {"proximity": 0.0},
    "lengths as learned": {"rigid_length": False},
}

PAPER_ON = {
    "paper + time by start and end": {"time_alignment": "phase"},
    "paper + events": {"time_alignment": "events"},
    "paper + events, variants": {"time_alignment": "events", "variants": True},
    "paper + own-start pairs": {"own_start_pairs": True},
    "paper + functional pairs": {"pairs": "functional"},
    "paper + our weights": {"mode": "default"},
    "paper + Welford": {"update_rule": "welford"},
    "paper + thinned": {"segmentation_rate": 12.5},
}

COLUMNS = {
    "poured": "poured over the cup [share]",
    "mouth-rim": "mouth - rim while pouring [mm]",
    "tilt": "pour_from: tilt error, rms [deg]",
    "strokes": "half-strokes",
    "turns": "turning points off by [mm]",
    "amplitude": "strokes' amplitude / person's",
}


def conditions(constraint: str, robot: str) -> list[Condition]:
    plans = [
        *((name, replace(DEFAULT, **change), PLAN) for name, change in LEARNING_OFF.items()),
        *((name, DEFAULT, replace(PLAN, **change)) for name, change in PLANNING_OFF.items()),
        *((f"pruned at {share}", DEFAULT, replace(PLAN, prune=share)) for share in (0.6, 0.75)),
        ("paper", PAPER, PLAN),
        *((name, replace(PAPER, **change), PLAN) for name, change in PAPER_ON.items()),
        *((f"paper + pruned at {share}", PAPER, replace(PLAN, prune=share)) for share in (0.6, 0.75)),
    ]
    return [
        Condition("default", constraint, DEFAULT, PLAN, robot),
        *(Condition(name, constraint, learning, planning, robot) for name, learning, planning in plans),
    ]


def dense_distance(result: FoldResult) -> float:
    return float(np.mean([pair.dense for pair in result.pairs]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=["pouring", "rolling"])
    parser.add_argument("--constraints", nargs="+", default=["cartesian"])
    parser.add_argument("--robot", default=FLYING_HANDS)
    parser.add_argument("--seed", type=int, default=0, help="of the synthetic demonstrations")
    parser.add_argument("--jobs", type=int, default=-1)
    parser.add_argument("--cache", type=Path, default=default_cache(), help="folder of finished folds")
    arguments = parser.parse_args()
    for task in arguments.tasks:
        folds = leave_one_out(recordings_for([task], arguments.seed))
        columns = {
            short: name
            for short, name in COLUMNS.items()
            if (task == "pouring") == (short in ("poured", "mouth-rim", "tilt"))
        }
        for constraint in arguments.constraints:
            print(
                f"\n{task}, {constraint}, {len(folds)} folds of synthetic demonstrations (seed {arguments.seed}), "
                f"{arguments.robot}; mm; difference of 'events' from default with 95 % interval\n"
            )
            head = ("condition", "second", "events", "relevant", "dense", *columns, "difference", "executed")
            print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
            base: dict[str, FoldResult] = {}
            for condition in track(conditions(constraint, arguments.robot), f"{task} {constraint}", transient=True):
                results = evaluate_folds([condition], folds, jobs=arguments.jobs, cache=arguments.cache)
                done = {result.test: result for result in results if result.executed}
                base = base or done
                print(
                    f"| {' | '.join(row(condition.name, list(done.values()), base, columns, len(folds)))} |", flush=True
                )


def row(
    name: str, done: list[FoldResult], base: dict[str, FoldResult], columns: dict[str, str], count: int
) -> list[str]:
    if not done:
        return [name, *("-" for _ in range(5 + len(columns))), f"0/{count}"]
    numbers = [
        np.mean([mean_distance(result, "seconds") for result in done]),
        np.mean([mean_distance(result) for result in done]),
        np.mean([relevant_distance(result) for result in done]),
        np.mean([dense_distance(result) for result in done]),
    ]
    texts = [f"{number:.1f}" for number in numbers]
    for measure in columns.values():
        found = [result.values[measure] for result in done if measure in result.values]
        texts.append(f"{np.mean(found):.2f}" if found else "-")
    both = [mean_distance(result) - mean_distance(base[result.test]) for result in done if result.test in base]
    low, high = bootstrap_interval(np.array(both)) if both else (np.nan, np.nan)
    change = f"{np.mean(both):+.1f} ({low:+.1f} to {high:+.1f})" if both else "-"
    return [name, *texts, change, f"{len(done)}/{count}"]


if __name__ == "__main__":
    main()
