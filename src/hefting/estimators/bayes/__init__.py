"""Bayes: the posterior of an object of known shape and unknown density, under a model of the noise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.estimators.base import INVARIANCES, BiasModel, Estimator, require_bias_model, require_samples
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_CLAIM_EXCESS,
    LARGEST_STRETCH_DISAGREEMENT,
    TimeSamples,
)
from hefting.estimators.bayes.likelihood import SEPARATE_POSE_INTERVAL, Equations, Samples, motion_effect
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.motion_errors import MotionErrors
from hefting.estimators.bayes.posterior import (
    CONTRADICTING_SHAPE_DISTANCE,
    Nearest,
    Posterior,
    contradiction,
    warnings_of,
)
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.projection import projected
from hefting.estimators.quadratic import WrenchNoise, whitening
from hefting.estimators.sample_state import SampleState
from hefting.shapes import Shape

INTERVAL_LEVEL = 0.95
"""Probability of the intervals and of the accuracy that an estimate states."""
MOST_PASSES = 6
"""Largest number of passes in which noise and parameters are found in turn, for a shape that is certain."""
MOST_PASSES_UNCERTAIN_SHAPE = 12
"""The same for an uncertain shape, whose distortion is found too."""
LARGEST_POSE_STD = (10.0, 1.6)
"""[m, rad] Largest standard deviations of a pose that are accepted: larger ones leave it undetermined."""
NEGLIGIBLE_DISTORTION_CHANGE = 0.1
"""Change of the shape's distortion, in prior standard deviations, at which the passes end."""
UNSETTLED_DISTORTION_CHANGE = 0.5
"""Change of the shape's distortion in the last pass, in prior standard deviations, above which it was not found."""
NEGLIGIBLE_VARIANCE_CHANGE = 0.02
"""Relative change of the residual's variances at which the passes end."""
SMALLEST_PRIOR_SCALE = 0.2
"""Lower bound on the prior's mass, as a multiple of the rough mass: it keeps light objects from shrinking to zero."""
LARGEST_PRIOR_SCALE = 2.0
"""Upper bound on the prior's mass, as a multiple of the rough mass."""
SUFFICIENT_CELL_DISTANCE = 1.0
"""Squared Mahalanobis distance, for ten parameters, within which a mass distribution over whole cells is accepted
instead of one over voxels."""


