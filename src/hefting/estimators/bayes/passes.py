"""Passes: the posterior and the quantities that it depends on are found in turn: the
scale of the prior, the place of an uncertain shape, and the effect of the motion's
errors on the wrench."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.quantity import MassReading
from hefting.core.spatial import (
    Array,
    immutable,
    inverse_pose,
    pose_matrix,
    quaternion_of,
    rotation_by,
)
from hefting.estimators.bayes.distortion import affine
from hefting.estimators.bayes.likelihood import Likelihood, gain_by_scale, with_reading
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.nearest import Duals
from hefting.estimators.bayes.noise import NoiseSource
from hefting.estimators.bayes.noise_found import NoiseFound, inflation_of
from hefting.estimators.bayes.prior import Placed, Prior, prior_of
from hefting.shapes import Shape

SMALLEST_PRIOR_SCALE = 0.2
"""Lower bound of the prior's mass over the rough mass: it keeps light objects from
shrinking to zero."""
LARGEST_PRIOR_SCALE = 2.0
"""Upper bound of the prior's mass over the rough mass."""
UNCHANGED_SCALE = 0.005
"""Relative change of the prior's mass up to which the prior counts as unchanged."""
MUCH_LIKELIER = 8.0
"""Gain in log evidence (`Passes.likeliest_way`) above which another way to give the
shape is reported. It is less for 359 of 360 random bodies (`benchmarks.bodies`) with
the right shape, and with it 5 mm and 5° off."""
SIZES = (1.0 / 2.54, 2.54)
"""Factors of size of cm taken for in and of in for cm; a factor of ten shows in the
density."""
ANY_BODY = np.repeat((10.0, 2.0, 2.0), (1, 3, 6))
"""(10,) prior standard deviations of mass, first moment [m] and inertia [m²] of an
unknown body of about 1 kg."""


@immutable
class Pass:
    """The posterior of one pass, and the quantities it was found with."""

    placed: Placed
    """prior about the shape's distortion"""
    com: Array
    """(3,) [m] centre of mass about which the prior is linear"""
    scale: float
    """mass of the prior [kg]"""
    noise: NoiseFound
    wrench: Likelihood
    """of the samples alone, systematic errors included"""
    likelihood: Likelihood
    """of the samples and a scale's reading"""
    mixture: Mixture
    disagreement: float = 0.0
    """of stretches of the record by noise alone; 0 before it is computed"""
    inflation: float = 1.0
    """factor of the noise's variance for the disagreement that remains"""
    duals: Duals | None = None
    """start of the next search for the body nearest to an estimate"""
    systematic: Array | None = None
    """as in `Passes`"""

    @cached_property
    def measured(self) -> Array:
        """(10,) parameters by the samples, whose residuals are noise: the mean by the
        wrench alone, plus the expected error that all samples share."""
        wrench, mixture = self.wrench, self.mixture
        if self.likelihood is not wrench:  # a scale contradicts the sensor's gain
            mixture = Mixture.of(self.placed.prior, self.scale, wrench)
        phi = mixture.mean
        if self.systematic is None:
            return phi
        # an error of covariance C has the mean C (C + S)^-1 (y - phi)
        return phi + self.systematic @ (wrench.shift - wrench.precision @ phi)

    @property
    def distortion_change(self) -> float:
        """Largest change of the shape's distortion in the pass, in prior deviations."""
        return float(np.abs(self.scores - self.placed.scores).max(initial=0.0))

    @cached_property
    def tells_mass(self) -> bool:
        """Whether the mass exceeds its standard deviation; else the next pass keeps this
        one's prior and noise."""
        return bool(self.mixture.mean[0] > self.mixture.mass_std)

    @cached_property
    def center(self) -> Array:
        """(3,) [m] centre of mass, that of the prior if the mass is not told."""
        mean = self.mixture.mean
        return mean[1:4] / mean[0] if self.tells_mass else self.com

    @property
    def scores(self) -> Array:
        """(d,) of the most likely distortion by this posterior."""
        return self.placed.most_likely(self.mixture.weights, self.mixture.means)


