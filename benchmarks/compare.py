"""Has something become slower? Measures learning, planning and memory, and compares with `benchmarks/baseline.json`.

Times are ratios to the floor (kinematics and Jacobians of thirty keypoints), so that they hold across machines.
`python benchmarks/compare.py --update` stores what was measured as the new baseline.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from measuring import floor_task, grasped, peak_megabytes, problem_of

import sbam
from sbam.errors import FileFormatError
from sbam.files import write_atomically
from sbam.planning.keypoints.solvers.whole_trajectory import solve_whole_trajectory
from sbam.tasks import random_pouring_scene, random_rolling_scene

BASELINE = Path(__file__).with_name("baseline.json")
WORSE = 0.25  # share by which a time or a memory may grow before it is named
AGAIN = 3  # measurements of what seems worse; the least counts
OBJECTIVE_WORSE = 1e-3  # share by which an objective may grow before it is named
FLOOR_STRETCH = 0.1  # s of floors between two runs of a task
SEED = 0

Results = dict[str, float]


def tasks() -> dict[str, tuple[Callable[[], object], int]]:
    """Name -> what is timed and how often."""
    pouring = sbam.built_in_demonstrations("pouring", SEED)
    rolling = sbam.built_in_demonstrations("rolling", SEED)
    robot = grasped(SEED).robot
    found: dict[str, tuple[Callable[[], object], int]] = {}
    for constraint in ("cartesian", "cylindrical", "symbolic"):
        found[f"learn, {constraint}"] = (lambda c=constraint: sbam.learn(pouring, c)), 3
        for mode in ("paper", "default"):
            problem, start = problem_of(constraint, mode, SEED)
            found[f"keypoints, {constraint}, objective of {mode}"] = (
                (lambda p=problem, s=start: solve_whole_trajectory(p, [s])),
                9,
            )
    for task, demonstrations, scene in (
        ("pouring", pouring, random_pouring_scene(SEED)),
        ("rolling", rolling, random_rolling_scene(SEED)),
    ):
        model = sbam.learn(demonstrations)
        found[f"plan, {task}"] = (lambda m=model, s=scene: sbam.plan(m, s, robot=robot)), 3
    return found


def ratio(task: Callable[[], object], repetitions: int, least: Callable[[], object]) -> float:
    """Median ratio of a task's time to the floor's mean around it: the machine may be busier at other times."""
    around, ratios = [_mean_seconds(least)], []
    for _ in range(repetitions):
        begin = time.process_time()
        task()
        seconds = time.process_time() - begin
        around.append(_mean_seconds(least))
        ratios.append(2.0 * seconds / (around[-2] + around[-1]))
    return float(np.median(ratios))


def _mean_seconds(task: Callable[[], object]) -> float:
    """Mean processor time of a short task over a stretch that is long enough to meet what disturbs it."""
    count, begin = 0, time.process_time()
    while (taken := time.process_time() - begin) < FLOOR_STRETCH:
        task()
        count += 1
    return taken / count


def measure(baseline: Results) -> Results:
    """All times as ratios, memory in MB, objectives; what seems worse than the baseline is measured again."""
    around = floor_task(*problem_of("cartesian", "paper", SEED))
    results: Results = {}
    for name, (task, repetitions) in tasks().items():
        task()
        value = ratio(task, repetitions, around)
        for _ in range(AGAIN):
            if value <= (1.0 + WORSE) * baseline.get(name, value):
                break
            value = min(value, ratio(task, repetitions, around))
        results[name] = round(value, 1)
        if name.startswith("keypoints"):
            solution = task()
            results[f"{name}: J"] = round(solution.objective, 3)  # pyright: ignore[reportAttributeAccessIssue]
        if name.startswith("plan") or name == "learn, cartesian":
            results[f"{name}: MB"] = round(peak_megabytes(task), 1)
    return results


def read_baseline(path: Path) -> Results:
    """What was stored before.

    Raises:
        FileFormatError: if there is no such file or it is not what `--update` writes; names what is wrong.
    """
    wanted = "an object of numbers, as --update writes it"
    try:
        stored = json.loads(path.read_text())
    except OSError as error:
        raise FileFormatError(path, "$", f"cannot be read ({error.strerror})", wanted) from error
    except ValueError as error:
        raise FileFormatError(path, "$", f"is not JSON ({error})", wanted) from error
    if not isinstance(stored, dict):
        raise FileFormatError(path, "$", f"is of type {type(stored).__name__}", wanted)
    for name, value in stored.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < float("inf"):
            raise FileFormatError(path, f"$[{name!r}]", f"is {value!r}", "a positive number")
    return stored


def worsened(results: Results, baseline: Results) -> list[str]:
    """A line for everything that grew by more than it may."""
    lines = []
    for name, value in results.items():
        before = baseline.get(name)
        allowed = OBJECTIVE_WORSE if name.endswith(": J") else WORSE
        if before is not None and value > (1.0 + allowed) * before:
            lines.append(f"{name}: {before:g} -> {value:g} ({100 * (value / before - 1):+.1f} %)")
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--baseline", type=Path, default=BASELINE)
    parser.add_argument("--json", type=Path, help="also write what was measured")
    parser.add_argument("--update", action="store_true", help="make it the new baseline")
    arguments = parser.parse_args()
    try:
        baseline = {} if arguments.update else read_baseline(arguments.baseline)
    except FileFormatError as error:
        parser.error(str(error))
    results = measure(baseline)
    print(f"{'time / floor, MB, or objective J':52s} {'baseline':>9s} {'now':>9s}")
    for name, value in results.items():
        print(f"{name:52s} {baseline.get(name, float('nan')):9.1f} {value:9.1f}")
    text = json.dumps(results, indent=1) + "\n"
    for path in filter(None, (arguments.json, arguments.baseline if arguments.update else None)):
        write_atomically(path, text)
        print(f"wrote {path}")
    worse = worsened(results, baseline)
    print(*(worse or ["nothing became worse"]), sep="\n")
    return 1 if worse else 0


if __name__ == "__main__":
    raise SystemExit(main())