@dataclass(frozen=True, eq=False)
class Bayes(Estimator):
    """Posterior mean, covariance and intervals of a body whose density varies, smoothly or not, about an even one:

        p(phi | samples)  ~  p(samples | phi) p(phi | shape)

    The likelihood knows noise in wrench and motion (`likelihood`), the prior the shape (`prior`); how much the density
    varies is integrated out. The estimate is the non-negative mass distribution nearest to the posterior mean. The
    more the motion tells, the less the shape matters; where it tells little, the intervals say so.

    What is not given of the noise the state finds (`colour`): its size, how long it lasts, and whether parts of the
    record agree. Samples come in order of time. The wrench's scale does not matter where the noise is found; the order
    of samples, and how states are merged, where it is given.
    """

    needs = "a shape"
    consistent = True
    source = "this project, docs/bayes.md"
    best_for = "a known shape, any motion, and wherever it matters how sure the answer is"
    invariances = frozenset(INVARIANCES) - {"sensor origin"}
    keeps_time_record = True

    shape: Shape
    """Where the object may have mass, in the sensor frame."""
    pose_std: tuple[float, float] = (0.0, 0.0)
    """How well the shape's place is known: standard deviations along [m] and about [rad] each axis of its frame."""
    shape_std: float | None = None
    """How well the shape itself is known, as a share of its size; None: as it says (`Shape.shape_std`)."""
    noise: WrenchNoise = None
    """Known white noise of the wrench: levels, with those of the accelerations where samples do not tell them
    (`Measurements.motion_noise`), or a covariance (6, 6). None: found from the residuals, with its colour."""
    systematic: Array | None = None
    """Covariance (10, 10) of an error in the parameters that more samples do not lessen: that of a tool whose wrench
    was subtracted, or of gravity's direction."""
    until: Accuracy | str | None = None
    """How sure is sure enough, as in ``mass=1%,com=2mm,inertia=20%``: estimates then tell what they reach
    (`Estimate.accuracy`) and whether that suffices."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the object."""

    def __post_init__(self):
        require_bias_model(self.bias)
        if isinstance(self.until, str):
            object.__setattr__(self, "until", Accuracy.parse(self.until))
        elif not isinstance(self.until, Accuracy | None):
            raise InputError(f"until is an accuracy, not {self.until}", fix="as in mass=1%,com=2mm,inertia=20%")
        whitening(self.noise)
        if not isinstance(self.shape, Shape):
            raise InputError("the shape must be a Shape", fix="use Shape(positions) or load_shape(file)")
        try:
            pose_std, C = np.array(self.pose_std, dtype=float), self.systematic
            shape_std = None if self.shape_std is None else float(self.shape_std)
        except (TypeError, ValueError):
            raise InputError("pose_std is two numbers [m, rad] and shape_std a share, not text") from None
        if pose_std.shape != (2,) or not ((pose_std >= 0.0) & (pose_std <= LARGEST_POSE_STD)).all():
            raise InputError(
                f"the pose's deviations are two, from 0 to {LARGEST_POSE_STD} [m, rad], not {self.pose_std}"
            )
        if shape_std is not None and not 0.0 <= shape_std <= 1.0:
            raise InputError(f"the shape's deviation is a share from 0 to 1, not {self.shape_std}")
        if C is not None and not (np.shape(C) == (10, 10) and np.isfinite(C).all()):
            raise InputError(f"a systematic error's covariance is (10, 10) and finite, not {np.shape(C)}")

    @cached_property
    def _prior(self) -> Prior:
        shape_std = self.shape.shape_std if self.shape_std is None else self.shape_std
        return Prior.of(self.shape, self.pose_std, shape_std)

    def estimate(self, state: SampleState, start: Estimate | None = None) -> Estimate:
        """The estimate from the samples seen; `start`, an earlier estimate over the same shape, saves time.

        Raises `NotIdentifiableError` when there are no samples, or they determine nothing beside a bias.
        """
        posterior = self.posterior(state, start)
        mixture = posterior.mixture
        nearest = self._nearest_body(posterior)
        body, accuracy, sufficient = InertialParameters(nearest.vector), None, None
        if isinstance(self.until, Accuracy):
            accuracy = Accuracy.of_draws(mixture.draws(), body, INTERVAL_LEVEL)
            sure = posterior.noise_known and not posterior.coloured and not contradiction(posterior, nearest.distance)
            sufficient = sure and self.until.met_by(accuracy)
        return Estimate(
            method=self.name,
            parameters=body,
            samples=state.samples,
            duration=state.duration,
            covariance=mixture.covariance,
            intervals=mixture.intervals(INTERVAL_LEVEL),
            accuracy=accuracy,
            sufficient=sufficient,
            bias=posterior.bias,
            point_masses=nearest.masses,
            hull_margin=nearest.margin,
            warnings=warnings_of(posterior, nearest.distance),
            provenance=posterior.noise_found,
        )

    def _nearest_body(self, posterior: Posterior) -> Nearest:
        """Of cells that are even within or, where those do not do, of voxels."""
        prior, mean, C = posterior.prior, posterior.narrow.mean, posterior.narrow.covariance
        mass = max(float(mean[0]), 1e-3 * float(C[0, 0]) ** 0.5)
        masses, distance = projected(mean, C, prior.cells, prior.shares, mass)
        if distance < SUFFICIENT_CELL_DISTANCE:
            vector = prior.cells @ masses
        else:
            fine, distance = projected(mean, C, prior.voxels, prior.voxel_shares, mass)
            if distance > CONTRADICTING_SHAPE_DISTANCE:  # nothing fits: let at least the mass be right
                fine = (fine + 1e-6 * mass * prior.voxel_shares) * mass / (fine.sum() + 1e-6 * mass)
            vector, masses = prior.voxels @ fine, fine.reshape(self.shape.n, -1).sum(axis=1)
        margin, move = None, posterior.move
        if move is not None and vector[0] > 0.0:
            margin = self.shape.margin(move.back(vector[1:4] / vector[0]))
        return Nearest(vector, masses, distance, margin)

    def posterior(self, state: SampleState, start: Estimate | None = None) -> Posterior:
        """The posterior that `estimate` sums up; its mixture gives intervals of any level. Errors as there."""
        require_samples(state.samples)
        samples, time = Samples.of(state, self.bias == "estimate"), TimeSamples.of(state, self.bias == "estimate")
        _require_information(samples, state)
        known, motion = self._levels(state)
        level = samples.least_residual if known is None else known
        rough = samples.mass_scale(float(level[:3, :3].trace() / 3.0) ** 0.5)
        phi = rough * self._prior.mean if start is None else start.parameters.vector
        at, left = phi, level  # where the noise is judged, and the covariance of the residuals there
        if known is None:
            at, left = (samples.least_squares, level) if start is None else (phi, samples.residual_covariance(phi))
            level = samples.limited_to_noise(left)
        autocorrelation = 1.0
        S = self._covariance(samples, phi, known, level, motion, autocorrelation)
        excess, contradicted, count, P = 1.0, False, 0, None
        placed = self._prior.about(np.zeros(len(self._prior.distortions.shifts)))
        while True:
            count += 1
            scale = float(np.clip(phi[0], SMALLEST_PRIOR_SCALE * rough, LARGEST_PRIOR_SCALE * rough))
            equations = Equations.of(samples, phi, excess * S, motion.white)
            colour = None
            if time is not None and known is None:
                P = equations.inverse if P is None else P
                scores = time.scales.scores(equations.whitening, at, equations.attenuation)
                colour = time.colour(scores, equations.G, P, _mean_square(excess * S, left), False)
            found = (
                equations.white() if colour is None else equations.likelihood(colour.noise_seen + equations.products)
            )
            autocorrelation = 1.0 if colour is None else colour.autocorrelation
            own = mixture = Mixture.of(placed.prior, scale, found)
            P = None if known is not None else equations.spent(found, mixture.covariance)
            determined = mixture.determined(found) if colour is None else colour.fitted
            if self.systematic is not None:
                found = found.blurred(self.systematic)
                mixture = Mixture.of(placed.prior, scale, found)
            phi, at = mixture.mean, own.mean
            left = samples.residual_covariance(at, determined)
            if known is None and samples.excess_over_noise(left) > 1.0:  # what a wrong shape leaves is no noise
                at = samples.least_squares
            before = excess * S
            if known is None:
                S = self._covariance(samples, phi, known, samples.limited_to_noise(left), motion, autocorrelation)
            else:
                S = self._covariance(samples, phi, known, left, motion, autocorrelation)
                ratio = _mean_square(S, left)
                contradicted = ratio > 1.0 + LARGEST_CLAIM_EXCESS * (autocorrelation / (3.0 * samples.K)) ** 0.5
                excess = max(ratio / samples.excess_over_noise(left), 1.0) if contradicted else 1.0
            change = np.abs(excess * S.diagonal() / before.diagonal() - 1.0).max()
            scores = placed.most_likely(mixture.weights, mixture.means)
            moved = float(np.abs(scores - placed.scores).max(initial=0.0))
            if (change < NEGLIGIBLE_VARIANCE_CHANGE and moved < NEGLIGIBLE_DISTORTION_CHANGE) or count >= (
                MOST_PASSES_UNCERTAIN_SHAPE if len(scores) else MOST_PASSES
            ):
                break
            if moved >= NEGLIGIBLE_DISTORTION_CHANGE:
                placed = self._prior.about(scores if count == 1 else 0.5 * (placed.scores + scores))
        wide, disagreement, response = mixture, 0.0, 0.0
        if time is not None:
            scores = time.scales.scores(equations.whitening, at, equations.attenuation)
            if colour is None:
                P = equations.spent(equations.white(), own.covariance)
                colour = time.colour(scores, equations.G, P, _mean_square(before, left), True)
            else:
                response = time.response(scores, equations.G, at, colour)
            disagreement = time.disagreement(equations.whitening, at, equations.attenuation, scores, colour)
            times = disagreement if disagreement > LARGEST_STRETCH_DISAGREEMENT else 1.0
            if known is None or times > 1.0:
                wider = equations.likelihood(times * (colour.noise + equations.products))
                if self.systematic is not None:
                    wider = wider.blurred(self.systematic)
                wide = Mixture.of(placed.prior, scale, wider)
            if response:
                wide = wide.scaled(response)
        return Posterior(
            mixture=wide,
            narrow=mixture,
            prior=placed.prior,
            move=placed.move,
            residual_covariance=before,
            excess=excess,
            contradicted=contradicted,
            autocorrelation=autocorrelation,
            disagreement=disagreement,
            response=response,
            variances=None if colour is None else colour.variances,
            noise_known=known is not None
            or (
                state.record is not None
                and (state.samples >= FEWEST_SAMPLES_FOR_NOISE or samples.pace >= SEPARATE_POSE_INTERVAL)
            ),
            coloured=colour is not None and known is not None and colour.exceeds_claim,
            motion=motion,
            misfit=found.misfit(phi),
            settled=moved < UNSETTLED_DISTORTION_CHANGE,
            passes=count,
            bias=samples.bias(phi) if self.bias == "estimate" else None,
        )

    def _levels(self, state: SampleState) -> tuple[Array | None, MotionErrors]:
        """Covariance (6, 6) of the wrench, None where it is not known, and the errors of the motion."""
        noise, S_w = self.noise, None
        given = None if state.record is None else state.record.motion_noise
        if isinstance(noise, Noise):
            S_w = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
            if given is None:
                given = MotionNoise(noise.linear_acceleration, noise.angular_acceleration)
        elif noise is not None:
            S_w = np.array(noise, dtype=float)
        return S_w, MotionErrors.of(given, state)

    def _covariance(
        self,
        samples: Samples,
        phi: Array,
        known: Array | None,
        R: Array,
        motion: MotionErrors,
        autocorrelation: float,
    ) -> Array:
        """S (6, 6) of one sample's residual at about phi; R (6, 6) is that of the residuals themselves."""
        if known is None:
            S, times = samples.noise_left(R) + samples.unproven(FEWEST_SAMPLES_FOR_NOISE), motion.memory - 1.0
        else:
            S, times = known + np.diag(samples.floor**2), motion.memory
        if motion.variances is not None and times > 0.0:
            E = motion_effect(phi)
            S = S + times / autocorrelation * (E * motion.variances) @ E.T
        return S


def _mean_square(S: Array, R: Array) -> float:
    """Mean square of residuals of covariance R (6, 6), whitened by S (6, 6)."""
    return max(float(np.trace(np.linalg.solve(S, R))) / 6.0, 1e-12)


def _require_information(samples: Samples, state: SampleState) -> None:
    if float(np.abs(samples.A).max()) <= 1e-9 * float(np.abs(state.full.full).max()):
        raise NotIdentifiableError("the samples determine nothing beside a bias", fix="record other orientations")
