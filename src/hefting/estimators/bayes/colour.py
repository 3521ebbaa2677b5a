"""Colour: what residuals say of the noise beyond its size, and whether parts of a record agree.

`Colour.of` finds from a state's time record the spectrum of the noise by octaves (`spectrum`), and from it the
covariance of the whole record's score, sum v_j G_j over the time scales: with coloured noise, each scale's information
counts as much as the noise there allows. Two doubts widen it, as they are no reason to lean more on the prior:

- scales that contradict: a score beyond chance, as from errors of the motion, which fast changes suffer from more;
- stretches of the record that contradict each other by more than `DISAGREE`.
"""

from dataclasses import dataclass

import numpy as np

from hefting.estimators.bayes.groups import Groups, Scores
from hefting.estimators.bayes.spectrum import spectrum
from hefting.estimators.blend import Blend
from hefting.regressor import ONE
from hefting.spatial import Array

FEWEST = 50
"""Samples before the noise counts as known."""
STRETCHES = 4
"""Fewest stretches that are compared."""
DISAGREE = 3.0
"""Variance between stretches over what they claim that is more than chance."""
CHANCE = 5.0
"""Ratio of one scale's score that is chance: beyond it 4 degrees of freedom come once in 2,000 times."""


@dataclass(frozen=True, eq=False)
class Colour:
    """Noise of a record by time scale, at one body and one covariance of the wrench."""

    noise: Array
    """(10, 10) covariance of the score of all samples, coloured noise allowed for"""
    contradiction: Array
    """(10, 10) what is added to it where time scales contradict each other"""
    autocorrelation: float
    """variance of the parameters over that with white noise, on average"""
    variances: Array
    """(J + 1,) of the noise at each time scale and beyond, over that of one sample"""


@dataclass(frozen=True, eq=False)
class TimeSamples:
    """Virtual samples by time scale and by stretch, without their mean where a bias is free."""

    scales: Groups
    stretches: Groups
    samples: float
    """of the whole record"""
    free_bias: bool
    """whether a constant bias is free"""

    @classmethod
    def of(cls, state: Blend, free_bias: bool) -> "TimeSamples | None":
        """Of a state; None where it has no time record, or of one sample only."""
        if state.record is None:
            return None
        scales, stretches = state.record.complete
        kept = [j for j, count in enumerate(scales.counts) if count]
        if not kept:
            return None
        mean = own = None
        parts = stretches.parts
        if free_bias:
            mean = _means(state.full.factor[None])
            own = _means(np.array([factor for factor, _ in parts])) if parts else None
        return cls(
            Groups.of([scales.factors[j] for j in kept], [scales.counts[j] for j in kept], mean),
            Groups.of([factor for factor, _ in parts], [count - bool(free_bias) for _, count in parts], own),
            float(state.samples),
            free_bias,
        )

    def colour(self, found: Scores, G: Array, P: Array) -> Colour:
        """Of the noise that leaves what `found` says of the scales.

        `G` (10, 10) is the information of all samples; with P (10, 10) the fit takes tr(G_j P) degrees of freedom.
        """
        details = self.scales.counts
        spent = np.einsum("gij,ji->g", found.information, P)
        degrees = np.maximum(6.0 * details - np.maximum(spent, 0.0), 0.0)
        variances = spectrum(found.energies, degrees, self.samples)
        rest = G - found.information.sum(axis=0)
        noise = np.tensordot(variances[:-1], found.information, 1) + variances[-1] * rest
        doubt = found.birge(variances[:-1])
        share = np.maximum(1.0 - CHANCE / np.maximum(doubt, CHANCE), 0.0)
        beyond = np.sqrt(share)[:, None] * found.scores
        contradiction = beyond.T @ beyond
        size = G.diagonal()
        average = float(np.mean(noise.diagonal()[size > 0.0] / size[size > 0.0]))
        return Colour(noise, contradiction, max(average, 1.0), variances)

    def disagreement(self, W: Array, phi: Array, attenuation: Array | None, variances: Array) -> float:
        """Variance of mass and first moment between stretches over what each claims (Birge 1932).

        About 1 where all is as modelled; 0 where there are too few stretches. A stretch with a bias of its own has no
        details longer than half of it, so its noise is that of this scale, given the `variances` (J + 1,) of all.
        """
        n = len(self.stretches.counts)
        if n < STRETCHES:
            return 0.0
        own = np.full(n, len(variances) - 1)
        if self.free_bias:
            levels = np.log2(np.maximum(self.stretches.counts + 1.0, 2.0)).astype(int) - 1
            own = np.minimum(levels, own)
        found = self.stretches.scores(W, phi, attenuation)
        return float(found.birge(np.maximum(variances, 1.0)[own]).sum()) / (n - 1)


def _means(factors: Array) -> Array:
    """(g, 22) weighted mean features of triangular factors (g, 22, 22)."""
    ones = factors[:, :, ONE]
    return np.einsum("gi,gij->gj", ones, factors) / np.einsum("gi,gi->g", ones, ones)[:, None]
