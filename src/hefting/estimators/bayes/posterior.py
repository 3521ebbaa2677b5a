"""Posterior of an object's parameters, and warnings of doubts about it."""

from typing import Any

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_STRETCH_DISAGREEMENT,
)
from hefting.estimators.bayes.distortion import Move
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.nearest import CONTRADICTING_SHAPE_DISTANCE
from hefting.estimators.bayes.noise_found import MotionErrors
from hefting.estimators.bayes.passes import Pass, Passes
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.samples import SEPARATE_POSE_INTERVAL, Samples
from hefting.estimators.joint_state import State, motion_record
from hefting.shapes import Shape

CONTRADICTING_LIKELIHOOD_DISTANCE = 100.0
"""Squared Mahalanobis distance, for ten parameters, of the posterior mean from the
likelihood's maximum, above which the shape contradicts the wrench."""
DOUBTFUL_SHAPE_DISTANCE = 20.0
"""The sum of that distance and of the posterior mean's from the nearest body in the
shape, above which the shape is in doubt. It is at most 17 for 150 right shapes in
simulated recordings; four of 238 in real ones exceed it, which are in doubt anyway."""
CLEAR_EVIDENCE = 5.0
"""`Passes.evidence` from which on no other way to give the shape is tried, which takes
longer than an estimate. In 39 recordings with the right shape it is 5 to 34; in those
of 117 with wrong shapes that are named it is at most 0."""
LEAST_EVIDENCE = -4.0
"""`Passes.evidence` below which the shape contradicts the wrench. It is larger for
these bodies with the right shape, for 358 with it 5 mm and 5° off, and for 110 on real
sensors."""
LARGEST_RESPONSE_SHARE = 0.5**0.5
"""Largest share of the error by uneven response in the mass's standard deviation that
needs no warning: beyond, it is the larger part."""


@immutable
class Posterior:
    """Posterior of the parameters and of the noise after the samples of a state."""

    mixture: Mixture
    """of the ten parameters: the estimate is its mean, the intervals its quantiles"""
    last: Pass
    """the last pass to it"""
    prior: Prior
    """by the shape; an uncertain shape is placed where it most likely is"""
    move: Move | None
    """places the shape there; None for a certain shape"""
    residual_covariance: Array
    """(6, 6) of the wrench, as modelled [N², N² m, N² m²]"""
    excess: float
    """variance of the residuals over that of the claimed noise; 1 if it was found"""
    contradicted: bool
    """whether that is more than chance"""
    autocorrelation: float
    """variance of the parameters over that with white noise"""
    disagreement: float
    """variance between stretches over the claimed one; 0 for too few stretches"""
    response: float
    """relative error of the body by errors of the wrench in step with the motion"""
    variances: Array | None
    """(J + 1,) of the residuals at each time scale, over that of one sample"""
    noise_known: bool
    """whether the noise was given, or there are enough samples to find it"""
    coloured: bool
    """whether the noise was given as white, and the residuals are not"""
    motion: MotionErrors
    """errors of the accelerations"""
    shape_known: bool
    """whether there is a shape, not only the neighbourhood of the sensor"""
    misfit: float
    """squared Mahalanobis distance of the mean from the likelihood's maximum"""
    evidence: float
    """`Passes.evidence` of the shape, less the gain of another way to give it"""
    instead: str
    """the much likelier way in which the shape was given, in words"""
    samples: Samples | None
    """with a bias of their own; None where none is free"""
    settled: bool = True
    """whether the place of an uncertain shape converged"""
    passes: int = 0
    """number of passes in which the noise was found"""
    scale_doubts: tuple[Message, ...] = ()
    """messages on a scale's reading that contradicts the wrench"""
    sensor_gain: float | None = None
    """relative error of the sensor's gain, by a scale's reading; None without one"""

    def bias_beside(self, body: Array) -> Array | None:
        """(6,) wrench bias [N, N m] beside a body (10,); None where none is free."""
        if self.samples is None:
            return None
        return self.samples.bias((1.0 + (self.sensor_gain or 0.0)) * body)

    @property
    def noise_found(self) -> dict[str, Any]:
        """What was found of the noise, for an estimate's provenance."""
        found: dict[str, Any] = {
            "autocorrelation": float(self.autocorrelation),
            "disagreement": float(self.disagreement),
            "response": float(self.response),
        }
        if self.sensor_gain is not None:
            found["sensor_gain"] = self.sensor_gain
        if self.motion.variances is not None:
            linear, angular = np.sqrt(self.motion.variances[[0, 3]])
            found |= {
                "motion_noise": (float(linear), float(angular)),
                "motion_memory": self.motion.memory,
            }
        return found


