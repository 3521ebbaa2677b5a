"""Drift in a recording that is too short for it to be looked for: whether it is what
noise does not explain."""

from dataclasses import fields
from functools import cached_property

import numpy as np

from hefting.core.messages import error, warning
from hefting.core.spatial import Array
from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING, HatFunctions
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.consequence import NOTICED_UNEXPLAINED, Doubt
from hefting.ingest.rivals.judge import judge

SHORTEST_JUDGED = 1.9
"""[s] In shorter recordings a linear drift explains nearly anything."""


class _Drifting(Case):
    """A case whose bias is linear in time."""

    @cached_property
    def bias_functions(self) -> Array:
        return HatFunctions.over(self.time, 2).values


def or_drift(case: Case, doubt: Doubt) -> Doubt:
    """That the bias drifts, where this explains a recording of less than 8 s, and no
    mistake that makes the answer wrong was named; else `doubt`."""
    judged_too = SHORTEST_JUDGED <= np.ptp(case.time) < SHORTEST_DRIFTING_RECORDING
    named_wrong = doubt.names_mistake and doubt.is_fatal
    if not (case.biased and case.path.moves and judged_too) or named_wrong:
        return doubt
    judged = judge(_Drifting(**{f.name: getattr(case, f.name) for f in fields(case)}))
    if judged.named is not None or judged.unexplained > NOTICED_UNEXPLAINED:
        return doubt
    what = (
        "a bias that drifts seems to be what noise does not explain; it is taken out of "
        "recordings of 8 s and longer only: record longer, or let the sensor warm up"
    )
    say = error if doubt.is_fatal else warning
    return Doubt(say("drift-in-short", what), False)
