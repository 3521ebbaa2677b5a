"""Verdict: whether to trust an estimate, and why not.

It follows from the messages that come with the estimate: each looks at one thing that
was measured, and carries a severity. One of severity ``"error"`` makes the answer wrong.
Warnings give doubt, but for those that only say what is not determined or was assumed:
intervals tell that already.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from hefting.core.messages import Message

Level = Literal["good", "usable with care", "do not use"]

NO_DOUBT = frozenset(
    {
        # what is not determined, or not known: it is in the intervals
        "no-shape",
        "not-identifiable",
        "open-without-shape",
        "clock-offset-unknown",
        "too-few-samples",
        "gravity-only",
        "gravity-measured",
        "accuracy-not-reached",
        # stretches or time scales that contradict one another: the intervals are wider by it
        "response-uneven",
        "stretches-disagree",
        # what a log or its reader left out, or a format assumes
        "columns-blank",
        "columns-by-name",
        "columns-ignored",
        "messages-not-finite",
        "messages-repeated",
        "messages-unordered",
        "messages-unreadable",
        "messages-unstamped",
        "no-time-column",
        "pose-constant",
        "poses-invalid",
        "rows-incomplete",
        "rows-repeated",
        "stream-left-out",
        "recording-left-out",
        "tf-stamps-uncovered",
        "time-shifted",
        "bag-truncated",
        "end-left-out",
        "gaps-in-poses",
        "torque-reference-assumed",
        "mass-deviation-assumed",
        # what was looked at in the shape, or is told of a prediction
        "mesh-holes",
        "thin-parts",
        "tool-without-spread",
        "no-band",
        "open-not-needed",
        "band-open",
        "tool-subtracted",
        "noise-coloured",
        "gyroscope-contradicts-poses",
        "accelerometer-contradicts-poses",
    }
)
"""Codes of warnings that do not put the estimate in doubt."""


@dataclass(frozen=True)
class Verdict:
    """Whether to trust an estimate."""

    level: Level
    reasons: tuple[Message, ...] = ()
    """Why it is not good, the gravest first."""

    def __str__(self) -> str:
        return self.level

    @property
    def usable(self) -> bool:
        """Whether it may be used at all."""
        return self.level != "do not use"


def verdict_of(messages: Iterable[str]) -> Verdict:
    """The verdict that follows from an estimate's messages; those without a code give
    doubt."""
    coded = [m if isinstance(m, Message) else Message("unknown", m) for m in messages]
    errors = [m for m in coded if m.severity == "error"]
    doubts = [m for m in coded if m.severity == "warning" and m.code not in NO_DOUBT]
    reasons = (*errors, *doubts)
    if errors:
        return Verdict("do not use", reasons)
    return Verdict("usable with care" if doubts else "good", reasons)
