"""Cross-validation as in the paper (section IV-B), over all cores or a cluster, resumable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sbam.batch.fingerprint import code_fingerprint, definition_fingerprint, fingerprint, robot_fingerprint
from sbam.batch.kept_results import KeptResults, Key
from sbam.batch.resumable import Progress, resumed
from sbam.constraints import constraint_type
from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.events import objects_that_move
from sbam.errors import DemonstrationError, UnknownNameError
from sbam.evaluation.fold import FLYING_HANDS, Condition, Fold, FoldResult, run_fold
from sbam.robots import Robot, load_robot
from sbam.scene import ObjectLibrary


def leave_one_out(demonstrations: Sequence[Demonstration]) -> tuple[Fold, ...]:
    """One fold per demonstration of the objects that most demonstrations show; the others are always learned from.

    With nine pours of juice and three of milk these are the paper's nine folds: eight of juice and three of milk are
    learned from. A single demonstration is learned from and compared with (one-shot).

    Raises:
        DemonstrationError: if there is no demonstration, or real ones are mixed with synthetic ones.
    """
    _check_kind(demonstrations)
    if len(demonstrations) == 1:
        return (Fold(tuple(demonstrations), demonstrations[0]),)
    shown = [frozenset(objects_that_move(demonstration)) for demonstration in demonstrations]
    most = max(shown, key=shown.count)
    return tuple(
        Fold((*demonstrations[:index], *demonstrations[index + 1 :]), demonstration)
        for index, demonstration in enumerate(demonstrations)
        if shown[index] == most
    )


def train_and_test(training: Sequence[Demonstration], tests: Sequence[Demonstration]) -> tuple[Fold, ...]:
    """One fold per test demonstration, all learned from the same others.

    Raises:
        DemonstrationError: if there are none, a test is among the training, or real tests are mixed with synthetic.
    """
    _check_kind(tests)
    if not training:
        raise DemonstrationError("(none)", "there is nothing to learn from", "give one or more demonstrations")
    for test in tests:
        if test.name in {demonstration.name for demonstration in training}:
            raise DemonstrationError(
                test.name, "is to be tested on, but was learned from", "leave it out of one of them"
            )
    return tuple(Fold(tuple(training), test) for test in tests)


def learning_only_from(folds: Sequence[Fold], objects: Sequence[str]) -> tuple[Fold, ...]:
    """The folds, of which only those demonstrations are learned from that show all of some objects.

    Raises:
        UnknownNameError: if an object is in none of the demonstrations that are learned from.
        DemonstrationError: if nothing is left to learn from.
    """
    known = {name for fold in folds for demonstration in fold.training for name in demonstration.objects}
    for name in objects:
        if name not in known:
            raise UnknownNameError("object", name, sorted(known), "the demonstrations to learn from")
    kept = [
        replace(fold, training=tuple(one for one in fold.training if set(objects) <= set(one.objects)))
        for fold in folds
    ]
    for fold in kept:
        if not fold.training:
            shown = " and ".join(objects)
            raise DemonstrationError(
                fold.test.name,
                f"is to be tested on, but no demonstration to learn from shows {shown}",
                "name fewer objects, or give demonstrations that show them together",
            )
    return tuple(kept)


def evaluate_folds(
    conditions: Sequence[Condition],
    folds: Sequence[Fold],
    library: ObjectLibrary | None = None,
    jobs: int = -1,
    cache: Path | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> list[FoldResult]:
    """Run every fold under every condition.

    Args:
        conditions: how to learn and plan.
        folds: what to learn from and compare with.
        library: models of the objects; by default the built-in ones.
        jobs: processes; -1 for one per core.
        cache: folder in which every finished fold is kept at once, and from which it is taken if nothing that matters
            has changed: demonstrations, objects, robot, settings or code. None keeps nothing.
        cluster: address of a Dask scheduler, which then does the work instead of this machine; needs the extra
            ``cluster``.
        progress: called with the number of finished folds and of all.

    Returns:
        Results in the order of conditions, then folds.

    Raises:
        UnknownNameError: for an unknown robot or constraint type.
        ClusterError: if the cluster does not answer or its support is not installed.
        OutputError: if the cache cannot be written.
    """
    library = library or ObjectLibrary.built_in()
    robots = {condition.robot: _robot(condition.robot) for condition in conditions}
    robot_keys = {name: robot_fingerprint(robot) if robot else name for name, robot in robots.items()}
    common = code_fingerprint("evaluation"), fingerprint({name: library[name] for name in library})
    work = [(condition, fold) for condition in conditions for fold in folds]
    names = {condition.constraint for condition in conditions}
    types = {name: definition_fingerprint(constraint_type(name)) for name in names}
    prints = [
        fingerprint(*common, robot_keys[condition.robot], types[condition.constraint], condition, fold)
        for condition, fold in work
    ]
    *_, results = resumed(
        [Key(name=one, fingerprint=one) for one in prints],  # so that results of other settings stay
        lambda index: (run_fold, (*work[index], robots[work[index][0].robot], library)),
        KeptResults(cache, FoldResult),
        jobs,
        cluster,
        progress,
    )
    return [results[index] for index in range(len(work))]


def _robot(name: str) -> Robot | None:
    return None if name == FLYING_HANDS else load_robot(name)


def _check_kind(tests: Sequence[Demonstration]) -> None:
    if not tests:
        raise DemonstrationError("(none)", "there is nothing to evaluate", "give one or more demonstrations")
    if len({test.synthetic for test in tests}) > 1:
        real = next(test for test in tests if not test.synthetic)
        raise DemonstrationError(
            real.name, "is real, others are synthetic; they are never averaged", "evaluate them one after the other"
        )
