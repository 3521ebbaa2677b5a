"""Bayes: the posterior of an object of known shape and unknown density, under a model
of the noise."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.quantity import MassReading
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators.base import (
    INVARIANCES,
    BiasModel,
    Estimator,
    Known,
    require_samples,
    stated_errors,
    take_errors,
)
from hefting.estimators.bayes.likelihood import scale_doubts
from hefting.estimators.bayes.mixture import INTERVAL_LEVEL, holding, prior_mixture
from hefting.estimators.bayes.nearest import Duals, duals_of, nearest_body
from hefting.estimators.bayes.noise import NoiseSource
from hefting.estimators.bayes.passes import Pass, Passes
from hefting.estimators.bayes.posterior import (
    Posterior,
    doubtful_shape,
    excludes_shape,
    posterior_of,
    warnings_of,
)
from hefting.estimators.bayes.prior import Prior, prior_of
from hefting.estimators.bayes.samples import require_information
from hefting.estimators.joint_state import State, WhitenedState, states_of
from hefting.estimators.quadratic import WrenchNoise
from hefting.estimators.sample_state import require_weight
from hefting.shapes import Shape

MOST_PASSES = 6
"""Largest number of passes in which noise and parameters are found in turn, for a shape
that is certain."""
MOST_PASSES_UNCERTAIN_SHAPE = 12
"""The same for an uncertain shape, whose distortion is found as well."""
LARGEST_POSE_STD = (10.0, 1.6)
"""[m, rad] Largest accepted standard deviations of a pose: beyond it is open."""
NEGLIGIBLE_DISTORTION_CHANGE = 0.1
"""Change of the shape's distortion, in prior deviations, at which the passes end."""
NEGLIGIBLE_COM_CHANGE = 0.03
"""Change of the COM about which the prior is linear, over half the shape's diagonal, at
which the passes end. The error of the linearisation is of second order."""
UNCHANGED_COM = 0.005
"""The same at which the first pass from an earlier estimate is the only one; smaller,
as no second pass confirms it."""
UNSETTLED_DISTORTION_CHANGE = 0.5
"""Change of the shape's distortion in the last pass, in prior standard deviations,
above which it has not converged."""
NEGLIGIBLE_VARIANCE_CHANGE = 0.02
"""Relative change of the residual's variances at which the passes end."""


