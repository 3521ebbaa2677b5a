"""Recommendation: which of several estimates to trust, judged without the truth."""

from hefting.estimate import Estimate
from hefting.estimators.blend import Blend
from hefting.estimators.quadratic import Quadratic
from hefting.preparation import Prepared

PREFERENCE = ("GEO", "PMD", "HPS", "LMI", "OLS", "RTLS")
"""Among estimates that explain the wrench alike."""
MISFIT = 35.0
"""Excess chi² above which an estimate is not compatible with the data: ten parameters exceed it once in 10,000."""


def misfit(estimate: Estimate, prepared: Prepared) -> float:
    """Sum of squared residuals above that of unconstrained least squares, in units of the noise's variance.

    For the true parameters this is chi² distributed with as many degrees of freedom as the data determine parameters,
    at most ten; the residuals' correlation in time is allowed for.
    """
    problem = Quadratic.of(Blend.of(prepared.measurements), prepared.fit.noise, prepared.bias == "estimate")
    excess = problem.square(estimate.parameters.vector) - problem.square(problem.least_squares())
    return max(0.0, excess) / prepared.fit.autocorrelation


def recommend(results: dict[str, Estimate], prepared: Prepared) -> tuple[str, str]:
    """Name of the estimate to trust, and a sentence why."""
    order = sorted(results, key=lambda name: PREFERENCE.index(name) if name in PREFERENCE else len(PREFERENCE))
    consistent = [name for name in order if results[name].physically_consistent]
    chi2 = {name: misfit(results[name], prepared) for name in order}
    for name in consistent:
        if chi2[name] <= MISFIT:
            return name, "a consistent body that explains the wrench as well as unconstrained least squares does"
    if consistent:
        best = min(consistent, key=lambda name: chi2[name])
        return (
            best,
            "of the consistent bodies the one that explains the wrench best; none does as well as least squares",
        )
    best = min(order, key=lambda name: chi2[name])
    return best, "no method found a consistent body; this one explains the wrench best"
