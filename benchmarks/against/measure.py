"""The whole comparison, as sections of rows and as JSON-ready values."""

import sys
from dataclasses import dataclass
from typing import Any

from benchmarks.against import cost, published
from benchmarks.against.parties import absent, parties
from benchmarks.against.party import Party
from benchmarks.against.recordings import (
    RANDOM,
    WORKSHOP,
    Recorded,
    random_tool,
    random_tools,
    workshop_tools,
)
from benchmarks.against.runs import measured
from benchmarks.against.sections import of_cost, of_set
from benchmarks.against.versions import differences, installed
from benchmarks.report import Section

SAMPLES = (150, 1000)
QUICK_SAMPLES = (150,)
QUICK_TOOL = "dumbbell"
"""On whose recording mujoco.sysid takes a tenth of what it takes on a hammer's."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What was measured."""

    sections: list[Section]
    values: dict[str, Any]
    """JSON-ready"""


def comparison(quick: bool) -> Comparison:
    """Everything; a line on standard error for each step, and for what is amiss."""
    for line in (*absent(), *differences()):
        tell(line)
    every, sections, sets = parties(), [], []
    for name, samples, recordings in recorded(quick):
        tell(f"peers: {len(recordings)} {name}, {samples:,} samples")
        outcomes = measured(every, recordings)
        sections.append(of_set(name, samples, outcomes))
        sets.append(
            {
                "set": name,
                "samples": samples,
                "recordings": len(recordings),
                "parties": [outcome.to_dict() for outcome in outcomes],
            }
        )
    tell("peers: cost")
    curves = costs(every, quick)
    sections.append(of_cost(curves, {party.name: party.beside for party in every}))
    tell("peers: the paper's table")
    values = {
        "quick": quick,
        "versions": installed(),
        "sets": sets,
        "cost": curves,
        "published": published.beside(**(published.QUICK if quick else {})),
        "goals": goals(sections),
    }
    return Comparison(sections, values)


def recorded(quick: bool) -> list[tuple[str, int, list[Recorded]]]:
    """Name, samples and recordings of each set."""
    if quick:
        return [(RANDOM, n, [random_tool(QUICK_TOOL, 1, n)]) for n in QUICK_SAMPLES]
    sets = [(RANDOM, n, random_tools(n)) for n in SAMPLES]
    sets += [(WORKSHOP, n, workshop_tools(n)) for n in SAMPLES]
    return [each for each in sets if each[2]]


def costs(every: list[Party], quick: bool) -> dict[str, dict[str, cost.Curve]]:
    """By what grows, then party."""
    if quick:
        brief = [party for party in every if party.name not in cost.LONGEST]
        return {
            "samples": cost.by_samples(brief, cost.QUICK_SAMPLES, 1),
            "points": cost.by_points(brief, cost.QUICK_POINTS, 1),
            "recordings": cost.by_recordings(brief, cost.QUICK_RECORDINGS, 1),
        }
    return {
        "samples": cost.by_samples(every, cost.SAMPLES),
        "points": cost.by_points(every, cost.POINTS),
        "recordings": cost.by_recordings(every, cost.RECORDINGS),
    }


def goals(sections: list[Section]) -> list[dict[str, Any]]:
    """Every row that has a goal."""
    kept = ("what", "figure", "unit", "at_least", "at_most", "met")
    found = []
    for section in sections:
        above = ""
        for row in section.rows:
            above = above if row.what.startswith(" ") else row.what
            if row.met is None:
                continue
            told = {key: row.to_dict()[key] for key in kept}
            if row.what.startswith(" "):
                told["what"] = f"{row.what.strip()}, against {above}"
            found.append({"section": section.title, **told})
    return found


def tell(line: str) -> None:
    """A line on standard error."""
    print(line, file=sys.stderr, flush=True)
