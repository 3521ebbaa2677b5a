"""Consequence: what a mistake does to the answer, and the message that says so."""

from collections.abc import Iterable
from typing import TypeVar

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array, immutable
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.elastic import Vibration
from hefting.ingest.rivals.evidence import unexplained_share
from hefting.ingest.rivals.explanation import Explanation
from hefting.ingest.rivals.judge import Judged
from hefting.ingest.rivals.timing import FILTERED
from hefting.ingest.rivals.two_mistakes import judge, judge_alone

Said = TypeVar("Said", bound=str)
LARGE_MASS_CHANGE = 0.03
"""Relative change of the mass from which on a mistake makes the answer wrong."""
LARGE_COM_CHANGE = 0.005
"""[m] Change of the COM from which on a mistake makes the answer wrong."""
GRAVE_MASS_CHANGE = 0.1
"""The same for a mistake that is possible, but not beyond doubt."""
GRAVE_COM_CHANGE = 0.010
"""[m] The same."""
LARGE_UNEXPLAINED = 0.3
"""Residual beyond noise over the wrench's changes from which on no answer is to be
used."""
NOTICED_UNEXPLAINED = 0.125
"""The same from which on the answer is in doubt. On recordings of three real sensors it
is at most 0.1."""
NOTICED_MULTIPLE = 8.0
"""Residual of the torque over what noise and a sensor's errors leave, from which on the
answer is in doubt too. On those recordings it is at most 5.4."""
CLEAR_OF_NOISE = 1.3
"""Factor on the noise with which both must still hold: averages of slightly coloured
noise have more of it than their differences show."""
STATIC_FACTOR = 2.0
"""Factor on both for static poses, whose noise counts as unexplained, as one sample per
second does not show it."""
FEW_UNKNOWNS = 6
"""Number of unknowns up to which a mistake does not imitate a change of the object."""
LITTLE_UNEXPLAINED = 0.01
"""Residual over the wrench's changes below which a mistake of many unknowns is named
only if it changes the answer, as it may imitate something else."""
NEGLIGIBLE_MASS_CHANGE = 1e-3
"""Relative change of the mass that is negligible."""
NEGLIGIBLE_COM_CHANGE = 0.5e-3
"""[m] The same of the COM."""
SUPERSEDED = frozenset(
    {
        "bias-undetermined",
        "bias-unknown",
        "clock-offset-contradictory",
        "clock-offset-unknown",
        "clock-several-offsets",
        "com-far-from-sensor",
        "com-outside-shape",
        "inertia-negative",
        "many-outliers",
        "mass-moved-by-shape",
        "mass-undetermined",
        "mass-unusual",
        "misfit",
        "not-identifiable",
        "not-physical",
        "nothing-held",
        "open-without-shape",
        "response-uneven",
        "shape-contradicts-wrench",
        "shape-hollow",
        "shape-too-small",
        "sign-uncertain",
        "stretches-disagree",
        "torque-sign-assumed",
        "unexplained",
    }
)
"""Codes of messages that a mistake which was named accounts for: what they advise would
not help."""


@immutable
class Doubt:
    """Messages on a recording that noise alone does not explain."""

    message: Message
    names_mistake: bool
    """whether it names a mistake, not only that much is unexplained"""
    is_whole: bool = False
    """whether the mistake accounts for the whole recording: it has few unknowns and
    makes the answer wrong, or is beyond doubt and leaves next to nothing unexplained"""
    second: Message | None = None
    """message on a second mistake, made at once"""

    @property
    def messages(self) -> tuple[Message, ...]:
        """All messages."""
        return (self.message,) if self.second is None else (self.message, self.second)

    @property
    def is_fatal(self) -> bool:
        """Whether the answer is wrong."""
        return self.message.severity == "error"

    @property
    def makes_wrong(self) -> bool:
        """Whether it names a mistake that makes the answer wrong."""
        return self.names_mistake and self.is_fatal

    def without_consequences(self, said: Iterable[Said]) -> tuple[Said, ...]:
        """Messages without those that follow from a mistake which makes the answer
        wrong."""
        if not self.makes_wrong:
            return tuple(said)
        return tuple(m for m in said if getattr(m, "code", "") not in SUPERSEDED)

    @property
    def needs_no_change(self) -> bool:
        """Whether a mistake explains the whole recording, so that no change of the
        object need be searched for."""
        return self.names_mistake and self.is_whole


