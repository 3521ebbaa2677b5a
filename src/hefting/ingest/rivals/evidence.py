"""Evidence for an explanation: a robust fit of a linear model, and how likely it makes
the wrench.

The residuals of a sample follow a multivariate Student t distribution, so that contacts
and spikes count little (Lange, Little & Taylor, J. American Statistical Association 84,
1989). All explanations are compared on the same averages of the wrench. Residuals are
coloured: the log-likelihood counts independent samples only.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.ingest.rivals.case import Case

ITERATIONS = 6
"""Reweightings of a robust fit."""
DAMPING = 1e-9
"""Added to the diagonal of normal equations that were scaled to ones there: it keeps
what the motion leaves undetermined finite."""
DEGREES_OF_FREEDOM = 3.0
"""Degrees of freedom of the Student t distribution of a sample's residual."""


@dataclass(frozen=True, eq=False)
class Rows:
    """A model that is linear in its unknowns, for O alternatives (such as clock
    offsets), of K samples."""

    known: Array
    """(O, K, z) rows in which the columns are linear"""
    maps: Array
    """(z, 6, p) columns of the design matrix per unit of a known row"""
    used: Array
    """(O, K) 1 where the motion is known, else 0"""
    wrench: Array | None = None
    """(O, K, 6) wrench, where it is not the one recorded; of the same length"""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Robust fits of the O alternatives."""

    likelihood: Array
    """(O,) log-likelihood of one sample on average, up to a constant"""
    solution: Array
    """(O, p)"""
    scale: Array
    """(O, 2) size of force [N] and torque [N m] residuals"""
    weights: Array
    """(O, K)"""
    residual: Array
    """(O, K, 6)"""
    rows: Rows

    @property
    def best(self) -> int:
        """Index of the most likely alternative."""
        return int(np.argmax(self.likelihood))


def with_bias(
    case: Case,
    known: Array,
    maps: Array,
    used: Array | Mask,
    wrench: Array | None = None,
) -> Rows:
    """Rows with the bias of a case among the unknowns, after the others."""
    functions = case.bias_functions
    n = functions.shape[1]
    O = len(known)
    shared = np.broadcast_to(functions, (O, *functions.shape))
    known = np.concatenate((known, shared), axis=2)
    z, _, p = maps.shape
    whole = np.zeros((z + n, 6, p + 6 * n))
    whole[:z, :, :p] = maps
    for j in range(n):
        whole[z + j, :, p + 6 * j : p + 6 * j + 6] = np.eye(6)
    return Rows(known, whole, np.asarray(used, dtype=float), wrench)


def fit_rows(case: Case, rows: Rows) -> Fitted:
    """Robust least squares of each alternative, by iterative reweighting."""
    known, maps, used = rows.known, rows.maps, rows.used
    O, K, _ = known.shape
    wrench = case.wrench[None] if rows.wrench is None else rows.wrench
    wrench = np.broadcast_to(wrench, (O, K, 6))
    both = np.concatenate((known, wrench), axis=2)
    floor = np.maximum(case.floor, 1e-12)
    centred = wrench - wrench.mean(axis=1, keepdims=True)
    square = (centred**2).reshape(O, K, 2, 3).sum(axis=3)
    count = np.maximum(used.sum(axis=1), 1.0)
    scale = np.maximum(np.sqrt(square.mean(axis=1) / 3.0), floor)
    weights = np.ones((O, K))
    solution = np.zeros((O, maps.shape[2]))
    residual = centred
    for _ in range(ITERATIONS):
        solution = _solve(both, maps, used * weights, scale)
        columns = np.einsum("zcp,op->ozc", maps, solution)
        residual = wrench - known @ columns
        square = (residual**2).reshape(O, K, 2, 3).sum(axis=3)
        for _ in range(2):
            distance = np.einsum("okt,ot->ok", square, scale**-2.0)
            weights = (DEGREES_OF_FREEDOM + 6.0) / (DEGREES_OF_FREEDOM + distance)
            total = np.einsum("ok,okt->ot", used * weights, square)
            scale = np.maximum(np.sqrt(total / (3.0 * count[:, None])), floor)
    distance = np.einsum("okt,ot->ok", square, scale**-2.0)
    tail = np.log1p(distance / DEGREES_OF_FREEDOM)
    likelihood = -0.5 * (DEGREES_OF_FREEDOM + 6.0) * np.sum(used * tail, axis=1) / count
    likelihood = likelihood - 3.0 * np.log(scale).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    return Fitted(likelihood, solution, scale, weights * used, residual, rows)


def _solve(both: Array, maps: Array, weights: Array, scale: Array) -> Array:
    """(O, p) weighted least squares, of known rows with the wrench behind them
    (O, K, z + 6)."""
    normal, right = normal_equations(both, maps, weights, scale)
    length = unit_lengths(normal)
    scaled = normal / length[:, :, None] / length[:, None, :]
    scaled = scaled + DAMPING * np.eye(normal.shape[1])
    return np.linalg.solve(scaled, (right / length)[:, :, None])[:, :, 0] / length


def unit_lengths(normal: Array) -> Array:
    """(O, p) scales of the unknowns of normal matrices (O, p, p): one where the data do
    not depend on an unknown."""
    length = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 0.0))
    return np.where(length > 1e-150, length, 1.0)


def normal_equations(
    both: Array, maps: Array, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Normal matrices (O, p, p) and right-hand sides (O, p) of weighted least squares,
    from known rows with the wrench behind them (O, K, z + 6)."""
    z = both.shape[2] - 6
    gram = np.swapaxes(both * weights[:, :, None], 1, 2) @ both
    inverse_variance = np.repeat(scale**-2.0, 3, axis=1)
    O, p = len(both), maps.shape[2]
    normal, right = np.zeros((O, p, p)), np.zeros((O, p))
    for channel, columns in enumerate(maps.transpose(1, 0, 2)):
        rows = np.flatnonzero(columns.any(axis=1))
        used = columns[rows]
        weight = inverse_variance[:, channel]
        part = gram[:, rows[:, None], rows]
        normal += weight[:, None, None] * (used.T @ (part @ used))
        right += weight[:, None] * (gram[:, rows, z + channel] @ used)
    return normal, right


