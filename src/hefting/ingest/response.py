"""Response: whether a late wrench is late by a delay, or through a low-pass filter, which
also rounds and weakens what it measures.

Sensors and drivers filter. A filter of first order with the time constant T delays a
steady change by T, as a clock that is late by T does; but it delays a change that only
begins less, and a wrench that swings at f it weakens by about (2 pi f T)² / 2: by 3 % at
0.2 Hz for a filter of 0.2 s. Taken for a delay it leaves masses that are too small.

The wrench is taken to lie between the two, by the share c that its residuals tell.
"""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.messages import Message, note
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.estimators.ols import least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import SIGNIFICANT, Conditioned
from hefting.ingest.filtering import SHORTEST_LAG, filtered
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.systematic import OFFSET_ERROR_RATIO

LONGEST_LAG = 0.5
"""[s] The longest filter's: a longer lag is that of a clock."""
SHARE_STD = 0.6
"""Root mean square of c before the residuals are seen: evenly from 0 to 1."""
LAG_SHARE_STD = 0.3
"""Standard deviation of the lag over itself, if it is a filter's: between a delay and a
filter the lag that fits best changes by up to a quarter."""


@dataclass(frozen=True, eq=False)
class Response:
    """How the wrench follows the motion, beside a delay."""

    lag: float
    """[s] of the wrench, as the clock offset has it"""
    share: float
    """c: 0 for a delay, 1 for a filter of first order; below 0 where the motion was
    filtered"""
    share_std: float
    change: Array
    """(K, 6) what it adds to the wrench of each sample [N, N m]"""
    errors: Array
    """(10, 2) E, E E' being the covariance of the parameters by what is not known of
    it"""

    def corrected(self, z: Measurements) -> Measurements:
        """The samples as a wrench that is only delayed has them."""
        return replace(
            z, force=z.force - self.change[:, :3], torque=z.torque - self.change[:, 3:]
        )

    def messages(self) -> list[Message]:
        """What was found, where the residuals tell."""
        if not self.share > SIGNIFICANT * self.share_std:
            return []
        return [
            note(
                "wrench-response",
                f"the wrench lags by {self.lag:.2g} s as through a low-pass filter: corrected",
            )
        ]


def response_of(found: Conditioned, z: Measurements, fit: FreeFit) -> Response | None:
    """The response that the residuals tell, beside the clock offset that was found.

    None where there is no clock or no motion, or where the lag is too short to matter.

    Parameters
    ----------
    found : what conditioning found, with the clock offset.
    z : samples, with the delay removed.
    fit : their unconstrained least squares.
    """
    lag = min(abs(found.offset), LONGEST_LAG)
    if found.offset_std is None or lag < SHORTEST_LAG or len(z) < 3:
        return None
    predicted = predict_wrench(z, fit.vector)
    late = filtered(z.time, predicted, lag)
    if late is None:
        return None
    directions = (late - predicted, lag * np.gradient(predicted, z.time, axis=0))
    fits = [_explained(z, direction, fit) for direction in directions]
    effects = np.array([effect for effect, _ in fits]).T
    X = np.array([_whitened(rest, z, fit) for _, rest in fits]).T
    y = _whitened(z.wrench - predicted, z, fit)
    # residuals of an imperfect model tell less than white noise would, as for the offset
    variance = OFFSET_ERROR_RATIO**2 * fit.autocorrelation
    known = np.diag((SHARE_STD**-2, LAG_SHARE_STD**-2))
    covariance = np.linalg.inv(known + X.T @ X / variance)
    shares = covariance @ (X.T @ y) / variance
    # the correction is as uncertain as it is large: filters are not all of first order
    spread = covariance + np.outer(shares, shares)
    return Response(
        lag,
        float(shares[0]),
        float(covariance[0, 0] ** 0.5),
        np.tensordot(shares, directions, 1),
        effects @ np.linalg.cholesky(spread),
    )


def _explained(z: Measurements, wrench: Array, fit: FreeFit) -> tuple[Array, Array]:
    """(10,) what least squares makes of a wrench (K, 6) added to the samples, and what
    it leaves (K, 6)."""
    added = replace(z, force=wrench[:, :3], torque=wrench[:, 3:])
    solved = least_squares(SampleState.of(added), fit.bias is not None, fit.noise)
    effect = solved.solution[:10]
    return effect, wrench - predict_wrench(z, effect)


def _whitened(wrench: Array, z: Measurements, fit: FreeFit) -> Array:
    """(6 K,) residuals (K, 6) over the noise of each sample, less the bias that is
    free."""
    weights = np.ones(len(z)) if z.weights is None else z.weights
    if fit.bias is not None:
        wrench = wrench - np.average(wrench, axis=0, weights=weights)
    std = np.repeat((fit.noise.force, fit.noise.torque), 3)
    return (np.sqrt(weights)[:, None] * wrench / std).ravel()
