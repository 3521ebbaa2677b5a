"""Whether a recording could tell a mistake to someone who knew its motion and noise."""

import numpy as np

from benchmarks.given import RATE, Given, Mistake
from hefting.core.regressor import full_regressor
from hefting.simulation.faults import WRENCH_NOISE

LEAST_CONTRAST = 40.0
"""Chi-squared that a mistake must leave to be told from all others: twice the log of the
ratio of likelihoods 5, three unknowns of a thousand samples, and twenty mistakes."""


def is_tellable(mistake: Mistake, right: Given, seed: int) -> bool:
    """Whether the change of the wrench by a mistake is no wrench of another body, bias
    or clock offset on the same motion, by more than noise. Of mistakes with poses or
    options it is not known, and taken for granted."""
    exact = right.wrench_of(right.truth.vector)
    noiseless = right.wrench(lambda _, w: exact)
    wrong = mistake.make(noiseless, np.random.default_rng([16, seed]))
    change = np.array(wrong.recording["wrench"].values) - exact
    if wrong.options or not change.any():
        return True
    assert right.exact is not None
    noise = np.array(WRENCH_NOISE["moderate"])
    A = full_regressor(right.exact).reshape(-1, 6, 10)
    late = np.gradient(exact, 1.0 / RATE, axis=0)[:, :, None]
    bias = np.tile(np.eye(6), (len(A), 1, 1))
    columns = np.concatenate((A, bias, late), axis=2) / noise[:, None]
    columns = columns.reshape(6 * len(A), -1)
    columns = columns / np.linalg.norm(columns, axis=0)
    seen = (change / noise).ravel()
    left = seen - columns @ np.linalg.lstsq(columns, seen, rcond=1e-10)[0]
    return bool(left @ left > LEAST_CONTRAST)