def posterior_of(
    state: State,
    steps: Passes,
    last: Pass,
    shape: Shape,
    settled: bool = True,
    passes: int = 0,
    as_given: bool = True,
) -> Posterior:
    """The posterior in a shape from the last pass. Other ways to give the shape are
    tried unless it is `as_given` for sure; other arguments as in `Posterior`."""
    source, noise, found = steps.source, last.noise, last
    misfit = found.likelihood.misfit(found.mixture.mean)
    # no body in the shape explains the wrench
    if misfit > CONTRADICTING_LIKELIHOOD_DISTANCE:
        found = steps.without_shape(found)
    known = source.given is not None
    enough = state.samples >= FEWEST_SAMPLES_FOR_NOISE
    slow = source.samples.pace >= SEPARATE_POSE_INTERVAL
    gain = steps.sensor_gain(found)
    colour = noise.colour
    evidence, instead, more = 0.0, "", 0.0
    if shape.known == "object":
        evidence = steps.evidence(last)
        if not as_given and evidence < CLEAR_EVIDENCE:
            instead, more = steps.likeliest_way(last, shape.pose)
    return Posterior(
        mixture=found.mixture,
        last=last,
        prior=found.placed.prior,
        move=found.placed.move,
        residual_covariance=noise.equations.covariance,
        excess=noise.excess,
        contradicted=noise.contradicted,
        autocorrelation=noise.autocorrelation,
        disagreement=found.disagreement,
        response=noise.response,
        variances=None if colour is None else colour.variances,
        noise_known=known or (motion_record(state) is not None and (enough or slow)),
        coloured=colour is not None and known and colour.exceeds_claim,
        motion=source.motion,
        shape_known=shape.known != "reach",
        misfit=misfit,
        evidence=min(evidence, -more) if more else evidence,
        instead=instead if evidence + more > 0.0 else "",
        samples=source.samples if source.free_bias else None,
        settled=settled,
        passes=passes,
        sensor_gain=gain,
    )


def contradiction(posterior: Posterior, distance: float) -> float:
    """Squared distance of the shape from the wrench if it is significant, else 0."""
    return max(
        distance if distance > CONTRADICTING_SHAPE_DISTANCE else 0.0,
        posterior.misfit
        if posterior.misfit > CONTRADICTING_LIKELIHOOD_DISTANCE
        else 0.0,
    )


def excludes_shape(posterior: Posterior, distance: float) -> bool:
    """Whether the wrench contradicts the shape, or another one is much likelier."""
    unlikely = posterior.evidence < LEAST_EVIDENCE and not _is_accounted(posterior)
    return unlikely or contradiction(posterior, distance) > 0.0


def _is_accounted(posterior: Posterior) -> bool:
    """Whether noise or stretches contradict the model whatever the shape is."""
    return (
        posterior.contradicted
        or posterior.coloured
        or posterior.disagreement > LARGEST_STRETCH_DISAGREEMENT
    )


def mass_is_negative(posterior: Posterior) -> bool:
    """Whether the samples alone give a significantly negative mass."""
    mass, variance = posterior.last.likelihood.mass
    return mass < -((CONTRADICTING_LIKELIHOOD_DISTANCE * variance) ** 0.5)


