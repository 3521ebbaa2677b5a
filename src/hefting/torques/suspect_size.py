"""The size of a suspect, of which the first step falls short: the tilt or the zeros that
leave none."""

from dataclasses import replace

import numpy as np

from hefting.torques.runs import LoadedRuns
from hefting.torques.suspects import Suspect, Suspects

MOST_STEPS = 8
"""Steps to the size of a tilt or of zeros, of which the first falls short."""
SMALL_STEP = 0.05
"""Share of it below which they end."""


def refined(runs: LoadedRuns, suspect: Suspect | None) -> Suspect | None:
    """A tilt in all runs, or zeros, by as many steps as leave none; another suspect, or
    one beside a calibration, as it is."""
    if suspect is None or runs.calibration is not None:
        return suspect
    if suspect.kind != "zeros" and (suspect.kind != "tilt" or suspect.loaded):
        return suspect
    alike = (suspect.kind, suspect.loaded)
    for _ in range(MOST_STEPS):
        there = _without(runs, suspect)
        tried = Suspects(there, there.fit()).all()
        more = next(each for each in tried if (each.kind, each.loaded) == alike).theta
        suspect = replace(suspect, theta=suspect.theta + more)
        if np.abs(more).max() < SMALL_STEP * np.abs(suspect.theta).max():
            break
    return suspect


def _without(runs: LoadedRuns, suspect: Suspect) -> LoadedRuns:
    """The runs without a tilt, or with the zeros put right."""
    if suspect.kind == "tilt":
        given = runs.dynamics.gravity
        turned = given + suspect.theta
        turned *= np.linalg.norm(given) / np.linalg.norm(turned)
        return replace(runs, dynamics=runs.dynamics.under(turned))
    loaded, empty = (
        tuple(replace(run, position=run.position + suspect.theta) for run in each)
        for each in (runs.loaded, runs.empty)
    )
    return replace(runs, loaded=loaded, empty=runs.empty if suspect.loaded else empty)
