"""Time samples: the samples of a record by time scale and by stretch, the colour of the
noise that they show, and whether the stretches agree."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from hefting.core.moments import triangular
from hefting.core.regressor import ONE
from hefting.core.spatial import Array, immutable, median
from hefting.estimators.bayes.colour import (
    LARGEST_STRETCH_DISAGREEMENT,
    Colour,
    exceeds,
    spectrum,
    without_expected,
)
from hefting.estimators.bayes.groups import Groups, Scores, combined
from hefting.estimators.bayes.likelihood import Equations
from hefting.estimators.bayes.sensor_errors import slow_variances
from hefting.estimators.joint_state import State, WhitenedState, states_by_bias
from hefting.estimators.sample_state import SampleState

FEWEST_COMPARED_STRETCHES = 4
"""Smallest number of stretches that are compared with each other."""
SMALLEST_STRETCH_VARIANCE = 0.01
"""Lower bound on the variance of a stretch's noise, relative to the variance that is
allowed for. The residuals of noise-free samples are rounding errors, which differ
between stretches."""


@immutable
class TimeSamples:
    """Virtual samples by time scale and stretch, less their mean if a bias is free."""

    scales: Groups
    stretches: Groups
    samples: float
    """length of the record; of the longest one of several recordings"""
    free_bias: bool
    """whether a constant bias is free"""

    @classmethod
    def of(cls, state: State, free_bias: bool) -> "TimeSamples | None":
        """From a state; None without a time record, or for a single sample. No time
        scale or stretch spans two recordings."""
        if isinstance(state, WhitenedState):
            return None
        states = states_by_bias(state, free_bias)
        known = [_Grouped.of(each, free_bias) for each in states]
        groups = [each for each in known if each is not None]
        if len(groups) < len(known):
            return None
        scales = [each.scales for each in groups]
        levels = max(len(factors) for factors, _ in scales)
        counts = [
            sum(own[j] for _, own in scales if j < len(own)) for j in range(levels)
        ]
        if not any(counts):
            return None
        factors = scales[0][0]
        if len(scales) > 1:
            factors = [
                triangular(
                    np.concatenate([own[j] for own, _ in scales if j < len(own)])
                )
                for j in range(levels)
            ]
        stretches = [part for each in groups for part in each.stretches]
        return cls(
            Groups.of(factors, counts, None),
            Groups.of([part[0] for part in stretches], [n for _, n in stretches], None),
            float(max(each.samples for each in states)),
            free_bias,
        )

    @cached_property
    def slow(self) -> Array:
        """(J + 1,) variances at each time scale and beyond of slow errors, whose
        variance at an instant is 1."""
        return slow_variances(
            1.0, 1.0, self.samples, len(self.scales.counts), self.free_bias
        )

    def colour(
        self,
        found: Scores,
        equations: Equations,
        level: float,
        white_claimed: bool,
        expected: Array | None = None,
    ) -> Colour:
        """Colour of the noise, from the scores `found` of the time scales.

        `equations` are those of all samples; with P, the inverse of their information,
        the fit takes tr(G_j P) degrees of freedom. The residuals' mean square is
        `level`: less than 1 where more is allowed for, such as lasting errors of the
        motion. Noise that is claimed to be white counts as white. Errors of another
        kind are expected to have the variances `expected` (J + 1,).
        """
        G, P = equations.G, equations.inverse
        taken = found.information.reshape(-1, 100) @ P.ravel()
        degrees = np.maximum(6.0 * self.scales.counts - np.maximum(taken, 0.0), 0.0)
        energies = found.energies / level
        if white_claimed:
            variances, white = np.ones(len(degrees) + 1), 1.0
            average, noise, exceeds_claim = 1.0, G, exceeds(energies, degrees)
        else:
            variances, white = spectrum(energies, degrees, self.samples, self.free_bias)
            every = float((P * G).sum())
            beyond = variances[-1] * (every - taken.sum())
            average = float(variances[:-1] @ taken + beyond) / max(every, 1e-300)
            if expected is not None:
                variances = without_expected(variances, expected, white, degrees)
            rest = G - found.information.sum(axis=0)
            noise = combined(variances[:-1], found.information) + variances[-1] * rest
            exceeds_claim = False
        return Colour(
            noise,
            max(average, 1.0),
            variances,
            white,
            energies,
            degrees,
            level,
            white_claimed,
            exceeds_claim,
        )

    def disagreement(
        self,
        W: Array,
        phi: Array,
        attenuation: Array | None,
        scales: Scores,
        colour: Colour,
        more: Array | None = None,
    ) -> tuple[float, float]:
        """Variance of mass and first moment between stretches over what each claims
        (Birge 1932): by its noise, and by its noise and `more` (g, 10, 10), another
        part of the scores' covariance.

        About 1 where all is as modelled; 0 where there are too few stretches. What
        stretches differ by must not excuse them: their noise is what the residuals tell
        without it, for a series as long as one of them. A difference in the body has
        energy at the time scales where the motion has.
        """
        n = len(self.stretches.counts)
        # a claim that does not hold is no measure
        if n < FEWEST_COMPARED_STRETCHES or colour.exceeds_claim:
            return 0.0, 0.0
        found = self.stretches.scores(W, phi, attenuation)
        white = float(found.birge(np.ones(n)).sum()) / (n - 1)
        if colour.white_claimed and white < LARGEST_STRETCH_DISAGREEMENT:
            return white, white
        signal = scales.information @ phi @ phi
        own = signal / (float(signal.sum()) or 1.0)
        gain, parameters = found.gain(), 10.0
        if self.free_bias:
            gain = (
                gain
                + float(colour.energies.sum()) * colour.level
                - float(found.energies.sum())
            )
            parameters = 16.0
        energies = np.maximum(
            colour.energies - own * max(gain, 0.0) / colour.level, 0.0
        )
        degrees = np.maximum(colour.degrees - own * parameters * n, 0.0)
        length = median(self.stretches.counts) + 1.0
        expected = spectrum(energies, degrees, length, self.free_bias)[0]
        variance = colour.level * float(
            expected[min(int(np.log2(length)), len(expected) - 1)]
        )
        variance = max(
            variance, 1.0 if colour.white_claimed else SMALLEST_STRETCH_VARIANCE
        )
        ratios = [
            float(found.birge(np.full(n, variance), part).sum()) / (n - 1)
            for part in (None, more)
        ]
        return ratios[0], ratios[1]


@immutable
class _Grouped:
    """Factors (22, 22) and numbers of samples of one recording's time scales and
    stretches, less their mean if a bias is free."""

    scales: tuple[Sequence[Array], Sequence[int]]
    stretches: list[tuple[Array, int]]

    @classmethod
    def of(cls, state: SampleState, free_bias: bool) -> "_Grouped | None":
        """From a state; None without a time record."""
        if state.record is None:
            return None
        scales, stretches = state.record.complete
        parts = stretches.parts
        if not free_bias:
            return cls((scales.factors, scales.counts), parts)
        # else what is left holds the mean, and counts like the longest sums
        scales = scales.closed()
        mean = _mean(state.full.factor)
        factors = [_without(mean, factor) for factor in scales.factors]
        own = [(_without(_mean(factor), factor), n - 1) for factor, n in parts]
        return cls((factors, scales.counts), own)


def _mean(factor: Array) -> Array:
    """(22,) weighted mean of the features, from their triangular factor (22, 22)."""
    ones = factor[:, ONE]
    return (ones @ factor) / max(float(ones @ ones), 1e-300)


def _without(mean: Array, factor: Array) -> Array:
    """Triangular factor (22, 22) of the features less their `mean` (22,)."""
    return factor - factor[:, ONE, None] * mean
