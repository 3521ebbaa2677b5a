"""The bias drifts in a recording that is too short for a drift to be removed."""

import numpy as np

from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING, HatFunctions
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Rows, with_bias
from hefting.ingest.rivals.explanation import Explanation, over_offsets

CODE = "drift-in-short"
SHORTEST_JUDGED = 1.9
"""[s] In shorter recordings a linear drift explains nearly anything."""


def explain(case: Case) -> Explanation | None:
    """A bias that is linear in time."""
    judged = SHORTEST_JUDGED <= np.ptp(case.time) < SHORTEST_DRIFTING_RECORDING
    if not (case.biased and case.path.moves and judged):
        return None
    linear = HatFunctions.over(case.time, 2).values

    def rows(motion: Motion) -> Rows:
        known, used = case.features(motion), motion.known
        return with_bias(case, known, REGRESSOR_BY_FEATURE, used, functions=linear)

    what = "what noise does not explain seems to be a bias that drifts"
    fix = (
        "a drift is removed only in recordings of 8 s and longer, so record longer, or "
        "let the sensor warm up"
    )
    return Explanation(CODE, what, fix, over_offsets(case, rows)[0], 6, is_change=True)
