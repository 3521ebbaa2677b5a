"""The given bias, or that there is none, is wrong."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import linear_step
from hefting.ingest.rivals.explanation import Explanation, Undone, fit_as_given

CODE = "bias-wrong"
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
        CODE,
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
        yield Undone(CODE, what, FIX, replace(case, biased=True), argument="bias")
