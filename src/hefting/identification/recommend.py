"""Recommendation: which of several estimates to trust, judged without the truth.

The rule was chosen among several by its error relative to the best method of each case,
on simulated recordings with the right shape, a bounding box, a shape 20 % too large and
one misplaced by 5 mm and 5°, and on grossly wrong shapes. An approximate shape improves
the estimate more than a smaller residual does: noise of the accelerations alone makes
least squares contradict the true body. The data overrule the shape only where they
determine all parameters. In each of the four cases, the Bayesian estimate, where it
explains the wrench, had the smallest median error of COM and inertia.

The class of a method states its role (`hefting.estimators.base.ROLES`).
"""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.estimators import METHODS
from hefting.estimators.base import Role
from hefting.estimators.quadratic import Quadratic
from hefting.ingest.ingest import Ingested
from hefting.shapes import Shape

MISFIT = 100.0
"""Excess chi² above which an estimate contradicts the recording; 10 for the true
parameters and perfect motion."""
PRECISE = 0.1
"""Uncertainty of least squares up to which the recording may overrule the shape."""
SUFFICIENT = 0.2
"""Uncertainty of least squares up to which a body without a shape beats point
masses."""
LARGER_RESIDUAL = 1.1
"""Ratio of a residual to the least of all methods from which on it is told."""
OUTSIDE = 0.02
"""Depth outside the shape's hull, over its largest side, from which the COM contradicts
the shape."""


def misfit(estimate: Estimate, found: Ingested) -> float:
    """Sum of squared residuals above that of unconstrained least squares, in units of
    the noise's variance.

    For the true parameters this is chi² distributed with as many degrees of freedom as
    the data determine parameters, at most ten; the residuals' correlation in time is
    taken into account. Where a scale told a gain of the sensor, or the user how accurate
    it is, single channels may be wrong by as much: that share of the wrench is no
    misfit.
    """
    problem = Quadratic.of(found.state, found.fit.noise, found.bias == "estimate")
    excess = problem.square(estimate.sensed_vector) - problem.square(
        problem.least_squares()
    )
    gain = abs(float(estimate.provenance.get("sensor_gain", 0.0)))
    if told := estimate.provenance.get("sensor_accuracy"):
        gain = max(gain, SensorAccuracy.parse(told).gain_std)
    explained = problem.A @ estimate.sensed_vector
    excess -= gain**2 * float(explained @ explained)
    return max(0.0, excess) / found.fit.autocorrelation


def uncertainty(found: Ingested, shape: Shape) -> float:
    """Largest relative standard deviation of the ten parameters by unconstrained least
    squares.

    That of the mass is relative to the mass m, that of the first moment to m times the
    size of the shape, that of the inertia to a rod of mass m and that size. Infinite if
    a parameter is undetermined.
    """
    std = np.sqrt(found.fit.covariance.diagonal()[:10])
    size = float(np.linalg.norm(shape.extents))
    scale = abs(float(found.fit.vector[0])) * np.concatenate(
        ([1.0], np.full(3, size), np.full(6, size**2 / 12.0))
    )
    return float(np.max(std / scale)) if scale.all() else np.inf


def recommend(
    results: dict[str, Estimate],
    found: Ingested,
    shape: Shape | None,
    seen: dict[str, Ingested] | None = None,
) -> tuple[str, str]:
    """Choose an estimate.

    Parameters
    ----------
    results : dict
        Estimates by method.
    found : Ingested
        The recording as read and conditioned.
    shape : Shape, optional
        Shape of the object.
    seen : dict, optional
        The part of the recording that a method used, by method; by default all of it.

    Returns
    -------
    tuple of str
        Name of the method, and a sentence that gives the reason.
    """
    bodies = {
        name: e
        for name, e in results.items()
        if e.parameters.consistency().is_consistent
    }
    if not bodies:
        best = min(results, key=lambda name: misfit(results[name], found))
        return (
            best,
            "no method found a body that can exist; this one explains the wrench best",
        )
    free, prior = _first("free", bodies), _first("prior", bodies)
    posterior, explains, why = _first("posterior", bodies), False, ""
    if posterior is not None:
        chi2 = misfit(bodies[posterior], (seen or {}).get(posterior, found))
        explains = chi2 <= MISFIT
        why = explanation(posterior, bodies, chi2)
        if shape is None and explains:
            return posterior, why
    if shape is None:
        if free is None:
            best = min(bodies, key=lambda name: misfit(bodies[name], found))
            return best, "a body that can exist"
        return free, "the body that explains the wrench best; no shape is known"
    margin = bodies[prior].hull_margin if prior is not None else None
    if free is not None and (
        _is_outside(bodies[free], found, shape)
        or (margin is not None and margin < -OUTSIDE)
    ):
        return (
            free,
            "without the shape the COM is outside it: check the shape's pose and unit",
        )
    if posterior is not None and explains:
        return posterior, why
    s = uncertainty(found, shape)
    if prior is not None:
        chi2 = misfit(bodies[prior], found)
        if chi2 <= MISFIT:
            return (
                prior,
                "it explains the wrench to within the noise and else keeps to the shape",
            )
        if s > PRECISE or free is None:
            return (
                prior,
                f"the recording alone leaves {100 * s:.0f} % open: the shape is worth more than a closer fit",
            )
        return (
            free,
            "the recording contradicts the shape and suffices alone",
        )
    if free is not None and s < SUFFICIENT:
        return (
            free,
            f"the recording determines all parameters to {100 * s:.0f} % of a body of this size",
        )
    if (inside := _first("shape", bodies)) is not None:
        return inside, "the recording is too poor to do without the shape"
    return next(iter(bodies)), "the only body that can exist" if len(
        bodies
    ) == 1 else "a body that can exist"


def explanation(name: str, bodies: dict[str, Estimate], chi2: float) -> str:
    """Why a posterior is recommended, given its misfit: what its residual is beside the
    least."""
    own = bodies[name].residual
    others = [e.residual for e in bodies.values() if e.residual is not None]
    ratio = 1.0
    if own is not None and others:
        least = np.maximum(np.min(others, axis=0), 1e-300)
        ratio = float(np.max(own / least))
    if ratio > LARGER_RESIDUAL:
        return (
            f"it says how sure it is; it leaves {ratio:.1f} times the residual of the "
            f"closest fit, which noise that changes slowly explains"
        )
    return "it explains the wrench to within the noise and says how sure it is"


def _first(role: Role, bodies: dict[str, Estimate]) -> str | None:
    """The first method of a role whose estimate is among `bodies`; None if there is
    none."""
    return next(
        (
            name
            for name, kind in METHODS.items()
            if kind.role == role and name in bodies
        ),
        None,
    )


def _is_outside(estimate: Estimate, found: Ingested, shape: Shape) -> bool:
    """Whether a COM estimated without the shape is outside its hull by more than
    `OUTSIDE` and three standard deviations."""
    if (
        estimate.hull_margin is None
        or not np.isfinite(found.fit.covariance.diagonal()[1:4]).all()
    ):
        return False
    spread = (
        float(np.sqrt(found.fit.covariance.diagonal()[1:4].max()))
        / estimate.parameters.mass
    )
    return estimate.hull_margin < -OUTSIDE - 3.0 * spread / (
        float(shape.extents.max()) or 1.0
    )
