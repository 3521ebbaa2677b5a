"""Dask clusters on this machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def local_cluster(workers: int, **options: Any) -> Iterator[Any]:
    """With workers of one thread each; options as for `distributed.LocalCluster`.

    That a killed worker is not there is found within 3 s: Dask tries for half a minute.
    """
    import dask
    import distributed

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "3s"}),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            host="127.0.0.1",
            silence_logs=60,
            **options,
        ) as cluster,
    ):
        yield cluster