def doubt_of(
    case: Case | None, *, with_tool: bool = False, pairs: bool = True
) -> Doubt | None:
    """The mistake in a recording, or that much of it is unexplained; None for neither.
    With a tool, the object includes it. Two mistakes at once are searched for if
    `pairs`."""
    if case is None:
        return None
    judged = judge(case) if pairs else judge_alone(case)
    if judged.named is not None and not _is_negligible(judged, judged.named):
        held = "object and tool" if with_tool else "it"
        message, second = _named(case, judged, judged.named, held)
        fatal = message.severity == "error"
        simple = judged.named.unknowns <= FEW_UNKNOWNS
        whole = judged.whole or (fatal and simple)
        return Doubt(message, True, whole and not judged.named.is_change, second)
    share = judged.unexplained
    factor = 1.0 if case.path.moves else STATIC_FACTOR
    noticed = share / NOTICED_UNEXPLAINED
    noticed = max(noticed, _multiple(case, judged, case.floor))
    if noticed <= factor:
        return None
    vibration = Vibration.of(case) if case.path.moves else None
    if vibration is not None and vibration.beside(noticed) <= 1.0:
        what = (
            f"the wrench vibrates at {vibration.frequency:.2g} Hz, the force by "
            f"{vibration.force:.2g} N, as on a compliant arm: it counts as noise; move "
            "slower, or wait between moves, for narrower intervals"
        )
        return Doubt(warning("vibration", what), False)
    if judged.given is not None and case.path.moves:
        fitted = judged.given.fitted
        share = unexplained_share(case, fitted, case.level)
        clear = unexplained_share(case, fitted, CLEAR_OF_NOISE * case.level)
        noticed = clear / NOTICED_UNEXPLAINED
        if max(noticed, _multiple(case, judged, case.level)) <= 1.0:
            return None
    what = (
        f"{100.0 * share:.0f} % of the wrench's changes are neither noise nor what a "
        "body on this motion needs: is the object fixed and free, and are clocks, axes"
        f"{' and' if case.biased else ', the `bias` and'} units right?"
    )
    zeros = 100.0 * np.mean(case.recording["wrench"].values == 0.0)
    if zeros > 1.0:
        what += f" {zeros:.0f} % of the readings are 0: are small ones written so?"
    say = error if share > factor * LARGE_UNEXPLAINED else warning
    return Doubt(say("unexplained", what), False)


def _multiple(case: Case, judged: Judged, level: Array) -> float:
    """Residual torque over a level (2,) that noise explains, and the same over the
    multiple that is noticed."""
    # of a quantised wrench the noise is not known, nor of static poses
    if judged.given is None or not case.noise[1] > 1e-3 * case.floor[1]:
        return 0.0
    fitted = judged.given.fitted
    return float(fitted.scale[fitted.best, 1] / level[1] / NOTICED_MULTIPLE)


def _is_negligible(judged: Judged, named: Explanation) -> bool:
    """Whether a mistake of many unknowns explains next to nothing and changes
    nothing."""
    assert judged.given is not None
    mass, com = _changes(judged.given.vector, named.vector)
    return (
        named.unknowns > FEW_UNKNOWNS
        and judged.unexplained < LITTLE_UNEXPLAINED
        and mass < NEGLIGIBLE_MASS_CHANGE
        and com < NEGLIGIBLE_COM_CHANGE
    )


def _named(
    case: Case, judged: Judged, named: Explanation, held: str
) -> tuple[Message, Message | None]:
    """Message on the mistake and a second one, with the mass and COM that what is `held`
    has without them, in sensor axes, where these differ much."""
    assert judged.given is not None
    before, after = judged.given.vector, named.vector
    mass, com = _changes(before, after)
    if named.code == FILTERED and case.parameters is not None:
        # the search's fit may be corrected for the filter where the answer is not
        mass, com = np.maximum((mass, com), _changes(case.parameters, after))
    large = mass > LARGE_MASS_CHANGE or com > LARGE_COM_CHANGE
    grave = mass > GRAVE_MASS_CHANGE or com > GRAVE_COM_CHANGE
    fatal = grave or ((large or named.is_grave) and judged.certain)
    # beside many unknowns the object's numbers are too uncertain to be said
    may_say = fatal and named.unknowns <= FEW_UNKNOWNS
    effects = []
    if may_say and mass > LARGE_MASS_CHANGE:
        effects.append(f"{abs(after[0]):.3g} kg")
    if may_say and LARGE_COM_CHANGE < com < np.inf:
        place = ", ".join(f"{x:.0f}" for x in 1e3 * after[1:4] / after[0] + 0.0)
        effects.append(f"its centre of mass at ({place}) mm")
    told = f" ({held} would have {' and '.join(effects)})" if effects else ""
    say = error if fatal else warning
    said, other = f"{named.what}: {named.fix}", judged.beside
    if other is None:
        return say(named.code, said + told, named.argument), None
    return (
        say(named.code, f"first of two mistakes at once: {said}", named.argument),
        say(
            other.code,
            f"second of two mistakes at once: {other.what}: {other.fix}{told}",
            other.argument,
        ),
    )


def _changes(before: Array, after: Array) -> tuple[float, float]:
    """Change of the mass, as a share of the larger one, and of the COM [m]."""
    first, second = (float(v[0]) for v in (before, after))
    largest = max(abs(first), abs(second), 1e-12)
    mass = abs(abs(first) - abs(second)) / largest
    small = 1e-3 * largest
    if min(abs(first), abs(second)) < small:
        return mass, np.inf
    return mass, float(np.linalg.norm(before[1:4] / first - after[1:4] / second))