def correlation(fitted: Fitted, index: int) -> float:
    """Samples that count as one, by the autocorrelation of the weighted residuals of an
    alternative; 1 for white ones."""
    weights = np.sqrt(fitted.weights[index])[:, None]
    scale = np.repeat(fitted.scale[index], 3)
    x = weights * fitted.residual[index] / scale
    n = len(x)
    if n < 8:
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(x, size, axis=0)) ** 2
    rho = np.fft.irfft(power.sum(axis=1), size)[: n // 2]
    if not rho[0] > 0.0:
        return 1.0
    rho = rho / rho[0]
    below = np.flatnonzero(rho < 0.1)
    return max(1.0, 1.0 + 2.0 * float(rho[1 : below[0] if len(below) else None].sum()))


@dataclass(frozen=True, eq=False)
class Step:
    """A Gauss-Newton step of unknowns in which the model is not linear."""

    change: Array
    """(q,)"""
    covariance: Array
    """(q, q), for coloured residuals"""


def linear_step(
    fitted: Fitted, index: int, columns: Array, wrench: Array | None = None
) -> Step:
    """The step beside all linear unknowns of one alternative.

    Parameters
    ----------
    fitted : Fitted
        Robust fits.
    index : int
        Which of the alternatives.
    columns : Array
        (K, 6, q) derivative of the wrench by each unknown.
    wrench : Array, optional
        (K, 6) that was fitted; by default what the rows hold.
    """
    rows = fitted.rows
    K, _, q = columns.shape
    z, _, p = rows.maps.shape
    known = np.concatenate((rows.known[index], columns.reshape(K, 6 * q)), axis=1)
    maps = np.zeros((z + 6 * q, 6, p + q))
    maps[:z, :, :p] = rows.maps
    for channel in range(6):
        for j in range(q):
            maps[z + channel * q + j, channel, p + j] = 1.0
    left = fitted.residual[index] if wrench is None else wrench
    both = np.concatenate((known, left), axis=1)[None]
    part = slice(index, index + 1)
    normal, right = normal_equations(
        both, maps, fitted.weights[part], fitted.scale[part]
    )
    length = unit_lengths(normal)[0]
    scaled = normal[0] / length / length[:, None] + DAMPING * np.eye(p + q)
    inverse = np.linalg.inv(scaled) / length / length[:, None]
    change = (inverse @ right[0])[p:]
    return Step(change, inverse[p:, p:] * correlation(fitted, index))


def without_bias(fitted: Fitted) -> Array:
    """(K, 6) wrench of the ten parameters alone, of the first alternative."""
    rows = fitted.rows
    columns = np.einsum("zcp,p->zc", rows.maps[:, :, :10], fitted.solution[0, :10])
    return rows.known[0] @ columns
