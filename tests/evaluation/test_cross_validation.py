"""Cross-validation: the paper's folds, finished work that is not done again, and a cluster."""

import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from sbam.demonstrations.demonstration import Demonstration
from sbam.demonstrations.synthetic import built_in_demonstrations
from sbam.errors import ClusterError, DemonstrationError, UnknownNameError
from sbam.evaluation.cross_validation import evaluate_folds, learning_only_from, leave_one_out, train_and_test
from sbam.evaluation.fold import Condition, FoldResult
from sbam.planning.settings import PlanSettings


@pytest.fixture(scope="module")
def rolling() -> tuple[Demonstration, ...]:
    return built_in_demonstrations("rolling")


def without_times(results: list[FoldResult]) -> list[FoldResult]:
    return [replace(result, seconds={}) for result in results]


def test_the_paper_s_folds():
    folds = leave_one_out(built_in_demonstrations("pouring"))
    assert len(folds) == 9
    for fold in folds:
        assert "juice" in fold.test.name
        assert len(fold.training) == 11
        assert sum("milk" in demonstration.name for demonstration in fold.training) == 3
        assert fold.test.name not in {demonstration.name for demonstration in fold.training}
    assert len({fold.test.name for fold in folds}) == 9


def test_a_single_demonstration_is_learned_from_and_compared_with(rolling):
    (fold,) = leave_one_out(rolling[:1])
    assert fold.training == (fold.test,) == rolling[:1]


def test_what_cannot_be_evaluated_is_refused(rolling):
    with pytest.raises(DemonstrationError, match="nothing to evaluate"):
        leave_one_out([])
    with pytest.raises(DemonstrationError, match="never averaged"):
        leave_one_out([rolling[0], replace(rolling[1], synthetic=False)])
    with pytest.raises(DemonstrationError, match="was learned from"):
        train_and_test(rolling[:2], rolling[1:3])
    with pytest.raises(DemonstrationError, match="nothing to learn from"):
        train_and_test([], rolling[:1])
    with pytest.raises(UnknownNameError, match="panda_dual"):
        evaluate_folds([Condition("x", robot="nobody")], leave_one_out(rolling[:2]))


def test_learning_only_from_demonstrations_that_show_some_objects():
    pouring = built_in_demonstrations("pouring")
    folds = leave_one_out(pouring)
    juice = learning_only_from(folds, ["apple_juice"])
    assert [fold.test for fold in juice] == [fold.test for fold in folds]
    for before, after in zip(folds, juice, strict=True):
        assert after.training == tuple(one for one in before.training if "juice" in one.name)
        assert len(after.training) == 8
    milk = learning_only_from(folds, ["cup_small", "milk_small"])
    assert all(len(fold.training) == 3 for fold in milk)
    with pytest.raises(UnknownNameError, match="'juice' in the demonstrations to learn from; known: 'apple_juice'"):
        learning_only_from(folds, ["juice"])
    with pytest.raises(DemonstrationError, match="shows apple_juice and milk_small"):
        learning_only_from(folds, ["apple_juice", "milk_small"])


def test_finished_folds_are_not_done_again(rolling, tmp_path):
    folds = leave_one_out(rolling[:3])
    condition = Condition("default")
    seen: list[tuple[int, int]] = []
    first = evaluate_folds([condition], folds, jobs=1, cache=tmp_path, progress=lambda *n: seen.append(n))
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert [result.test for result in first] == [demonstration.name for demonstration in rolling[:3]]
    assert all(result.executed for result in first)
    assert len(list(tmp_path.glob("*.json"))) == 3

    # As after an interruption: one is missing, one was not written completely.
    one, other, _ = sorted(tmp_path.glob("*.json"))
    one.unlink()
    other.write_bytes(other.read_bytes()[:100])
    seen.clear()
    again = evaluate_folds([condition], folds, jobs=1, cache=tmp_path, progress=lambda *n: seen.append(n))
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert without_times(again) == without_times(first)

    # Nothing that matters may change unnoticed: settings, recordings.
    for changed in (
        ([replace(condition, planning=PlanSettings(smoothness=0.06))], folds),
        ([condition], leave_one_out([replace(rolling[0], T_world_agent=rolling[1].T_world_agent), *rolling[1:3]])),
    ):
        seen.clear()
        with pytest.raises(_EnoughError):
            evaluate_folds(*changed, jobs=1, cache=tmp_path, progress=_stop_after_first_call(seen))
        assert seen[0][0] < 3


class _EnoughError(Exception):
    pass


def _stop_after_first_call(seen):
    def progress(done: int, total: int) -> None:
        seen.append((done, total))
        raise _EnoughError

    return progress


def test_a_task_that_cannot_be_learned_is_a_result(rolling):
    pouring = built_in_demonstrations("pouring")[0]
    (result,) = evaluate_folds([Condition("default")], train_and_test([rolling[0]], [pouring]), jobs=1)
    assert not result.executed
    assert result.problems


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """Address of a Dask scheduler with two worker processes on this machine."""
    pytest.importorskip("distributed")
    dask = str(Path(sys.executable).parent / "dask")
    if not Path(dask).exists() and shutil.which("dask") is None:
        pytest.skip("no dask command")
    file = tmp_path / "scheduler.json"
    common = ["--scheduler-file", str(file), "--no-dashboard"]
    commands = [
        ["scheduler", "--host", "127.0.0.1", "--port", "0", *common],
        *(["worker", "--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path), *common] for _ in range(2)),
    ]
    processes = [
        subprocess.Popen([dask, *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for command in commands
    ]
    try:
        from distributed import Client

        deadline = time.monotonic() + 60
        while not file.exists():
            assert time.monotonic() < deadline
            time.sleep(0.1)
        with Client(scheduler_file=str(file), timeout=30) as client:
            client.wait_for_workers(2, timeout=60)
            address = client.scheduler.address
        yield address
    finally:
        for process in reversed(processes):  # workers first: they say good-bye to the scheduler
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def test_a_cluster_does_the_same_work(rolling, scheduler, tmp_path):
    folds = leave_one_out(rolling[:4])
    cache = tmp_path / "folds"
    counted: list[int] = []
    there = evaluate_folds(
        [Condition("default")], folds, cache=cache, cluster=scheduler, progress=lambda done, _: counted.append(done)
    )
    assert counted == [0, 1, 2, 3, 4]
    assert len(list(cache.glob("*.json"))) == 4
    here = evaluate_folds([Condition("default")], folds, jobs=1)
    for mine, theirs in zip(without_times(here), without_times(there), strict=True):
        assert mine.test == theirs.test
        for a, b in zip(mine.pairs, theirs.pairs, strict=True):
            assert a.events == pytest.approx(b.events, abs=1e-3)


def test_a_cluster_that_does_not_answer_is_named(rolling):
    pytest.importorskip("distributed")
    with pytest.raises(ClusterError, match=r"tcp://127\.0\.0\.1:9"):
        evaluate_folds([Condition("default")], leave_one_out(rolling[:2]), cluster="tcp://127.0.0.1:9")
