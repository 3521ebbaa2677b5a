"""Inspection: what a log holds, which conventions it seems to follow, and what can be
found from it."""

from hefting.inspection.facts import Movement, StreamFacts, WrenchFacts
from hefting.inspection.inspect import inspect
from hefting.inspection.result import Inspection

__all__ = ["Inspection", "Movement", "StreamFacts", "WrenchFacts", "inspect"]
