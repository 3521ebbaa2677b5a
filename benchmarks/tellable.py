"""Whether a recording could tell a mistake to someone who knew its exact motion, and the
size of its noise."""

import numpy as np
from scipy.optimize import nnls

from benchmarks.given import RATE, Given, Mistake
from hefting.core.regressor import full_regressor
from hefting.core.spatial import Array
from hefting.shapes import Shape
from hefting.simulation.faults import WRENCH_NOISE

LEAST_CONTRAST = 40.0
"""Chi-squared that a mistake must leave to be told from all others: twice the log of the
ratio of likelihoods 5, three unknowns of a thousand samples, and twenty mistakes."""


def is_tellable(mistake: Mistake, right: Given, seed: int) -> bool:
    """Whether a recording can tell the mistake.

    A change of the wrench does if it is no wrench of another body, bias or clock offset
    on the same motion, by more than the noise that is in the recording; a wrong shape,
    if no body in it has the wrench, bias and clock offset aside, that some body has. Of
    mistakes with poses, rows or options it is not known, and taken for granted.
    """
    exact = right.wrench_of(right.truth.vector)
    noiseless = right.wrench(lambda _, w: exact)
    wrong = mistake.make(noiseless, np.random.default_rng([16, seed]))
    given = np.array(wrong.recording["wrench"].values)
    if len(given) != len(exact):
        return True
    change = given - exact
    if wrong.options or not (change.any() or mistake.needs_shape):
        return True
    assert right.exact is not None
    recorded = np.array(right.recording["wrench"].values)
    late = np.gradient(exact, 1.0 / RATE, axis=0)[:, :, None]
    bias = np.tile(np.eye(6), (len(exact), 1, 1))
    body = full_regressor(right.exact).reshape(-1, 6, 10)
    free = np.concatenate((bias, late), axis=2)
    if mistake.needs_shape:
        return _outside(body, free, recorded, wrong.shape) > LEAST_CONTRAST
    free = np.concatenate((body, free), axis=2)
    columns = np.stack((change, recorded + change), axis=2)
    direction, seen = _beside(free, columns).T
    size = np.linalg.norm(direction)
    along = float(direction @ seen) / float(size) if size > 0.0 else 0.0
    return max(along, 0.0) ** 2 > LEAST_CONTRAST


def _outside(body: Array, free: Array, recorded: Array, shape: Shape) -> float:
    """Chi-squared by which the best body of a shape misses the wrench that was recorded
    (K, 6), beyond the best body of any kind."""
    points = Shape(np.vstack((shape.positions, shape.hull)))
    columns = _beside(free, np.concatenate((body, recorded[:, :, None]), axis=2))
    R = np.linalg.qr(columns, mode="r")[:10]
    return float(nnls(R[:, :10] @ points.matrix, R[:, 10])[1] ** 2)


def _beside(free: Array, columns: Array) -> Array:
    """Columns (6 K, p) of the wrench (K, 6, p) over the noise, less what others (K, 6,
    q) explain of them."""
    noise = np.array(WRENCH_NOISE["moderate"])[:, None]
    A = (free / noise).reshape(-1, free.shape[2])
    A = A / np.linalg.norm(A, axis=0)
    B = (columns / noise).reshape(-1, columns.shape[2])
    return B - A @ np.linalg.lstsq(A, B, rcond=1e-10)[0]
