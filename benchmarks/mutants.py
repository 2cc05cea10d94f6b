"""Plant faults in the code and count how many of them the tests find.

Mutmut writes each possible fault (a mutant) into the code; of each room a sample is tested with the tests that reach
it. Faults in texts alone are not counted. A mutant has the same rank in every version of the code, so that the
samples of two versions are alike.

    python benchmarks/mutants.py --each 75 --seed 0

The survivors are listed at the end; ``mutmut show NAME`` prints one.
"""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from hashlib import sha256
from itertools import chain
from pathlib import Path
from typing import Annotated

import tyro
from mutmut.mutation.file_mutation import mutate_file_contents
from mutmut.stats import status_by_exit_code
from mutmut.utils.format_utils import get_mutant_name

REPOSITORY = Path(__file__).parents[1]
CONFIGURATION = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["tool"]["mutmut"]
ROOMS = {pattern.removeprefix("src/sbam/").removesuffix("/*"): pattern for pattern in CONFIGURATION["only_mutate"]}
"""Room -> pattern of its files."""
FOUND = ("killed", "timeout")


def without_texts(function: ast.FunctionDef) -> str:
    """What a function does, whatever its name and the texts in it."""
    for node in ast.walk(function):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = ""
    return ast.dump(ast.Module(function.body, []))


def mutants_of(path: Path) -> list[str]:
    """Names of the mutants of a file, without those that change texts alone."""
    mutated = mutate_file_contents(str(path), path.read_text())
    functions = (node for node in ast.walk(ast.parse(mutated.code)) if isinstance(node, ast.FunctionDef))
    bodies = {function.name: without_texts(function) for function in functions}
    return [
        get_mutant_name(path, name)
        for name in mutated.mutant_names
        if bodies[name] != bodies[name.rpartition("_")[0] + "_orig"]
    ]


def sample(mutants: list[str], each: int, seed: int) -> list[str]:
    """Some of the mutants, whatever the files that they are in are called."""

    def rank(name: str) -> tuple[str, str]:
        return sha256(f"{seed} {name.rpartition('.')[2]}".encode()).hexdigest(), name

    return sorted(sorted(mutants, key=rank)[:each])


def results() -> Iterator[tuple[str, str]]:
    """Names of mutants and what became of them."""
    for path in Path("mutants").rglob("*.meta"):
        for name, code in json.loads(path.read_text())["exit_code_by_key"].items():
            yield name, status_by_exit_code[code]


def main(each: Annotated[int, tyro.conf.arg(help="mutants of each room")] = 75, seed: int = 0) -> None:
    """Test a sample of mutants and print the share found of each room."""
    with ProcessPoolExecutor() as pool:
        mutants = {
            room: list(chain.from_iterable(pool.map(mutants_of, sorted(Path(pattern).parent.rglob("*.py")))))
            for room, pattern in ROOMS.items()
        }
    samples = {room: sample(mutants[room], each, seed) for room in ROOMS}
    subprocess.run([Path(sys.executable).with_name("mutmut"), "run", *chain(*samples.values())], check=True)
    status = dict(results())
    for room, names in samples.items():
        counts = Counter(status[name] for name in names)
        found = sum(counts[one] for one in FOUND)
        told = ", ".join(f"{count} {one}" for one, count in sorted(counts.items()))
        print(f"{room}: {100 * found / len(names):.0f} % of {len(names)} found ({told}); {len(mutants[room])} in all")
    for name in chain(*samples.values()):
        if status[name] not in FOUND:
            print(f"{status[name]}: {name}")


if __name__ == "__main__":
    os.chdir(REPOSITORY)
    tyro.cli(main)
