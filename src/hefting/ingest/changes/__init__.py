"""Changes of the object within a recording: picked up, put down, swapped, slipped,
touched."""

from hefting.ingest.changes.find import find_changes
from hefting.ingest.changes.stretches import Changes, Stretch, Touch

__all__ = ["Changes", "Stretch", "Touch", "find_changes"]
