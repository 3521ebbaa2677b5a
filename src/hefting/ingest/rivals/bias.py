"""The given bias, or that there is none, is wrong; or the bias drifts in a recording that
is too short for a drift to be removed."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING, HatFunctions
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Rows, linear_step, with_bias
from hefting.ingest.rivals.explanation import (
    Explanation,
    Undone,
    fit_as_given,
    over_offsets,
)

WRONG_BIAS = "bias-wrong"
FIX = "give `bias`='estimate'"


def explain(case: Case) -> Explanation | None:
    """A constant bias in addition to the given one."""
    if case.biased:
        return None
    free = replace(case, biased=True)
    fitted, _ = fit_as_given(free)
    given, _ = fit_as_given(case)
    columns = np.broadcast_to(np.eye(6), (len(case.time), 6, 6))
    step = linear_step(given, columns)
    # a wrong bias colours the residuals itself, so the deviations are those for white ones
    std = np.sqrt(np.maximum(step.white.diagonal(), 1e-300))
    force, torque = (float(np.linalg.norm(x)) for x in step.change.reshape(2, 3))
    return Explanation(
        WRONG_BIAS,
        f"the wrench seems to have a bias of another {force:.2g} N and {torque:.2g} N m",
        FIX,
        fitted,
        6,
        argument="bias",
        effect=float(np.abs(step.change / std).max()),
    )


def undone(case: Case) -> Iterator[Undone]:
    """A free bias."""
    if not case.biased:
        what = "the wrench seems to have another bias"
        yield Undone(WRONG_BIAS, what, FIX, replace(case, biased=True), argument="bias")


DRIFT = "drift-in-short"
SHORTEST_JUDGED = 1.9
"""[s] In shorter recordings a linear drift explains nearly anything."""


def explain_drift(case: Case) -> Explanation | None:
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
    return Explanation(DRIFT, what, fix, over_offsets(case, rows)[0], 6, is_change=True)
