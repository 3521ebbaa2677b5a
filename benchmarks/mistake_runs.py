"""One identification with a mistake in it, and what was said of it."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.bodies import ends, sixteen
from benchmarks.given import Given, Mistake, correct
from benchmarks.tellable import is_tellable
from hefting.core.errors import HeftingError
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.spatial import Array

WRONG_MASS, WRONG_COM = 0.10, 0.010
"""Error of the mass, as a share of it, and of the COM [m], from which on an answer
should not be used."""
MATTERS_MASS, MATTERS_COM = 0.01, 0.002
"""Change of the answer by a mistake from which on it matters."""


@dataclass(frozen=True)
class Said:
    """What came of one identification."""

    mistake: str
    strength: str
    seed: int
    shape: bool
    verdict: str
    """level; of a refusal ``"do not use"``"""
    refused: bool
    """whether there was an error in place of an answer"""
    codes: frozenset[str]
    """codes of all messages, or of those whose text a refusal repeats"""
    named: bool
    """whether one of them names the mistake"""
    tellable: bool
    """whether the data could tell it"""
    matters: bool
    """whether the mistake changes the answer"""
    beyond: bool
    """whether mass, COM or inertia is further from its interval's middle than twice the
    interval's ends"""
    mass_error: float
    """over the true mass; infinite for a refusal"""
    com_error: float
    """[m]"""
    reasons: tuple[str, ...]
    """codes of the verdict's reasons"""

    @property
    def is_wrong(self) -> bool:
        """Whether the answer should not be used."""
        return not self.refused and (
            self.mass_error > WRONG_MASS or self.com_error > WRONG_COM
        )


def said_of(mistake: Mistake, seed: int, with_shape: bool) -> Said:
    """Identify a recording with a mistake in it."""
    rng = np.random.default_rng([16, seed])
    right = correct(seed, mistake.imu)
    given = mistake.make(right, rng)
    tellable = bool(mistake.codes) and is_tellable(mistake, right, seed)
    return identified(given, mistake, seed, with_shape, tellable)


def identified(
    given: Given, mistake: Mistake, seed: int, with_shape: bool, tellable: bool
) -> Said:
    """Identify what was given, and compare with the truth: with that of the bodies held
    at some time that the answer is nearest to."""
    from hefting.identification import identify

    shape = given.shape if with_shape else None
    key = (mistake.name, mistake.strength, seed, with_shape)
    try:
        estimate = identify(given.recording, shape, **given.options).estimate
    except HeftingError as error:
        found = frozenset(_codes_of_refusal(given, error))
        named = bool(found & mistake.codes)
        return Said(
            *key,
            "do not use",
            True,
            found,
            named,
            tellable,
            True,
            False,
            np.inf,
            np.inf,
            (),
        )
    assert estimate.intervals is not None
    notes = codes(estimate.provenance.get("notes", ()))
    found = codes(estimate.warnings) | notes
    p = estimate.parameters
    truth = min((given.truth, *given.others), key=lambda each: _distance(p, each))
    mass_error, com_error = _apart(p, truth)
    mass_change, com_change = _apart(
        p, _answer_to_correct(seed, mistake.imu, with_shape)
    )
    return Said(
        *key,
        estimate.verdict.level,
        False,
        frozenset(found),
        bool(found & mistake.codes),
        tellable,
        mass_change > MATTERS_MASS or com_change > MATTERS_COM,
        _beyond(estimate.intervals, sixteen(truth)[:10]),
        mass_error,
        com_error,
        tuple(reason.code for reason in estimate.verdict.reasons),
    )


@cache
def _answer_to_correct(seed: int, imu: bool, with_shape: bool) -> InertialParameters:
    """What is found from the recording without the mistake."""
    from hefting.identification import identify

    given = correct(seed, imu)
    shape = given.shape if with_shape else None
    return identify(given.recording, shape).estimate.parameters


def _apart(found: InertialParameters, other: InertialParameters) -> tuple[float, float]:
    """Difference of two masses, as a share of the other's, and of two COMs [m]."""
    com = np.linalg.norm(found.center_of_mass - other.center_of_mass)
    return abs(found.mass / other.mass - 1.0), float(com)


def _distance(found: InertialParameters, other: InertialParameters) -> float:
    mass, com = _apart(found, other)
    return mass / WRONG_MASS + com / WRONG_COM


def _beyond(intervals: dict[str, Array], truth: Array) -> bool:
    low, high = ends(intervals)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return bool((np.abs(truth - middle) > 2.0 * half + 1e-12).any())


def _codes_of_refusal(given: Given, error: HeftingError) -> set[str]:
    """What a refusal says: codes of the recording's messages whose text it repeats, and
    of units."""
    from hefting.ingest.ingest import ingest

    text = str(error)
    found = {"wrong-unit"} if "newton" in text else set[str]()
    try:
        said = ingest(given.recording, **given.options).warnings
    except HeftingError:
        return found
    return found | {message.code for message in said if str(message) in text}
