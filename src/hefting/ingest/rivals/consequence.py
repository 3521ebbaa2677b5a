"""Consequence: what a mistake does to the answer, and how it is told."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array, interpolated
from hefting.ingest.blocks import Blocks
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, fit_as_given
from hefting.ingest.rivals.judge import Judged, judge, unexplained_share

LARGE_MASS_CHANGE = 0.03
"""Change of the mass, as a share of it, from which on a mistake makes the answer
wrong."""
LARGE_COM_CHANGE = 0.005
"""[m] Change of the COM from which on a mistake makes the answer wrong."""
GRAVE_MASS_CHANGE = 0.1
"""The same of a mistake that is possible, and not beyond doubt."""
GRAVE_COM_CHANGE = 0.010
"""[m] The same."""
LARGE_UNEXPLAINED = 0.3
"""Residual beyond noise over the wrench's changes from which on no answer is to be
used."""
NOTICED_UNEXPLAINED = 0.125
"""The same from which on the answer is in doubt. On recordings of three real sensors it
is at most 0.1."""
NOTICED_MULTIPLE = 8.0
"""Residual of torque, by which the COM is found, over what noise and a sensor's errors
leave from which on it is, too. On those recordings it is at most 5.4."""
CLEAR_OF_NOISE = 1.3
"""Factor on the noise that must be left behind, too: averages of little colour have so
much more of it than their differences tell."""
STATIC_FACTOR = 2.0
"""Both are so much larger for static poses, whose noise counts as unexplained: of one
per second nothing tells it."""
FEW_UNKNOWNS = 6
"""Unknowns up to which a mistake does not imitate a change of the object."""
LITTLE_UNEXPLAINED = 0.01
"""Residual over the wrench's changes below which a mistake of many unknowns is not named
unless it changes the answer: it imitates what is none of those that are looked for."""
NEGLIGIBLE_MASS_CHANGE = 1e-3
"""Change of the mass, as a share of it, that is no change of the answer."""
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
        "many-outliers",
        "mass-moved-by-shape",
        "mass-undetermined",
        "misfit",
        "not-identifiable",
        "not-physical",
        "open-without-shape",
        "response-uneven",
        "shape-contradicts-wrench",
        "sign-uncertain",
        "stretches-disagree",
        "unexplained",
    }
)
"""Codes of messages that a mistake which was named accounts for: what they advise would
not help."""


LOWEST_FREQUENCY = 3.0
"""[Hz] Below it arms with an object move, and liquids in it swing."""
BAND = 0.1
"""Half of the width of a vibration's band, as a share of its frequency."""
LEAST_SHARE = 0.5
"""Of the variance that is left, in that band: of white noise it is a fifth at most."""
WIDEST = 4.0
"""Largest over smallest frequency of a band that holds nine tenths of what is above the
motion's: of 5 to 15 Hz it is 3, of white noise above 10."""
MOST_BLOCKS = 6_000
"""Blocks of the wrench, the first ones, that are looked at: a minute."""
FEWEST_BLOCKS = 64
"""Fewest of them."""


@dataclass(frozen=True)
class Vibration:
    """The vibration in what a body leaves of the wrench."""

    frequency: float
    """[Hz]; the median of a band's"""
    force: float
    """[N] amplitude, over all axes"""
    share: float
    """of the variance that is left"""

    @classmethod
    def of(cls, case: Case) -> Self | None:
        """Of the recording as given, each channel about the line that fits it; None
        where there are too few samples, or most of what is left is elsewhere."""
        time, residual = _residual(case)
        if len(time) < FEWEST_BLOCKS:
            return None
        line = np.column_stack((np.ones_like(time), time - time.mean()))
        residual = residual - line @ np.linalg.lstsq(line, residual, rcond=None)[0]
        even = np.linspace(time[0], time[-1], len(time))
        values = interpolated(even, time, residual)
        frequency = np.fft.rfftfreq(len(even), float(even[1] - even[0]))
        window = np.hanning(len(even))
        power = np.square(np.abs(np.fft.rfft(values * window[:, None], axis=0)))
        power *= 2.0 / (len(even) * np.square(window).sum())
        scale = np.maximum(
            np.square(values).mean(axis=0).reshape(2, 3).sum(axis=1), 1e-300
        )
        weighted = (power.reshape(-1, 2, 3).sum(axis=2) / scale).sum(axis=1)
        fast = frequency > LOWEST_FREQUENCY
        if not fast.any() or not weighted[fast].any():
            return None
        peak = float(frequency[np.argmax(np.where(fast, weighted, 0.0))])
        near = np.abs(frequency - peak) < BAND * peak
        share = float(weighted[near].sum() / weighted.sum())
        if share < LEAST_SHARE:
            below = np.cumsum(weighted[fast])
            parts = np.array((0.05, 0.5, 0.95)) * below[-1]
            low, peak, high = np.interp(parts, below, frequency[fast])
            if high > WIDEST * low:
                return None
            near, share = fast, float(below[-1] / weighted.sum())
        return cls(float(peak), float(np.sqrt(2.0 * power[near, :3].sum())), share)


