"""Does every deviation from the paper earn its place? Each alone switched off, and switched on in the paper's way."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from rich.progress import track

from sbam.demonstrations.synthetic import PERSONS, generate_rolling
from sbam.evaluation.comparison import all_pairs, paired_difference
from sbam.evaluation.cross_validation import (
    evaluate_folds,
    learning_only_from,
    leave_one_out,
    train_and_test,
)
from sbam.evaluation.evaluate import default_cache, recordings_for
from sbam.evaluation.fold import FLYING_HANDS, Condition, Fold, FoldResult
from sbam.learning.settings import LearningSettings
from sbam.planning.settings import PlanSettings

DEFAULT, PAPER = LearningSettings.default(), LearningSettings.paper()
PLAN = PlanSettings()

LEARNING_OFF = {
    "time by start and end only": {"time_alignment": "phase"},
    "time in seconds": {"time_alignment": "seconds"},
    "time by lifts and places only": {"alignment_events": ()},
    "time without tilts": {"alignment_events": ("reversal",)},
    "time without reversals": {"alignment_events": ("tilt",)},
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
    "keypoint by keypoint": {"solver": "sequential"},
    "no damping": {"damping": 0.0},
    "no smoothness": {"smoothness": 0.0},
    "places whatever the start": {"slide_supports": False},
    "no proximity": {"proximity": 0.0},
    "lengths as learned": {"rigid_length": False},
    "pruned at 0.6": {"prune": 0.6},
    "pruned at 0.75": {"prune": 0.75},
}

ARMS_OFF = {
    "joints in lines between": {"between": "lines"},
    "joints in splines between": {"between": "splines"},
    "no avoidance": {"avoid_collisions": False},
}
"""What only arms have."""

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

PAPER_PLANS = {"paper + pruned at 0.6": {"prune": 0.6}, "paper + pruned at 0.75": {"prune": 0.75}}

UNEQUAL = "rolling_unequal"
STROKES = (5, 6, 5, 4, 5, 6, 5, 5)
"""How often the people of `UNEQUAL` roll."""

Column = Callable[[FoldResult], float | None]


def value(name: str) -> Column:
    return lambda result: result.values.get(name)


def seconds(stage: str) -> Column:
    return lambda result: result.seconds.get(stage)


NEARNESS: dict[str, Column] = {
    "second": all_pairs("same second"),
    "events": all_pairs("by events"),
    "relevant": all_pairs("relevant"),
    "dense": all_pairs("dense"),
}
OF_TASK: dict[str, dict[str, Column]] = {
    "pouring": {
        "poured": value("poured over the cup [share]"),
        "mouth-rim": value("mouth - rim while pouring [mm]"),
        "tilt": value("pour_from: tilt error, rms [deg]"),
        "axis": value("bottle's axis while pouring [deg]"),
    },
    "rolling": {
        "strokes": value("half-strokes"),
        "turns": value("turning points off by [mm]"),
        "amplitude": value("strokes' amplitude / person's"),
    },
}
OF_ARMS: dict[str, Column] = {
    "passed": lambda result: float(not result.problems),
    "travel": value("joints: travel [rad]"),
    "fastest": value("joints: largest speed at the demonstrations' pace [rad/s]"),
    "jerk": value("joints: log dimensionless jerk"),
    "lasts": value("duration of the motion [s]"),
}
TIMES = {"learn": seconds("learn"), "plan": seconds("plan")}


def folds_of(task: str, seed: int) -> tuple[Fold, ...]:
    """The paper's folds; with unequal strokes each demonstration of five is left out, the others are always learned."""
    if task != UNEQUAL:
        return leave_one_out(recordings_for([task], seed))
    people = [
        generate_rolling(100 * seed + index, PERSONS[index % len(PERSONS)], strokes=count)
        for index, count in enumerate(STROKES)
    ]
    return tuple(fold for fold, count in zip(leave_one_out(people), STROKES, strict=True) if count == 5)


def conditions(constraint: str, robot: str) -> list[Condition]:
    arms = {} if robot == FLYING_HANDS else ARMS_OFF
    settings = [
        ("default", DEFAULT, PLAN),
        *((name, replace(DEFAULT, **change), PLAN) for name, change in LEARNING_OFF.items()),
        *((name, DEFAULT, replace(PLAN, **change)) for name, change in (PLANNING_OFF | arms).items()),
        ("paper", PAPER, PLAN),
        *((name, replace(PAPER, **change), PLAN) for name, change in PAPER_ON.items()),
        *((name, PAPER, replace(PLAN, **change)) for name, change in PAPER_PLANS.items()),
    ]
    return [Condition(name, constraint, learning, planning, robot) for name, learning, planning in settings]


