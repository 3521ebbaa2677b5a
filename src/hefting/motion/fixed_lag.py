"""Fixed-lag Kalman filter of integrated white noise.

A component is a chain of n integrators driven by white noise, measured with white
noise. The estimate of a past state x_j given all samples so far follows from its
covariance C_j
with the present state: with innovation nu of variance S,

    C_j <- C_j F',   x_j <- x_j + C_j H' nu / S,   C_j <- C_j (I - K H)'

(Anderson & Moore, Optimal Filtering, 1979, ch. 7). Values are in units of the noise r,
times in units of 1/bandwidth wc: state i is derivative i over r wc^i, and the driving
noise has intensity period * wc ("nominal"). In these units the filter depends only on n
and on the spacing of the samples.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import factorial
from typing import NamedTuple

import numpy as np

from hefting.core.spatial import Array

INITIAL_DERIVATIVE_STD = 1e4
"""Standard deviation of the derivatives at the start, in filter units: large, as they
are unknown."""
OUTPUT_STATES = 3
"""Number of states that are returned: value, velocity, acceleration."""
BLOCK = 64
"""Number of samples whose states are found by one matrix product."""


@lru_cache
def _powers(n: int) -> tuple[Array, Array, Array, Array]:
    """Coefficients and exponents (n, n) of the step in the matrices of
    `_integrators`."""
    i, j = np.indices((n, n))
    factorials = np.array([factorial(k) for k in range(n)], dtype=float)
    power = 2 * n - 1 - i - j
    noise = 1.0 / (power * factorials[n - 1 - i] * factorials[n - 1 - j])
    return (
        np.where(j >= i, 1.0 / factorials[np.abs(j - i)], 0.0),
        np.maximum(j - i, 0.0),
        noise,
        power.astype(float),
    )


def _integrators(step: float, n: int) -> tuple[Array, Array]:
    """Transition matrix (n, n) over `step`, and covariance (n, n) of the state that
    unit white noise causes in it."""
    transition, transition_power, noise, noise_power = _powers(n)
    return transition * step**transition_power, noise * step**noise_power


class Steady(NamedTuple):
    """The settled filter for samples at a constant step, with a lag of `lag`
    samples."""

    covariance: Array
    """(n, n) Covariance of the present state."""
    surplus: float
    """S/R: ratio of innovation to residual."""
    decay: Array
    """(BLOCK * n, n) what remains of a state after each of BLOCK samples"""
    response: Array
    """(BLOCK * n, BLOCK) states by each sample of a block"""
    gains: Array
    """(lag + 1, 3) Gain of the innovation i samples later; row 0 is zero."""
    cross: Array
    """(lag + 1, 3, n) C of a state i samples old."""
    variances: Array
    """(lag + 1, 3) Variances of a state i samples old."""


@lru_cache(maxsize=32)
def steady_filter(n: int, step: float, lag: int) -> Steady:
    """The settled filter of `n` integrators for samples at interval `step`
    [1/bandwidth], with a lag of `lag` samples."""
    # slow to import, and not needed for finished recordings
    from scipy.linalg import solve_discrete_are

    transition, noise = _integrators(step, n)
    observe = np.eye(n)[:, :1]
    predicted = solve_discrete_are(transition.T, observe, step * noise, np.eye(1))
    for _ in range(50):  # polishes the last digits
        surplus = predicted[0, 0] + 1.0
        gain = predicted[:, 0] / surplus
        covariance = predicted - surplus * np.outer(gain, gain)
        predicted = transition @ covariance @ transition.T + step * noise
        predicted = 0.5 * (predicted + predicted.T)
    decay, response = _block_matrices(transition - np.outer(gain, transition[0]), gain)
    gains = [np.zeros(OUTPUT_STATES)]
    cross = [covariance[:OUTPUT_STATES]]
    variances = [np.diag(covariance)[:OUTPUT_STATES]]
    for _ in range(lag):
        c = cross[-1] @ transition.T
        gains.append(c[:, 0] / surplus)
        cross.append(c - np.outer(c[:, 0], gain))
        variances.append(variances[-1] - surplus * gains[-1] ** 2)
    return Steady(
        covariance,
        surplus,
        decay,
        response,
        np.array(gains),
        np.array(cross),
        np.array(variances),
    )


def _block_matrices(loop: Array, gain: Array) -> tuple[Array, Array]:
    """`Steady.decay` and `Steady.response` of the recursion x <- loop x + gain v, with
    `loop` (n, n) and `gain` (n,)."""
    n = len(gain)
    powers = [np.eye(n)]
    for _ in range(BLOCK):
        powers.append(loop @ powers[-1])
    impulse = np.array(powers[:-1]) @ gain
    response = np.zeros((BLOCK, n, BLOCK))
    for k in range(BLOCK):
        response[k:, :, k] = impulse[: BLOCK - k]
    return np.concatenate(powers[1:]), response.reshape(BLOCK * n, BLOCK)


@dataclass(frozen=True)
class Track:
    """Filter state of d components with a common covariance, and past states whose
    motion was not yet returned."""

    mean: Array
    """(n, d) Present state."""
    covariance: Array
    """(n, n) Covariance of the present state of each component."""
    past: Array
    """(P, 3, d) Past states; the last is the present one."""
    cross: Array
    """(P, 3, n) Their covariance with the present state."""
    variances: Array
    """(P, 3) Their variances."""

    @classmethod
    def start(cls, value: Array, n: int, cold: Steady | None) -> "Track":
        """The state after the first sample `value` (d,). The derivatives are unknown;
        with `cold` they are zero, and the covariance is that of the settled filter."""
        mean = np.zeros((n, len(value)))
        mean[0] = value
        covariance = (
            np.diag([1.0] + [INITIAL_DERIVATIVE_STD**2] * (n - 1))
            if cold is None
            else cold.covariance
        )
        return cls(
            mean,
            covariance,
            mean[None, :OUTPUT_STATES],
            covariance[None, :OUTPUT_STATES],
            np.diag(covariance)[None, :OUTPUT_STATES],
        )

    def step(self, value: Array, step: float, nominal: float) -> "Track":
        """Update with one sample (d,), `step` after the last one.

        `nominal` is the intensity of the driving noise; all in filter units.
        """
        transition, noise = _integrators(step, len(self.mean))
        mean = transition @ self.mean
        predicted = transition @ self.covariance @ transition.T + nominal * noise
        predicted = 0.5 * (predicted + predicted.T)  # rounding makes it asymmetric
        surplus = predicted[0, 0] + 1.0
        gain = predicted[:, 0] / surplus
        innovation = value - mean[0]
        mean = mean + np.outer(gain, innovation)
        covariance = predicted - surplus * np.outer(gain, gain)
        cross = (self.cross.reshape(-1, len(mean)) @ transition.T).reshape(
            self.cross.shape
        )
        gains = cross[:, :, 0] / surplus
        return Track(
            mean,
            covariance,
            np.concatenate(
                (self.past + gains[:, :, None] * innovation, mean[None, :OUTPUT_STATES])
            ),
            np.concatenate(
                (cross - cross[:, :, :1] * gain, covariance[None, :OUTPUT_STATES])
            ),
            np.concatenate(
                (
                    self.variances - surplus * gains**2,
                    np.diag(covariance)[None, :OUTPUT_STATES],
                )
            ),
        )

    def block(self, values: Array, steady: Steady) -> "Track":
        """Update with many samples at constant spacing, while the gains are constant.

        Parameters
        ----------
        values : (K, d) samples.
        steady : the settled filter for their spacing; see `is_steady`.

        Returns what K calls of `step` return, up to rounding.
        """
        states = self._filtered_states(values, steady)
        innovations = (values - states[:, 0]) * steady.surplus
        past = np.concatenate((self.past, states[:, :OUTPUT_STATES]))
        _add_later_innovations(past, innovations, steady.gains)
        lag = len(steady.gains) - 1
        age = np.minimum(np.arange(len(past))[::-1], lag)
        return Track(
            states[-1], self.covariance, past, steady.cross[age], steady.variances[age]
        )

    def _filtered_states(self, values: Array, steady: Steady) -> Array:
        """(K, n, d) state after each of the samples (K, d), given no later sample."""
        mean = self.mean
        n, d = mean.shape
        states = np.empty((len(values), n, d))
        for first in range(0, len(values), BLOCK):
            v = values[first : first + BLOCK]
            k = len(v)
            found = steady.decay[: k * n] @ mean + steady.response[: k * n, :k] @ v
            states[first : first + k] = found.reshape(k, n, d)
            mean = states[first + k - 1]
        return states

    def is_steady(self, steady: Steady) -> bool:
        """Whether the covariances have settled to five digits, so that `block` is
        equivalent to `step`."""
        if len(self.past) != len(steady.gains) - 1:
            return False
        if not _close(self.covariance, steady.covariance):
            return False
        return len(self.past) == 0 or _close(self.cross[0], steady.cross[-2])

    def drop(self, count: int) -> "Track":
        """The state without its `count` oldest past states."""
        return replace(
            self,
            past=self.past[count:],
            cross=self.cross[count:],
            variances=self.variances[count:],
        )


def _close(found: Array, settled: Array) -> bool:
    """Whether covariances are settled to five digits; `numpy.allclose` takes five times
    as long."""
    return bool((np.abs(found - settled) <= 1e-8 + 1e-5 * np.abs(settled)).all())


def _add_later_innovations(past: Array, innovations: Array, gains: Array) -> None:
    """Correct past states (P, 3, d), of which the last are those of K new samples, by
    the innovations (K, d) of the samples that follow them, in place."""
    lag = len(gains) - 1
    if not lag:
        return
    first_new = len(past) - len(innovations)
    padded = np.zeros((len(past) + lag, innovations.shape[1]))
    padded[first_new : len(past)] = innovations
    for i in range(OUTPUT_STATES):
        for d in range(innovations.shape[1]):
            past[:, i, d] += np.correlate(padded[1:, d], gains[1:, i], "valid")[
                : len(past)
            ]
