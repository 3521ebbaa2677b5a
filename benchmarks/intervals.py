"""Intervals of the methods that find a point: an estimate from the moments with them,
and that it costs no more with more samples."""

from functools import partial

from benchmarks.estimators import labelled_parts
from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import Party, compare
from hefting.core.measurements import Measurements
from hefting.estimators import GEO, HPS, LMI, OLS, PMD, RTLS, Estimator
from hefting.estimators.sample_state import SampleState

LONGEST = 20e-3
"""[s] An estimate with intervals may take."""


def state_of(estimator: Estimator, z: Measurements) -> SampleState:
    """After the samples z."""
    return estimator.update(estimator.start(), z)


def with_intervals(samples: int, many: int, rounds: int) -> list[Section]:
    """Every method but Bayes, from the moments of so many samples, and of `many`."""
    long = wielded(many)
    estimators: list[Estimator] = [
        OLS(),
        RTLS(),
        LMI(),
        LMI(ellipsoid=shape(56)),
        GEO(shape(56)),
        PMD(shape(56)),
        HPS(labelled_parts()),
    ]
    sections: list[Section] = []
    for estimator in estimators:
        parties = {
            str(len(z)): Party(estimator.estimate, partial(state_of, estimator, z), 3)
            for z in (long[:samples], long)
        }
        few, all_of_them = compare(parties, rounds).values()
        ratio = all_of_them.median / few.median
        sections.append(
            Section(
                f"{estimator.name} with intervals, from the moments",
                (
                    Row(f"{samples:,} samples", few, few.median, "s", at_most=LONGEST),
                    # more time scales, and another number of stretches
                    Row(f"{many:,} samples, over that", figure=ratio, at_most=2.0),
                ),
            )
        )
    return sections
