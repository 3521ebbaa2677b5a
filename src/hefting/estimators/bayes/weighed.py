"""Weighed: a scale's reading of the mass beside the likelihood of the wrench.

The reading m_s of standard deviation s is independent of every error of the wrench, so
it is one row more of the likelihood: its precision gains 1 / s² for the mass, its shift
m_s / s². The errors of gain that all channels share are in the likelihood's covariance,
where they go with the parameters themselves; so with the mass known, the first moment
and the inertia become as much surer as they are wrong by the same gain.
"""

from dataclasses import replace

from hefting.core.mass_reading import MassReading
from hefting.core.messages import Message, error
from hefting.core.spatial import Array
from hefting.estimators.bayes.likelihood import Equations, Likelihood

LARGEST_DEVIATION = 4.0
"""Standard deviations between a scale and the wrench from which on they contradict each
other: by chance 6 of 100,000 do."""


def with_reading(likelihood: Likelihood, reading: MassReading | None) -> Likelihood:
    """The likelihood of the wrench and of what the scale showed."""
    if reading is None:
        return likelihood
    precision, shift = likelihood.precision.copy(), likelihood.shift.copy()
    precision[0, 0] += 1.0 / reading.std**2
    shift[0] += reading.mass / reading.std**2
    return replace(likelihood, precision=precision, shift=shift)


def scale_doubts(
    likelihood: Likelihood, reading: MassReading | None, carried: Array | None
) -> tuple[Message, ...]:
    """An error where the scale and the wrench contradict each other, and the scale is
    not to be counted; `likelihood` is that of the wrench alone, `carried` (10,) the
    tool that was subtracted."""
    if reading is None:
        return ()
    mass, variance = likelihood.mass
    deviation = (variance + reading.std**2) ** 0.5
    off = (reading.mass - mass) / deviation
    if not abs(off) > LARGEST_DEVIATION:
        return ()
    if off > 0.0:
        causes = "does the controller subtract a part of it already"
    elif carried is None or not carried.any():
        causes = "does the sensor carry a gripper that was not weighed (`tool`)"
    else:
        causes = "was it weighed without all that the sensor carries beside the tool"
    what = (
        f"the scale shows {reading.mass:.4g} kg, the wrench {mass:.4g} ± "
        f"{variance**0.5:.2g} kg, {abs(off):.0f} standard deviations apart, so the "
        f"scale is left out: is its unit right, {causes}, and is the force in newtons?"
    )
    return (error("mass-contradicts-wrench", what, "mass"),)


def gain_by_scale(equations: Equations, body: Array, limit: float) -> float:
    """Relative error of the sensor's gain, at most `limit`, if the object is `body`
    (10,): by how much its wrench is measured too large."""
    square = float(body @ equations.H @ body)
    ratio = float(body @ equations.h) / square - 1.0 if square > 0.0 else 0.0
    return min(max(ratio, -limit), limit)