def doubtful_shape(posterior: Posterior, distance: float) -> float:
    """Squared distance of likely bodies in the shape from the wrench if it exceeds that
    of right shapes, else 0."""
    both = posterior.misfit + distance
    doubtful = posterior.shape_known and both > DOUBTFUL_SHAPE_DISTANCE
    return both if doubtful and not _is_accounted(posterior) else 0.0


def warnings_of(posterior: Posterior, distance: float) -> tuple[Message, ...]:
    """Messages on doubts about the posterior; `distance` squared, as in `Nearest`."""
    return (
        *_noise_warnings(posterior),
        *_shape_warnings(posterior, distance),
        *posterior.scale_doubts,
    )


def _noise_warnings(posterior: Posterior) -> list[Message]:
    warnings: list[Message] = []
    if not posterior.noise_known:
        what = "too few samples to know the noise: the intervals assume that of a typical sensor"
        warnings.append(warning("noise-unknown", what))
    if posterior.contradicted:
        times = posterior.excess**0.5
        what = f"the residuals are {times:.2g} times the noise that was given: the intervals are wider by that"
        warnings.append(warning("noise-exceeds-claim", what, "noise"))
    if posterior.coloured:
        what = "white noise was given, and the residuals are not: without `noise` the intervals would allow for that"
        warnings.append(warning("noise-coloured", what, "noise"))
    if posterior.disagreement > LARGEST_STRETCH_DISAGREEMENT:
        what = (
            "the recording contradicts its own model (is the sensor linear, its bias constant, the object "
            f"fixed?): its stretches differ {posterior.disagreement**0.5:.1f} times as much as noise does; the "
            "intervals allow for it"
        )
        warnings.append(warning("stretches-disagree", what))
    uneven = posterior.response * posterior.mixture.mean[0]
    if uneven > LARGEST_RESPONSE_SHARE * posterior.mixture.mass_std:
        what = (
            "fast and slow changes of the wrench contradict each other (is the sensor linear, its clock that of "
            f"the motion, the arm stiff?): the intervals allow for {100.0 * posterior.response:.2g} %"
        )
        warnings.append(warning("response-uneven", what))
    return warnings


def _exclusion(posterior: Posterior, far: float) -> Message:
    """The message on a shape that is excluded; `far` is its `contradiction`, zero where
    another shape is only much likelier."""
    where, so = "near the sensor", "of one that is long or far give `shape`"
    if posterior.shape_known:
        where = "inside the shape"
        so = (
            "the answer is without the shape: is it the right one, of the right size, where "
            "`object_pose` says (else at the sensor), and is a gripper held, too (`tool`)?"
        )
    if posterior.instead:
        so = f"the answer is without the shape, which would fit {posterior.instead}"
    times = np.exp(min(-posterior.evidence, 20.0))
    what = f"the wrench is {times:.2g} times as likely that of another shape, or of one elsewhere; {so}"
    if far:
        what = f"no mass {where} explains the wrench: the nearest is {far**0.5:.0f} standard deviations away; {so}"
    return warning("shape-contradicts-wrench", what, "shape")


def _shape_warnings(posterior: Posterior, distance: float) -> list[Message]:
    warnings: list[Message] = []
    if not posterior.settled:
        warnings.append(
            warning(
                "shape-not-found",
                "where the shape is could not be found: its pose or size is too uncertain for this recording",
                "shape",
            )
        )
    far = contradiction(posterior, distance)
    if far and mass_is_negative(posterior):
        what = "no positive mass explains the wrench: check `sign` and `gravity`"
        warnings.append(error("no-positive-mass", what, "sign"))
    elif excludes_shape(posterior, distance):
        warnings.append(_exclusion(posterior, far))
    elif doubt := doubtful_shape(posterior, distance):
        warnings.append(
            warning(
                "shape-contradicts-wrench",
                "the shape hardly explains the wrench (is it the right one, in the right place and size?): likely "
                f"bodies in it are {doubt**0.5:.1f} standard deviations away",
                "shape",
            )
        )
    return warnings
