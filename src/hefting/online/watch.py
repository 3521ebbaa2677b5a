"""Watch: whether samples are still of the same object, by how far they deviate from
what is expected."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from hefting.core.measurements import Measurements
from hefting.online.expected import LENGTHS, Expected

LARGEST = 40.0
"""Size of a deviation above which the samples are not of the same object: chi-square
with four degrees of freedom exceeds it with a probability of 4e-8."""
PERSISTS = 0.7
"""[s] A deviation that lasts so long, and is that of a body, is another object."""
LATEST = 0.4
"""[s] Latest samples, which tell whether a touch is over."""
STILL = 20.0
"""Size of their deviation above which it is not."""
LARGEST_MISFIT = 2.5
"""Residual beside another body, over the noise, above which no body explains it."""
LONGEST = 6.0
"""[s] A deviation that lasts longer is no touch, whatever explains it."""


@dataclass(frozen=True)
class Watch:
    """Whether the object is still the same."""

    onset: float | None = None
    """[s] When a deviation was seen first; None while there is none."""
    changed: bool = False
    """Whether it is another object."""

    def looked(self, expected: Expected, z: Measurements) -> Self:
        """After a look at the latest samples (K,)."""
        deviation = expected.deviation(z)
        if deviation is None:
            return self
        now = float(z.time[-1])
        if deviation.size <= LARGEST:
            return replace(self, onset=None)
        onset = now if self.onset is None else self.onset
        lasted = now - onset
        changed = lasted >= PERSISTS and _is_body(expected, z, lasted)
        return replace(self, onset=onset, changed=changed or lasted >= LONGEST)

    @property
    def trusted_until(self) -> float | None:
        """[s] Samples up to here are of the object; None where all are."""
        return None if self.onset is None else self.onset - LENGTHS[-1]


def _is_body(expected: Expected, z: Measurements, lasted: float) -> bool:
    """Whether the latest samples deviate still, and another body explains all since the
    deviation began."""
    latest = expected.of_latest(z, LATEST)
    since = expected.of_latest(z, min(lasted, LENGTHS[-1]))
    return (
        latest is not None
        and since is not None
        and latest.size > STILL
        and since.misfit < LARGEST_MISFIT
    )