@dataclass(frozen=True, eq=False)
class Bayes(Estimator):
    """Posterior mean, covariance and intervals of a body whose density varies about a
    uniform one:

        p(phi | samples)  ~  p(samples | phi) p(phi | shape)

    The likelihood models noise in wrench and motion (`likelihood`), the prior the shape
    (`prior`); the amount by which the density varies is integrated out. The estimate is
    the non-negative mass distribution nearest to the posterior mean. The more
    informative the motion, the less the shape matters; with an uninformative one the
    intervals are wide.

    Noise that is not given is estimated from the samples (`colour`): its variance, its
    autocorrelation, and whether stretches of the record agree. Samples are in order of
    time. With estimated noise the result does not depend on the scale of the wrench;
    with given noise it does not depend on the order of samples and of merging states.

    Examples
    --------
    >>> shape = hefting.load_shape("box:-0.1,0.1,-0.3,0.3,0,0.3")
    >>> bayes = hefting.Bayes(shape, bias="estimate", until="mass=1%")
    >>> state = bayes.update(bayes.start(), measurements)
    >>> bayes.estimate(state).sufficient
    True
    """

    rank = 10
    role = "posterior"
    fills_in = "an object of any shape near the sensor"
    consistent = True
    gives_covariance = True
    source = "this project, docs/bayes.md"
    best_for = "any motion, above all with a shape; it says how sure it is"
    invariances = frozenset(INVARIANCES)
    keeps_time_record = True

    shape: Shape = field(default_factory=Shape.unknown)
    """Where the object may have mass, in the sensor frame; by default anywhere within
    0.5 m of the sensor (`Shape.unknown`)."""
    pose_std: tuple[float, float] | None = None
    """How well the shape's place is known: standard deviations along [m] and about
    [rad] each axis of its frame; (0, 0) is exact. None: perhaps exact, perhaps some
    5 mm and 5 degrees off (`distortion.TYPICAL_POSE_STD`)."""
    shape_std: float | None = None
    """How well the shape itself is known, as a share of its size; None: as it says
    (`Shape.shape_std`)."""
    noise: WrenchNoise = None
    """Known white noise of the wrench: levels, with those of the accelerations where
    samples do not tell them (`Measurements.motion_noise`), or a covariance (6, 6).
    None: found from the residuals, with its colour."""
    sensor_accuracy: SensorAccuracy | str | None = None
    """How far the sensor may be off in 95 % of the cases, which more samples do not
    lessen: gain, cross-talk and hysteresis over the load, an offset in N and N m, as in
    ``0.5% 0.3N 0.01Nm``, or a sensor's name (`SensorAccuracy`). None: half a percent,
    and nothing where `noise` is given."""
    systematic: Array | None = None
    """Covariance (10, 10) of an error in the parameters that more samples do not
    lessen: that of a tool whose wrench was subtracted, or of gravity's direction."""
    carried: Array | None = None
    """Parameters (10,) of what the sensor holds besides the object, a tool whose wrench
    was subtracted: errors of the sensor follow the wrench of both."""
    mass: MassReading | tuple[float, float] | str | None = None
    """What a scale showed of the object alone, as in ``0.512kg±1g``, with one standard
    deviation (`MassReading`)."""
    until: Accuracy | str | None = None
    """How sure is sure enough, as in ``mass=1%,com=2mm,inertia=20%``: estimates then
    tell what they reach (`Estimate.accuracy`) and whether that suffices."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    object."""

    def __post_init__(self):
        super().__post_init__()
        if isinstance(self.until, str):
            object.__setattr__(self, "until", Accuracy.parse(self.until))
        elif not isinstance(self.until, Accuracy | None):
            what = f"until is an accuracy, not {self.until}"
            raise InputError(what, fix="as in mass=1%,com=2mm,inertia=20%")
        try:
            pose_std = np.zeros(2) if self.pose_std is None else self.pose_std
            pose_std = np.array(pose_std, dtype=float)
            shape_std = None if self.shape_std is None else float(self.shape_std)
        except (TypeError, ValueError):
            raise InputError(
                "pose_std is two numbers [m, rad] and shape_std a share, not text"
            ) from None
        if (
            pose_std.shape != (2,)
            or not ((pose_std >= 0.0) & (pose_std <= LARGEST_POSE_STD)).all()
        ):
            raise InputError(
                f"the pose's deviations are two, from 0 to {LARGEST_POSE_STD} [m, rad], not {self.pose_std}"
            )
        if shape_std is not None and not 0.0 <= shape_std <= 1.0:
            raise InputError(
                f"the shape's deviation is a share from 0 to 1, not {self.shape_std}"
            )
        take_errors(self)

    @classmethod
    def settings(cls, known: Known, model: str | None = None) -> dict[str, Any]:
        """As `Estimator.settings`, with the shape's deviation, without the noise."""
        shape = Shape.unknown() if known.shape is None else known.shape
        shape_std: float | None = shape.shape_std
        if shape.known != "object":
            shape_std = None
        own = {
            "shape": shape,
            "noise": None,
            "shape_std": shape_std,
            "systematic": known.systematic,
            "carried": known.carried,
        }
        return super().settings(known, model) | own

    @property
    def provenance(self) -> dict[str, Any]:
        """As `Estimator.provenance`, with the kind of a shape that is only bounds."""
        found = super().provenance | stated_errors(self)
        if self.shape_std is not None or self.shape.known == "object":
            return found
        return found | {"shape_known": self.shape.known}

    @property
    def asked(self) -> Accuracy | None:
        """The accuracy that `until` asks for."""
        return self.until if isinstance(self.until, Accuracy) else None

    def continued(
        self, state: State, before: Estimate | Pass | None
    ) -> tuple[Estimate, Pass]:
        """The estimate, and the last pass to it as the start of the next. Errors as for
        `estimate`."""
        posterior = self.posterior(state, before)
        duals = before.duals if isinstance(before, Pass) else None
        estimate, duals = self._summary(state, posterior, duals)
        return estimate, replace(posterior.last, duals=duals)

    def prepared(self, state: State, before: Estimate | Pass | None) -> Pass:
        """The last pass to the estimate."""
        last = self.posterior(state, before).last
        return replace(last, duals=before.duals) if isinstance(before, Pass) else last

    def of_more(self, state: State, prepared: Pass) -> tuple[Estimate, Pass]:
        """As `Estimator.of_more`, with the noise found before unless the residuals have
        grown or a scale's reading is in doubt."""
        steps = self._passes(state)
        if prepared.noise.holds_for(steps.source.samples):
            last = steps.of_more(prepared)
            if not scale_doubts(last.wrench, steps.reading, self.carried):
                found = posterior_of(state, steps, last, self.shape)
                estimate, duals = self._summary(state, found, prepared.duals)
                return estimate, replace(prepared, duals=duals)
        estimate, left = super().of_more(state, prepared)
        return estimate, replace(prepared, duals=left.duals)

    @cached_property
    def _size(self) -> float:
        """Half the diagonal of the bounding box [m]."""
        return 0.5 * float(np.linalg.norm(self.shape.extents)) or 1.0

    @cached_property
    def _prior(self) -> Prior:
        if self.shape_std is None and self.shape.known != "object":
            return prior_of(self.shape, None, None)
        shape_std = self.shape.shape_std if self.shape_std is None else self.shape_std
        pose_std = None if self.pose_std is None else tuple(self.pose_std)
        return prior_of(self.shape, pose_std, shape_std)

    def estimate(self, state: State, start: Estimate | None = None) -> Estimate:
        """The estimate from the samples seen; `start`, an earlier estimate over the
        same shape, saves time.

        Raises `NotIdentifiableError` when there are no samples, or they determine
        nothing beside a bias.
        """
        posterior = self.posterior(state, start)
        masses = None if start is None else start.point_masses
        duals = duals_of(masses, posterior.prior)
        return self._summary(state, posterior, duals)[0]

    def _summary(
        self, state: State, posterior: Posterior, duals: Duals | None
    ) -> tuple[Estimate, Duals]:
        """The estimate from its posterior, or of an object of any shape if the samples
        contradict the shape; and the start of the next search for a nearest body, which
        here was `duals`."""
        mixture = posterior.mixture
        nearest = nearest_body(
            posterior.prior, posterior.move, posterior.mixture, self.shape, duals
        )
        if self.shape.known != "reach" and excludes_shape(posterior, nearest.distance):
            free = replace(self, shape=Shape.unknown(), pose_std=None, shape_std=None)
            found = free.estimate(state)
            estimate = replace(
                found,
                sufficient=None if self.until is None else False,
                warnings=warnings_of(posterior, nearest.distance),
                provenance=found.provenance | {"shape_known": "reach"},
            )
            return estimate, nearest.duals
        body, accuracy, sufficient = InertialParameters(nearest.vector), None, None
        if isinstance(self.until, Accuracy):
            accuracy = Accuracy.of_draws(mixture.draws(), body, INTERVAL_LEVEL)
            sure = (
                posterior.noise_known
                and not posterior.coloured
                and not posterior.scale_doubts
                and not excludes_shape(posterior, nearest.distance)
                and not doubtful_shape(posterior, nearest.distance)
            )
            sufficient = sure and self.until.met_by(accuracy)
        estimate = Estimate(
            method=self.name,
            parameters=body,
            samples=state.samples,
            duration=state.duration,
            covariance=mixture.covariance,
            intervals=holding(mixture.ends(INTERVAL_LEVEL), body),
            accuracy=accuracy,
            sufficient=sufficient,
            bias=posterior.bias_beside(nearest.vector),
            point_masses=None if self.shape.known == "reach" else nearest.masses,
            hull_margin=nearest.margin,
            warnings=warnings_of(posterior, nearest.distance),
            provenance=posterior.noise_found,
        )
        return estimate, nearest.duals

    def prior_intervals(self, mass: float) -> dict[str, Array]:
        """Intervals from the shape, or the neighbourhood of the sensor, of a body of a
        mass [kg], as in `Estimate.intervals`; those of the mass have no width."""
        return prior_mixture(self._prior.undistorted, mass).intervals(INTERVAL_LEVEL)

    def prior_covariance(self, mass: float) -> Array:
        """Covariance (10, 10) by the shape, or the neighbourhood of the sensor, of a
        body of about a mass [kg], which itself is next to free."""
        return prior_mixture(self._prior.undistorted, mass, False).covariance

    def posterior(
        self, state: State, start: Estimate | Pass | None = None
    ) -> Posterior:
        """The posterior in the shape, which `estimate` summarises unless the samples
        contradict it; its mixture gives intervals of any level.

        Arguments and errors are those of `estimate`; `start` may also be the last pass
        to the posterior of fewer samples. Either most often leaves one pass to be done,
        an earlier estimate where the noise is given and the shape certain.
        """
        steps = self._passes(state)
        if isinstance(start, Pass):
            found = steps.continued(start)
            done = self._is_settled(start, found)
        else:
            found = steps.first(start)
            done = False
            if start is not None and self._com_change(found) < UNCHANGED_COM:
                again = steps.again(found)
                found, done = again or found, again is not None
        most = MOST_PASSES_UNCERTAIN_SHAPE if len(found.scores) else MOST_PASSES
        passes = 1
        while passes < most and not done:
            scores = found.scores
            if passes > 1:
                scores = 0.5 * (found.placed.scores + scores)
            passes, last = passes + 1, found
            found = steps.next(last, scores)
            done = self._is_settled(last, found)
        distortion_change = found.distortion_change
        found = steps.settled(found)
        if doubts := scale_doubts(found.wrench, steps.reading, self.carried):
            alone = replace(self, mass=None).posterior(state, start)
            return replace(alone, scale_doubts=doubts)
        settled = distortion_change < UNSETTLED_DISTORTION_CHANGE
        later = isinstance(start, Pass)
        return posterior_of(state, steps, found, self.shape, settled, passes, later)

    def _passes(self, state: State) -> Passes:
        require_samples(state.samples)
        free_bias = self.bias == "estimate"
        if not isinstance(state, WhitenedState):
            require_weight(states_of(state))
        source = NoiseSource.of(
            state,
            free_bias,
            self.noise,
            self.carried,
            SensorAccuracy.of(self.sensor_accuracy),
        )
        require_information(source.samples, state, free_bias)
        reading = MassReading.of(self.mass)
        return Passes(source, self._prior, self.systematic, reading)

    def _is_settled(self, last: Pass, found: Pass) -> bool:
        before, now = (
            each.noise.equations.covariance.diagonal() for each in (last, found)
        )
        return (
            float(np.abs(now / before - 1.0).max()) < NEGLIGIBLE_VARIANCE_CHANGE
            and found.distortion_change < NEGLIGIBLE_DISTORTION_CHANGE
            and self._com_change(found) < NEGLIGIBLE_COM_CHANGE
        )

    def _com_change(self, found: Pass) -> float:
        """Distance of the COM from that about which the prior is linear, over half the
        shape's diagonal."""
        off = found.center - found.com
        return float(off @ off) ** 0.5 / self._size
