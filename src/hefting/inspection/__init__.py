"""Inspection: what a log holds, which conventions it seems to follow, and what can be
found from it."""

from hefting.inspection.inspect import inspect
from hefting.inspection.movement import Movement
from hefting.inspection.result import Inspection
from hefting.inspection.streams import StreamFacts
from hefting.inspection.wrench import WrenchFacts

__all__ = ["Inspection", "Movement", "StreamFacts", "WrenchFacts", "inspect"]
