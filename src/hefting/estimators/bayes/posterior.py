"""Posterior: what is known of an object after the samples seen, and what gives doubt."""

from dataclasses import dataclass

from hefting.estimators.bayes.distortion import Move
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.prior import Prior
from hefting.spatial import Array

ELSEWHERE = 30.0
"""Squared distance, in standard deviations of all ten numbers, beyond which the shape is wrong: some five standard
deviations more than expected."""
MISFIT = 100.0
"""Squared distance from what the samples alone say, for ten numbers, beyond which it is wrong too."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is known of the object after the samples seen."""

    mixture: Mixture
    """of the ten parameters"""
    prior: Prior
    """what the shape said; a shape that is uncertain is where it most likely is"""
    move: Move | None
    """which puts it there; None for a shape that is certain"""
    residual_covariance: Array
    """(6, 6) of the wrench, as modelled [N², N² m, N² m²]"""
    excess: float
    """variance of the residuals over that of the noise claimed; 1 where it was found from them"""
    contradicted: bool
    """whether that is more than chance"""
    misfit: float
    """squared distance of the mean from what the samples alone say, in standard deviations"""
    settled: bool
    """whether the place of a shape that is uncertain was found"""
    passes: int
    """how often the noise was found anew"""
    bias: Array | None
    """(6,) wrench bias [N, N m]; None where none is free"""


@dataclass(frozen=True, eq=False)
class Nearest:
    """The non-negative mass distribution nearest to the posterior mean."""

    vector: Array
    """(10,)"""
    masses: Array
    """(n,) in each point's cell [kg]"""
    distance: float
    """squared, in standard deviations"""
    margin: float | None
    """of its COM in the hull, where the shape most likely is; None for a certain shape"""


def contradiction(posterior: Posterior, distance: float) -> float:
    """Squared distance [standard deviations] of the shape from the wrench, where it is more than chance; else 0."""
    return max(distance if distance > ELSEWHERE else 0.0, posterior.misfit if posterior.misfit > MISFIT else 0.0)


def warnings_of(posterior: Posterior, distance: float, disagreement: float) -> tuple[str, ...]:
    """A sentence for each doubt; `distance` is squared, as in `Nearest`."""
    warnings = []
    if posterior.contradicted:
        times = posterior.excess**0.5
        warnings.append(
            f"the residuals are {times:.2g} times the noise that was given: the intervals are wider by that"
        )
    if disagreement > 1.0:
        warnings.append(
            "the recording contradicts its own model (is the sensor linear, its bias constant, the object fixed?): its "
            f"stretches differ {disagreement**0.5:.1f} times as much as they should; the intervals are wider by that"
        )
    far = contradiction(posterior, distance)
    if not posterior.settled:
        warnings.append("where the shape is could not be found: its pose or size is too uncertain for this recording")
    if far:
        warnings.append(
            f"no mass inside the shape explains the wrench: the nearest is {far**0.5:.0f} standard deviations away"
        )
    return tuple(warnings)
