"""Jobs: many independent tasks on local processes or on a Dask cluster, none stopped by
another."""

from hefting.jobs.jobs import Jobs
from hefting.jobs.worker import Lost, source_version

__all__ = ["Jobs", "Lost", "source_version"]
