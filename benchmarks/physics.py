"""What happens in physics: demonstrations, recordings, speed, and random scenes: `python benchmarks/physics.py --help`.

Prints the tables of docs/simulation.md. A sweep keeps its trials in a folder and goes on where it was interrupted.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import sbam
from sbam.demonstrations.demonstration import Demonstration
from sbam.errors import SbamError
from sbam.simulation import SimulationResult, replay
from sbam.simulation.sweep import sweep

RECORDINGS = Path(os.environ.get("SBAM_DATA", Path(__file__).parents[2] / "shared" / "data"))


def show(demonstration: Demonstration, result: SimulationResult) -> None:
    values = result.values
    kind = "synthetic" if demonstration.synthetic else "recorded"
    if result.task == "pouring":
        numbers = (
            f"{values['largest tilt [deg]']:.0f} | {values['poured']:.0%} | {values['in the cup']:.0%} | "
            f"{values['spilled']:.0%}"
        )
    else:
        numbers = (
            f"{values['thickness, mean [mm]']:.1f} | {values['off the planned thickness, 95 % [mm]']:.2f} | "
            f"{values['force, most [N]']:.0f} | {values['half-strokes']:.0f}"
        )
    print(f"| {demonstration.name} | {kind} | {numbers} | {result.speed:.1f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default="out/physics", help="keeps the trials of the sweep")
    parser.add_argument("--tasks", nargs="+", default=["pouring", "rolling"])
    parser.add_argument("--robots", nargs="+", default=["panda_dual"])
    parser.add_argument("--constraints", nargs="+", default=["cartesian", "cylindrical", "symbolic"])
    parser.add_argument("--modes", nargs="+", default=["default"])
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--paper-scenes", type=int, help="fewer scenes for mode paper, which takes a minute a plan")
    parser.add_argument("--jobs", type=int, default=-1)
    arguments = parser.parse_args()
    patterns = {"pouring": ("mmlfd_pouring/*.csv", "kit_bimanual/Pour*.xml"), "rolling": ("kit_bimanual/RollOut*.xml",)}
    heads = {
        "pouring": "tilt, deg | poured | in the cup | spilled",
        "rolling": "thickness, mm | off its path, mm | force, N | half-strokes",
    }
    for task in arguments.tasks:
        print(f"\n| {task} | | {heads[task]} | x real time |\n|---|---|---:|---:|---:|---:|---:|")
        demonstrations = list(sbam.built_in_demonstrations(task))
        for pattern in patterns[task]:
            for path in sorted(RECORDINGS.glob(pattern)):
                try:
                    demonstrations += sbam.load([str(path)])
                except SbamError as error:
                    print(error)
        for demonstration in demonstrations:
            show(demonstration, replay(demonstration, task))
    if arguments.scenes:
        report = sweep(
            arguments.folder,
            arguments.tasks,
            arguments.robots,
            arguments.constraints,
            arguments.modes,
            arguments.scenes,
            arguments.paper_scenes,
            arguments.jobs,
            progress=lambda done, total: print(f"{done} of {total} trials", end="\r", flush=True),
        )
        for table in ("success", "physics"):
            print("\n" + (Path(arguments.folder) / f"{table}.md").read_text())
        failed = [row for row in report["rows"] if not row["ok"]]
        print(f"{len(failed)} of {len(report['rows'])} failed: see {arguments.folder}/failures.md")


if __name__ == "__main__":
    main()
