"""Recommendation: which of several estimates to trust, judged without the truth.

The rule was chosen among several by what it cost beside the best method of each case, on 1,500 simulated recordings
with the right shape, a bounding box, a shape 20 % too large and one misplaced by 5 mm and 5°, and on grossly wrong
shapes. A shape that is nearly right is worth more than a perfect fit: noise of the accelerations alone makes least
squares contradict the true body. Only where the data determine everything do they overrule the shape.
"""

import numpy as np

from hefting.estimate import Estimate
from hefting.estimators.blend import Blend
from hefting.estimators.quadratic import Quadratic
from hefting.plausibility import com_warnings
from hefting.preparation import Prepared
from hefting.shapes import PointMasses

MISFIT = 100.0
"""Excess chi² above which an estimate contradicts the recording; 10 for the true parameters and perfect motion."""
PRECISE = 0.1
"""Uncertainty of least squares up to which the recording may overrule the shape."""
SUFFICIENT = 0.2
"""Uncertainty of least squares up to which a body without a shape beats point masses."""


def misfit(estimate: Estimate, prepared: Prepared) -> float:
    """Sum of squared residuals above that of unconstrained least squares, in units of the noise's variance.

    For the true parameters this is chi² distributed with as many degrees of freedom as the data determine parameters,
    at most ten; the residuals' correlation in time is allowed for.
    """
    problem = Quadratic.of(Blend.of(prepared.measurements), prepared.fit.noise, prepared.bias == "estimate")
    excess = problem.square(estimate.parameters.vector) - problem.square(problem.least_squares())
    return max(0.0, excess) / prepared.fit.autocorrelation


def uncertainty(prepared: Prepared, shape: PointMasses) -> float:
    """Largest relative standard deviation of unconstrained least squares: of the mass, of the first moment in sizes of
    the shape, of the inertia in that of a rod of its size; infinite where the motion leaves something open."""
    std = np.sqrt(prepared.fit.covariance.diagonal()[:10])
    size = float(np.linalg.norm(shape.extents))
    scale = abs(float(prepared.fit.vector[0])) * np.concatenate(([1.0], np.full(3, size), np.full(6, size**2 / 12.0)))
    return float(np.max(std / scale)) if scale.all() else np.inf


def recommend(results: dict[str, Estimate], prepared: Prepared, shape: PointMasses | None) -> tuple[str, str]:
    """Name of the estimate to trust, and a sentence why."""
    bodies = {k: e for k, e in results.items() if e.parameters.consistency().is_consistent}
    if not bodies:
        best = min(results, key=lambda name: misfit(results[name], prepared))
        return best, "no method found a body that can exist; this one explains the wrench best"
    free = next((name for name in ("LMI", "OLS") if name in bodies), None)
    if shape is not None:
        if free is not None and com_warnings(prepared.fit, shape):
            return free, "without the shape the centre of mass is well outside it: check the shape's pose and unit"
        s = uncertainty(prepared, shape)
        if "GEO" in bodies:
            chi2 = misfit(bodies["GEO"], prepared)
            if chi2 <= MISFIT or s > PRECISE or free is None:
                fits = "fits the recording" if chi2 <= MISFIT else "is worth more than this recording alone"
                return "GEO", f"the shape {fits} (misfit {chi2:.0f}; expected about 10), and GEO weighs both"
            return (
                free,
                f"the recording contradicts the shape (misfit {chi2:.0f}; about 10 expected) and suffices alone",
            )
        if free is not None and s < SUFFICIENT:
            return free, f"the recording determines all parameters to {100 * s:.0f} % of a body of this size"
        for name in ("PMD", "HPS"):
            if name in bodies:
                return name, "the recording is too poor to do without the shape"
    if free is not None:
        return free, "explains the wrench best of all bodies that can exist" + (
            "; no shape is known" if not shape else ""
        )
    best = min(bodies, key=lambda name: misfit(bodies[name], prepared))
    return best, "a body that can exist"
