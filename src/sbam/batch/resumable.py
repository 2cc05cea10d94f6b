"""Independent pieces of work of which those are done that no kept result says already."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

from sbam.batch.kept_results import KeptResults, Key
from sbam.batch.parallel import executor

Result = TypeVar("Result")
Progress = Callable[[int, int], None]
"""Called with the number of finished pieces and of all."""


def resumed(
    keys: Sequence[Key],
    piece: Callable[[int], tuple[Callable[..., Any], tuple[Any, ...]]],
    kept: KeptResults[Result],
    jobs: int = -1,
    cluster: str | None = None,
    progress: Progress | None = None,
    receive: Callable[[int, Any], Result] = lambda _, returned: returned,
) -> Iterator[Mapping[int, Result]]:
    """Do what is left; every new result is kept at once.

    Args:
        keys: what each piece's result is found by.
        piece: function and arguments of the piece with this index; asked, in this process, only for what is left.
        kept: where results are kept.
        jobs: processes; -1 for one per core.
        cluster: address of a Dask scheduler, which then does the work instead of this machine.
        progress: called once for all that were kept, then after every piece.
        receive: makes the result, in this process, from what the function returned.

    Yields:
        Index -> result of all that are finished: once for those that were kept, then after every piece.

    Raises:
        ClusterError: if the cluster does not answer or its support is not installed.
        OutputError: if a result cannot be kept.
    """
    import joblib

    report = progress or (lambda done, total: None)
    results = {index: result for index, key in enumerate(keys) if (result := kept.find(key)) is not None}
    left = [(index, *piece(index)) for index in range(len(keys)) if index not in results]
    yield results
    report(len(results), len(keys))
    with executor(jobs, cluster) as parallel:
        for index, returned in parallel(joblib.delayed(_numbered)(*one) for one in left):
            results[index] = receive(index, returned)
            kept.keep(keys[index], results[index])
            yield results
            report(len(results), len(keys))


def _numbered(index: int, function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[int, Any]:
    """What the function returns, with the index, since pieces are finished in any order."""
    return index, function(*arguments)
