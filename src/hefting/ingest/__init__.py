"""Ingest: what happens to a recording, understood once, before any method sees it."""

from hefting.ingest.condition import condition
from hefting.ingest.conditioned import Conditioned, WrenchSign
from hefting.ingest.drift import Drift

__all__ = ["Conditioned", "Drift", "WrenchSign", "condition"]