def _residual(case: Case) -> tuple[Array, Array]:
    """Times (B,) [s] and residuals (B, 6) of the blocks' wrench."""
    wrench = case.recording["wrench"]
    blocks = Blocks.of(wrench.time, wrench.values)
    time, values = blocks.time[:MOST_BLOCKS], blocks.wrench[:MOST_BLOCKS]
    fitted, offset = fit_as_given(case)
    motion = case.motion_at(time[None] - offset)
    known = motion.known[0]
    body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best][:10]
    left = values - motion.features(case.modelled_gravity)[0] @ body
    return time[known], left[known]


@dataclass(frozen=True, eq=False)
class Doubt:
    """What is to be said of a recording that noise alone does not explain."""

    message: Message
    names_mistake: bool
    """whether it names a mistake; else much is unexplained"""
    is_whole: bool = False
    """whether the mistake accounts for the whole recording: it has few unknowns and
    makes the answer wrong, or is beyond doubt and leaves next to nothing unexplained"""

    @property
    def is_fatal(self) -> bool:
        """Whether the answer is wrong."""
        return self.message.severity == "error"

    @property
    def needs_no_change(self) -> bool:
        """Whether a mistake explains the whole recording, so that no change of the
        object is to be looked for in it."""
        return self.names_mistake and self.is_whole


def doubt_of(case: Case, with_tool: bool = False) -> Doubt | None:
    """The mistake in a recording, or that much of it is unexplained; None where neither
    is. What is held includes a tool where one is known."""
    judged = judge(case)
    if judged.named is not None and not _is_negligible(judged, judged.named):
        message = _named(judged, judged.named, "object and tool" if with_tool else "it")
        fatal = message.severity == "error"
        simple = judged.named.unknowns <= FEW_UNKNOWNS
        whole = judged.whole or (fatal and simple)
        return Doubt(message, True, whole and not judged.named.is_change)
    share = judged.unexplained
    factor = 1.0 if case.path.moves else STATIC_FACTOR
    noticed = share / NOTICED_UNEXPLAINED
    noticed = max(noticed, _multiple(case, judged, case.floor))
    if noticed <= factor:
        return None
    vibration = Vibration.of(case) if case.path.moves else None
    if vibration is not None and noticed * (1.0 - vibration.share) ** 0.5 <= 1.0:
        return Doubt(_vibrates(vibration), False)
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
    """The torque that is left over a level (2,) that noise explains, and that over the
    multiple that is noticed."""
    # of a quantised wrench the noise is not known, nor of static poses
    if judged.given is None or not case.noise[1] > 1e-3 * case.floor[1]:
        return 0.0
    fitted = judged.given.fitted
    return float(fitted.scale[fitted.best, 1] / level[1] / NOTICED_MULTIPLE)


def _vibrates(vibration: Vibration) -> Message:
    what = (
        f"the wrench vibrates at {vibration.frequency:.2g} Hz, the force by "
        f"{vibration.force:.2g} N, as on a compliant arm: it counts as noise; move slower, "
        "or wait between moves, for narrower intervals"
    )
    return warning("vibration", what)


def _is_negligible(judged: Judged, named: Explanation) -> bool:
    """Whether a mistake of many unknowns explains next to nothing and changes nothing."""
    assert judged.given is not None
    mass, com = _changes(judged.given.vector, named.vector)
    return (
        named.unknowns > FEW_UNKNOWNS
        and judged.unexplained < LITTLE_UNEXPLAINED
        and mass < NEGLIGIBLE_MASS_CHANGE
        and com < NEGLIGIBLE_COM_CHANGE
    )


def _named(judged: Judged, named: Explanation, held: str) -> Message:
    """The mistake, and how far off the answer, about what is held, is with it."""
    assert judged.given is not None
    before, after = judged.given.vector, named.vector
    mass, com = _changes(before, after)
    said = f"{named.what}: {named.fix}"
    large = mass > LARGE_MASS_CHANGE or com > LARGE_COM_CHANGE
    grave = mass > GRAVE_MASS_CHANGE or com > GRAVE_COM_CHANGE
    if not (grave or ((large or named.is_grave) and judged.certain)):
        return warning(named.code, said, named.argument)
    effects = []
    if mass > LARGE_MASS_CHANGE:
        effects.append(f"{abs(after[0]):.3g} kg")
    if LARGE_COM_CHANGE < com < np.inf:
        effects.append(f"its centre of mass {1e3 * com:.0f} mm elsewhere")
    if effects:
        said += f" ({held} would have {' and '.join(effects)})"
    return error(named.code, said, named.argument)


def _changes(before: Array, after: Array) -> tuple[float, float]:
    """Change of the mass, as a share of the larger one, and of the COM [m]."""
    first, second = (float(v[0]) for v in (before, after))
    largest = max(abs(first), abs(second), 1e-12)
    mass = abs(abs(first) - abs(second)) / largest
    small = 1e-3 * largest
    if min(abs(first), abs(second)) < small:
        return mass, np.inf
    return mass, float(np.linalg.norm(before[1:4] / first - after[1:4] / second))
