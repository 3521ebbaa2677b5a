"""One identification with a mistake in it, and what was said of it."""

from dataclasses import dataclass

import numpy as np

from benchmarks.bodies import ends, sixteen
from benchmarks.given import Given, Mistake, correct
from hefting.core.errors import HeftingError
from hefting.core.messages import codes
from hefting.core.spatial import Array

WRONG_MASS, WRONG_COM = 0.10, 0.010
"""Error of the mass, as a share of it, and of the COM [m], from which on an answer
should not be used."""
MATTERS_MASS, MATTERS_COM = 0.01, 0.002
"""The same from which on a mistake matters at all."""


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
    named: bool
    """whether a message names the mistake"""
    tellable: bool
    """whether the data could tell it"""
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
    def matters(self) -> bool:
        """Whether the answer suffers from the mistake."""
        return self.mass_error > MATTERS_MASS or self.com_error > MATTERS_COM

    @property
    def is_wrong(self) -> bool:
        """Whether the answer should not be used."""
        return not self.refused and (
            self.mass_error > WRONG_MASS or self.com_error > WRONG_COM
        )


def said_of(mistake: Mistake, seed: int, with_shape: bool) -> Said:
    """Identify a recording with a mistake in it."""
    rng = np.random.default_rng([16, seed])
    given = mistake.make(correct(seed, mistake.imu), rng)
    return identified(given, mistake, seed, with_shape)


def identified(given: Given, mistake: Mistake, seed: int, with_shape: bool) -> Said:
    """Identify what was given, and compare with the truth."""
    from hefting.identification import identify

    shape = given.shape if with_shape else None
    key = (mistake.name, mistake.strength, seed, with_shape)
    try:
        estimate = identify(given.recording, shape, **given.options).estimate
    except HeftingError as error:
        named = bool(_codes_of_refusal(given, error) & mistake.codes)
        tellable = bool(mistake.codes)
        return Said(
            *key, "do not use", True, named, tellable, False, np.inf, np.inf, ()
        )
    assert estimate.intervals is not None
    notes = codes(estimate.provenance.get("notes", ()))
    found = codes(estimate.warnings) | notes
    p = estimate.parameters
    return Said(
        *key,
        estimate.verdict.level,
        False,
        bool(found & mistake.codes),
        bool(mistake.codes),
        _beyond(estimate.intervals, sixteen(given.truth)[:10]),
        abs(p.mass / given.truth.mass - 1.0),
        float(np.linalg.norm(p.center_of_mass - given.truth.center_of_mass)),
        tuple(reason.code for reason in estimate.verdict.reasons),
    )


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
