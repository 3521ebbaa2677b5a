"""Batch: many recordings to one table of objects, on local processes or a cluster."""

from hefting.batch.batch import Batch, batch

__all__ = ["Batch", "batch"]
