"""Batches: many recordings to one table of objects, on local processes or a cluster."""

from hefting.batches.batch import Batch, batch

__all__ = ["Batch", "batch"]
