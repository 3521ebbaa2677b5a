"""Errors of the sensor that more samples do not lessen, within a recording: hysteresis,
creep, cables, thermal drift. Those of its calibration are in `calibration_errors`.

Two kinds are part of the covariance V of the score h - H phi (`likelihood`), beside the
noise that the residuals show:

- slow errors, a share of the load, which last `SLOW_ERROR_TIME`. In a short
  recording the fit absorbs them, and its residuals do not show them.
- errors in step with the motion. What is coloured in the residuals may follow the
  wrench w: at each time scale it may be wrong by M w, with a random matrix M (6, 6) of
  independent entries whose size is such that `IN_STEP_RATIO` times the coloured
  noise's energy there is that of M w. Unlike noise, such errors do not average out over the
  samples of a scale. Of the whitened rows A_c of channel c they add to V
  var sum_c A_c' (w w') A_c.
"""

from typing import Self

import numpy as np

from hefting.core.regressor import FEATURES
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.colour import first_order

SLOW_ERROR_TIME = 0.25
"""Correlation time of slow errors over the length of the record."""
IN_STEP_RATIO = 1.3
"""Variance of errors in step with the motion over that of the coloured noise: more than
1, as the fit takes a part of them away. With it the intervals of bodies added to
recordings of three real sensors hold (`benchmarks.injection`)."""


@immutable
class InStep:
    """Effect of errors in step with the motion on the scores of g groups of samples."""

    by_gain: Array
    """(g, 10) score by an equal relative error of every channel"""
    by_entry: Array
    """(g, 36, 10) score of each group by each entry of M"""
    energy: Array
    """(g,) sum of the squared whitened wrench of each group"""
    counts: Array
    """(g,) samples of each group"""

    @classmethod
    def of(cls, A: Array, counts: Array, whole: Array) -> Self:
        """For the parameters `whole` (10,) of all that the sensor holds, and whitened
        regressors A (g, 6 * 22, 10) of groups of `counts` (g,) samples."""
        g = len(A)
        w = (A @ whole).reshape(g, 6, FEATURES)
        by_entry = (w[:, None] @ A.reshape(g, 6, FEATURES, 10)).reshape(g, 36, 10)
        return cls(
            by_entry[:, ::7].sum(axis=1),
            by_entry,
            np.maximum((w * w).sum(axis=(1, 2)), 1e-300),
            counts,
        )

    def factors(self, coloured: Array, gain: Array | float = 0.0) -> Array:
        """(g, 37, 10) Y with Y'Y the covariance of each group's score by errors in step
        with the motion.

        `coloured` (g,) is the variance of coloured noise of a channel in each group,
        over that of one sample; `gain` (g,) a relative error of the wrench that was
        found.
        """
        sizes = np.sqrt(IN_STEP_RATIO * coloured * self.counts / self.energy)
        found = np.empty((len(sizes), 37, 10))
        np.multiply(sizes[:, None, None], self.by_entry, out=found[:, :36])
        found[:, 36] = (gain * self.by_gain.T).T
        return found

    def of_each(self, coloured: Array, gain: Array | float = 0.0) -> Array:
        """(g, 10, 10) covariance of each group's score, see `factors`."""
        rows = self.factors(coloured, gain)
        return rows.transpose(0, 2, 1) @ rows

    def covariance(self, coloured: Array, gain: Array) -> Array:
        """(10, 10) covariance of the groups' scores' sum, of independent errors."""
        rows = self.factors(coloured, gain).reshape(-1, 10)
        return rows.T @ rows


def slow_variances(
    error: float, load: float, samples: float, levels: int, free_bias: bool
) -> Array:
    """(J + 1,) variances of slow errors at each time scale and beyond.

    Parameters
    ----------
    error : standard deviation of slow errors over the load
        (`SensorAccuracy.slow_std`).
    load : mean square of the whitened wrench, gravity included and without a bias.
    samples : length of the record.
    levels : number of time scales J.
    free_bias : whether a constant bias is free; if not, a constant error is excluded,
        as the bias is.
    """
    rho = float(np.exp(-1.0 / max(SLOW_ERROR_TIME * samples, 1.0)))
    variances = error**2 * load * first_order(rho, levels + 1)
    if not free_bias:
        variances[-1] = 0.0
    return variances
