"""Jobs: many independent tasks on local processes or on a Dask cluster, none stopped by
another."""

from hefting.jobs.jobs import Jobs
from hefting.jobs.outcome import Lost
from hefting.jobs.worker import source_version

__all__ = ["Jobs", "Lost", "source_version"]
