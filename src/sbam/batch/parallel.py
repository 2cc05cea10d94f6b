"""Independent pieces of work on all cores, or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sbam.errors import ClusterError

ANSWER = 5
"""How long a cluster's scheduler may take to answer, s."""


@contextmanager
def executor(jobs: int = -1, cluster: str | None = None) -> Iterator[Callable]:
    """A `joblib.Parallel` that gives results as they are finished.

    Args:
        jobs: processes; -1 for one per core.
        cluster: address of a Dask scheduler, which then does the work instead of this machine.

    Raises:
        ClusterError: if the cluster does not answer, has no workers, or its support is not installed.
    """
    import joblib

    if cluster is None:
        yield joblib.Parallel(n_jobs=jobs, return_as="generator_unordered")
        return
    try:
        from distributed import Client
    except ImportError:
        raise ClusterError(cluster, "Dask is not installed here", "pip install 'sbam[cluster]'") from None
    try:
        client = Client(cluster, timeout=ANSWER)
    except (OSError, ValueError) as error:
        raise ClusterError(cluster, str(error) or type(error).__name__, "is `dask scheduler` running there?") from error
    with client:
        if not client.scheduler_info()["workers"]:
            raise ClusterError(cluster, "it has no workers", f"start some with `dask worker {cluster}`")
        with joblib.parallel_config("dask"):
            yield joblib.Parallel(return_as="generator_unordered")