@immutable
class Passes:
    """The steps of a pass for given samples and prior."""

    source: NoiseSource
    prior: Prior
    systematic: Array | None
    """(10, 10) covariance of the parameters' error that all samples share; None where
    there is none"""
    reading: MassReading | None = None
    """of a scale"""

    def first(self, start: Estimate | None) -> Pass:
        """The first pass; it starts from an earlier estimate if there is one."""
        phi, com = self.rough_mass * self.prior.mean, None
        if start is not None:
            phi = start.parameters.vector
            if phi[0] > 0.0:
                com = phi[1:4] / phi[0]
        placed = self.prior.about(np.zeros(len(self.prior.distortions.shifts)), com)
        com = self.prior.mean[1:4] if com is None else com
        noise = self.source.found(phi, None)
        return self._posterior(placed, com, self._scale(phi), noise, 1.0)

    def next(self, last: Pass, scores: Array) -> Pass:
        """The next pass, about the COM of `last` and the distortion `scores` (d,)."""
        noise = last.noise
        if last.tells_mass:
            noise = self.source.found(last.measured, noise)
        return self._after(last, scores, noise)

    def again(self, found: Pass) -> Pass | None:
        """The first pass in place of the second, if that would have the same prior and
        noise; else None."""
        change = self._scale(found.measured) / found.scale - 1.0
        if len(found.scores) or abs(change) > UNCHANGED_SCALE:
            return None
        noise = self.source.again(found.noise, found.measured)
        return None if noise is None else replace(found, noise=noise)

    def continued(self, last: Pass) -> Pass:
        """The first pass, from the last pass of fewer samples of the same object."""
        before = replace(last.noise, expected=None)  # of other time scales
        noise = self.source.found(last.measured, before)
        return self._after(last, last.scores, noise)

    def _after(self, last: Pass, scores: Array, noise: NoiseFound) -> Pass:
        """A pass about the COM of `last`, with its prior's mass if that tells none."""
        placed = self.prior.about(scores, last.center)
        scale = self._scale(last.measured) if last.tells_mass else last.scale
        return self._posterior(placed, last.center, scale, noise, 1.0)

    def settled(self, last: Pass) -> Pass:
        """The last pass, with larger noise if stretches of the record disagree by more
        than all errors allow."""
        noise = self.source.judged(last.noise)
        disagreement, unexplained = self.source.disagreement(noise)
        inflation = inflation_of(unexplained)
        if inflation > 1.0:
            last = self._posterior(last.placed, last.com, last.scale, noise, inflation)
        return replace(
            last, noise=noise, disagreement=disagreement, inflation=inflation
        )

    def of_more(self, last: Pass) -> Pass:
        """The last pass for some more samples, with its prior and noise, settled."""
        noise = last.noise.of_more(
            self.source.samples, last.measured, self.source.motion
        )
        found = self._posterior(
            last.placed, last.com, last.scale, noise, last.inflation
        )
        return replace(found, disagreement=last.disagreement, inflation=last.inflation)

    def without_shape(self, last: Pass) -> Pass:
        """The last pass for a body of any kind, where the samples contradict the shape.
        What they leave open is wide."""
        prior = replace(
            last.placed.prior,
            mean=np.zeros(10),
            spread=np.diag(ANY_BODY)[None],
            log_weight=np.zeros(1),
            offsets=None,
        )
        mixture = Mixture.of(prior, last.scale, last.likelihood)
        return replace(last, mixture=mixture)

    def evidence(self, last: Pass) -> float:
        """Log of the ratio of the samples' probability with this shape to that of an
        unknown object near the sensor."""
        return -self._gain(last, prior_of(Shape.unknown(), None, None))

    def likeliest_way(self, last: Pass, pose: Array) -> tuple[str, float]:
        """The way to give a shape of this `pose` (`ways`) that makes the samples
        `MUCH_LIKELIER`, and its gain in log evidence; none for an uncertain shape."""
        if len(self.prior.distortions.shifts):
            return "", 0.0
        found: dict[str, float] = {}
        for name, there in ways(pose).items():
            M = affine(there[:3, :3], there[:3, 3])
            mean, spread = M @ self.prior.mean, M @ self.prior.spread
            moved = replace(self.prior, mean=mean, spread=spread)
            found[name] = self._gain(last, moved)
        best = max(found, key=lambda name: found[name])
        return (best, found[best]) if found[best] > MUCH_LIKELIER else ("", 0.0)

    def _gain(self, last: Pass, prior: Prior) -> float:
        """Gain in log evidence by another prior."""
        placed = prior.about(np.zeros(0), last.center)
        other = Mixture.of(placed.prior, last.scale, last.likelihood)
        return other.evidence - last.mixture.evidence

    def sensor_gain(self, last: Pass) -> float | None:
        """Relative error of the sensor's gain by a scale, limited by its accuracy; None
        without a reading."""
        if self.reading is None:
            return None
        body = last.mixture.mean
        carried = self.source.carried[0] / body[0] if body[0] > 0.0 else 0.0
        limit = self.source.allowed.share * (1.0 + max(float(carried), 0.0))
        return gain_by_scale(last.noise.equations, body, limit)

    @cached_property
    def rough_mass(self) -> float:
        """[kg] of the object, by the scale or else by the size of the wrench."""
        if self.reading is not None:
            return self.reading.mass
        level = self.source.level()
        return self.source.samples.mass_scale(
            max(float(level[:3, :3].trace() / 3.0), 0.0) ** 0.5
        )

    def _scale(self, phi: Array) -> float:
        """Mass [kg] of the prior for parameters near phi (10,)."""
        rough = self.rough_mass
        return min(
            max(float(phi[0]), SMALLEST_PRIOR_SCALE * rough),
            LARGEST_PRIOR_SCALE * rough,
        )

    def _posterior(
        self,
        placed: Placed,
        com: Array,
        scale: float,
        noise: NoiseFound,
        inflation: float,
    ) -> Pass:
        wrench = noise.likelihood(inflation)
        if self.systematic is not None:
            wrench = wrench.blurred(self.systematic)
        likelihood = with_reading(wrench, self.reading)
        mixture = Mixture.of(placed.prior, scale, likelihood)
        return Pass(
            placed,
            com,
            scale,
            noise,
            wrench,
            likelihood,
            mixture,
            systematic=self.systematic,
        )


def ways(pose: Array) -> dict[str, Array]:
    """Other ways in which a shape of this pose (4, 4) may be meant: in words, and as
    the map (4, 4) of its points."""
    back = inverse_pose(pose)
    x, y, z, w = quaternion_of(pose[:3, :3])
    found: dict[str, Array] = {
        "by the inverse of its pose": back @ back,
        "with w first in its pose": pose_matrix((*pose[:3, 3], y, z, w, x)) @ back,
    }
    for size in SIZES:
        scaled = pose @ np.diag((size, size, size, 1.0)) @ back
        found[f"{size:.3g} times as large (`unit`)"] = scaled
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        for degrees in (90, 180, -90):
            turn = np.eye(4)
            turn[:3, :3] = rotation_by(np.radians(degrees) * axis)
            found[f"turned by {degrees}° about its own {name}"] = pose @ turn @ back
            if name == "z":
                found[f"turned by {degrees}° about the sensor's z"] = turn
    return found