def row(
    results: Sequence[FoldResult], base: Sequence[FoldResult], columns: Mapping[str, Column], compared: Sequence[str]
) -> list[str]:
    """Means of the columns, and differences of some of them from the base, paired over folds."""
    done = [result for result in results if result.executed]
    texts = []
    for column in columns.values():
        found = [number for result in done if (number := column(result)) is not None]
        texts.append(f"{np.mean(found):.2f}" if found else "-")
    name, constraint = results[0].condition, results[0].constraint
    for column in compared:
        change = paired_difference([*base, *results], constraint, name, columns[column])
        texts.append(f"{change[2]:+.2f} ({change[3]:+.2f} to {change[4]:+.2f})" if change else "-")
    return [name, *texts, f"{len(done)}/{len(results)}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", choices=[*OF_TASK, UNEQUAL], default=list(OF_TASK))
    parser.add_argument("--constraints", nargs="+", default=["cartesian"])
    parser.add_argument("--robot", default=FLYING_HANDS)
    parser.add_argument("--conditions", nargs="+", metavar="NAME", help="only these; the first is compared with")
    parser.add_argument("--tests", metavar="TEXT", default="", help="only folds whose demonstration's name holds it")
    parser.add_argument("--recordings", nargs="+", default=[], help="test on these instead, learned from the task")
    parser.add_argument(
        "--train-objects", nargs="+", default=[], metavar="OBJECT", help="learn only from what shows it"
    )
    parser.add_argument("--learn", type=int, metavar="N", help="from this many of a fold's demonstrations, the first")
    parser.add_argument("--compared", nargs="+", metavar="COLUMN", default=["events"], help="columns of differences")
    parser.add_argument("--seed", type=int, default=0, help="of the synthetic demonstrations")
    parser.add_argument("--jobs", type=int, default=-1)
    parser.add_argument("--cache", type=Path, default=default_cache(), help="folder of finished folds")
    arguments = parser.parse_args()
    for task in arguments.tasks:
        every = folds_of(task, arguments.seed)
        if arguments.recordings:
            learned_from = recordings_for([task], arguments.seed)
            every = train_and_test(learned_from, recordings_for(arguments.recordings))
        if arguments.train_objects:
            every = learning_only_from(every, arguments.train_objects)
        folds = [fold for fold in every if arguments.tests in fold.test.name]
        if not folds:
            parser.error(f"no fold with {arguments.tests!r}; there are {', '.join(fold.test.name for fold in every)}")
        if arguments.learn:
            folds = [replace(fold, training=fold.training[: arguments.learn]) for fold in folds]
        arms = {} if arguments.robot == FLYING_HANDS else OF_ARMS
        columns = {**NEARNESS, **OF_TASK["rolling" if task == UNEQUAL else task], **arms, **TIMES}
        compared = [name for name in arguments.compared if name in columns]
        if not compared:
            parser.error(f"no column {' '.join(arguments.compared)!r}; there are {', '.join(columns)}")
        for constraint in arguments.constraints:
            chosen = {condition.name: condition for condition in conditions(constraint, arguments.robot)}
            unknown = [name for name in arguments.conditions or () if name not in chosen]
            if unknown:
                parser.error(f"unknown condition {unknown[0]!r}; there are {', '.join(chosen)}")
            print(
                f"\n{task}, {constraint}, {len(folds)} folds, learned from synthetic ones (seed {arguments.seed}), "
                f"tested on {'synthetic' if folds[0].test.synthetic else 'real'} ones, "
                f"{f'{arguments.learn} learned from, ' if arguments.learn else ''}"
                f"{arguments.robot}; mm, degrees, rad, processor seconds; differences from the first condition, "
                "paired over folds, with the 95 % interval\n"
            )
            head = ("condition", *columns, *(f"{name}: difference" for name in compared), "executed")
            print(f"| {' | '.join(head)} |\n|{' --- |' * len(head)}")
            base: list[FoldResult] = []
            for name in track(arguments.conditions or list(chosen), f"{task} {constraint}", transient=True):
                results = evaluate_folds([chosen[name]], folds, jobs=arguments.jobs, cache=arguments.cache)
                base = base or results
                print(f"| {' | '.join(row(results, base, columns, compared))} |", flush=True)


if __name__ == "__main__":
    main()
