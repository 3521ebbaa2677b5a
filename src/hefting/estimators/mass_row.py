"""MassRow: a scale's reading as one row more of the equations of a method that finds a
point.

Let m_s be the reading, s its standard deviation. The wrench is wrong by a gain that all
channels share, g, and by other errors. With the parameters as the sensor shows them,
psi = (1 + gain) phi, the gain is minimised out of

    |A psi - b|² + (m - m_s)² / s² + gain² / g²,   m = psi_0 / (1 + gain)

to first order: a row for psi_0 of the deviation d, d² = s² + (g m)², beside the
equations as they are; afterwards the share (g m)² / d² of what is left between psi_0
and m_s is the gain's, and psi is scaled by it. Scaling leaves a body a body, and masses
that are not negative so. Errors that all samples share (`systematic`, of gravity's size
above all) count as gain.

A method's own equations do not tell their errors (`point_intervals`). So the row weighs
as much beside them as the reading beside the mass by the likelihood of all samples: its
square is (c² / q) / d², c² the variance of the mass there without the gain's, q that by
the method's equations if the variance of each were one.
"""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.mass_reading import MassReading
from hefting.core.messages import Message
from hefting.core.spatial import Array
from hefting.estimators.bayes.likelihood import Likelihood, scale_doubts
from hefting.estimators.quadratic import ScaledSVD
from hefting.estimators.state_likelihood import StateSamples

LEAST_OWN_SHARE = 1e-6
"""Least share of the mass's variance that is not the gain's."""


@dataclass(frozen=True, eq=False)
class MassRow:
    """The row, and what it tells of the sensor's gain; `NO_ROW` where there is none."""

    weight: float
    """[1/kg] of the row, in units of the method's equations"""
    mass: float
    """[kg] m_s"""
    gain_share: float
    """share of a difference between reading and wrench that is the gain's"""
    doubts: tuple[Message, ...] = ()
    """what speaks against the reading"""

    @classmethod
    def of(
        cls,
        reading: MassReading,
        samples: StateSamples,
        systematic: Array | None,
        A: Array,
    ) -> "MassRow":
        """Beside the equations A (r, 10) of a method, without a free bias. A reading
        that contradicts the wrench is left out."""
        svd = ScaledSVD.of(A)
        own = float(np.sum(np.square(svd.V[:, 0] / svd.S))) / svd.scale[0] ** 2
        if not samples.informative or not own > 0.0:
            return cls(1.0 / reading.std, reading.mass, 0.0)
        likelihood = _of_wrench(samples, systematic)
        mass, variance = likelihood.mass
        source = samples.source
        gain = source.allowed.gain_std**2 * (mass + float(source.carried[0])) ** 2
        if systematic is not None:
            gain += float(systematic[0, 0])
        doubts = scale_doubts(likelihood, reading, source.carried)
        if doubts:
            return replace(NO_ROW, doubts=doubts)
        square, other = reading.std**2 + gain, max(variance - gain, 0.0)
        if not np.isfinite(variance):  # the row alone tells the mass
            square = other = reading.std**2
        other = max(other, LEAST_OWN_SHARE * (other + gain))
        return cls(
            (other / own / square) ** 0.5,
            reading.mass,
            1.0 - reading.std**2 / square,
        )

    @property
    def equation(self) -> Array | None:
        """(11,) row and right-hand side; None where nothing was weighed."""
        if self.weight == 0.0:
            return None
        row = np.zeros(11)
        row[[0, 10]] = self.weight, self.weight * self.mass
        return row

    def applied(self, estimate: Estimate) -> Estimate:
        """An estimate of what the sensor shows, with the row, as that of the object."""
        if self.weight == 0.0 and not self.doubts:
            return estimate
        warnings = (*estimate.warnings, *self.doubts)
        if self.weight == 0.0:
            return replace(estimate, warnings=warnings)
        shown = estimate.parameters.mass
        gain = self.gain_share * (shown - self.mass) / shown if shown > 0.0 else 0.0
        masses = estimate.point_masses
        return replace(
            estimate,
            parameters=InertialParameters((1.0 - gain) * estimate.parameters.vector),
            point_masses=None if masses is None else (1.0 - gain) * masses,
            covariance=None,
            warnings=warnings,
            provenance=estimate.provenance | {"sensor_gain": gain / (1.0 - gain)},
        )


NO_ROW = MassRow(0.0, 0.0, 0.0)
"""Of an object that was not weighed, or by a scale that is left out."""


def _of_wrench(samples: StateSamples, systematic: Array | None) -> Likelihood:
    """The likelihood of all samples, with all errors that are allowed for."""
    likelihood = samples.likelihood(samples.samples.least_squares).likelihood
    return likelihood if systematic is None else likelihood.blurred(systematic)
