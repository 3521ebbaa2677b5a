"""The mistakes that are tried, each in its strengths."""

from benchmarks.given import Mistake
from benchmarks.mistaken.catalogue import Catalogue
from benchmarks.mistaken.forces import add_forces
from benchmarks.mistaken.frames import add_frames
from benchmarks.mistaken.givens import add_givens
from benchmarks.mistaken.objects import add_objects
from benchmarks.mistaken.poses import add_poses
from benchmarks.mistaken.sensor import add_sensor
from benchmarks.mistaken.values import add_values

PARTS = (
    add_frames,
    add_values,
    add_sensor,
    add_poses,
    add_forces,
    add_objects,
    add_givens,
)
"""What adds mistakes to a catalogue, in the order of reports."""


def mistakes() -> list[Mistake]:
    """All mistakes, each strength by itself."""
    catalogue = Catalogue()
    for add_part in PARTS:
        add_part(catalogue.add)
    return catalogue.mistakes
