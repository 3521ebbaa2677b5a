"""Positions in another unit of length."""

from dataclasses import replace

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

CODE = "position-unit"
UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}
"""Units of length in which positions are logged [m]."""


def explain(case: Case) -> Explanation | None:
    """The likeliest unit."""
    if not case.recording.has("position") or case.path.kind != "smooth":
        return None
    found = {}
    for unit, size in UNITS.items():

        def build(motion, size=size):
            return newton_euler(case, replace(motion, a=size * motion.a))

        found[unit] = over_offsets(case, build)[0]
    unit = max(found, key=lambda name: found[name].likelihood.max())
    return Explanation(
        CODE,
        f"the positions seem to be in {unit}",
        f'give them in metres, or unit = "{UNITS[unit]:g} m" of them in a column map',
        found[unit],
        0,
        argument="column_map",
    )
