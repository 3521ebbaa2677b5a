"""Messages: findings and doubts as sentences that programs can distinguish; and the
verdict on an estimate that follows from them.

A `Message` is its text, and carries a code that never changes with the wording. Where
it speaks of an argument of the library the text names it in backquotes, as in "check
`gravity`"; the command line shows its option in that place
(`--gravity`). Nothing in the project compares sentences: it compares codes.

Each message of an estimate looks at one thing that was measured, and carries a severity.
One of severity ``"error"`` makes the answer wrong. Warnings give doubt, but for those
that only say what is not determined or was assumed: intervals tell that already.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, Self

from hefting.core.errors import printable

Severity = Literal["note", "warning", "error"]
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
        "rows-conflicting",
        "no-time-column",
        "pose-constant",
        "poses-invalid",
        "poses-static",
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
        "torque-sign-assumed",
        "mass-deviation-assumed",
        # findings about the shape or a prediction
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


class Message(str):
    """One sentence with its code.

    Parameters
    ----------
    code : short name in lower case with hyphens, such as ``"clock-offset-unknown"``.
    text : one sentence in plain English; arguments of the library in backquotes.
    severity : ``"note"`` for what was found and done, ``"warning"`` for what gives
        doubt, ``"error"`` for what makes the answer wrong.
    argument : argument of the library with which the user can act on it, if there is
        one.
    recordings : names of the recordings it is about, where there are several and it is
        not about all of them; the text begins with them.

    Characters that control a terminal, as of a name in a file, are question marks in
    it.
    """

    __slots__ = ("argument", "code", "recordings", "severity")
    code: str
    severity: Severity
    argument: str | None
    recordings: tuple[str, ...]

    def __new__(
        cls,
        code: str,
        text: str,
        severity: Severity = "warning",
        argument: str | None = None,
        recordings: Iterable[str] = (),
    ) -> Self:
        """A message; see the class."""
        self = super().__new__(cls, printable(text))
        self.code, self.severity, self.argument = code, severity, argument
        self.recordings = tuple(recordings)
        return self

    def __getnewargs__(  # pyright: ignore[reportIncompatibleMethodOverride]
        self,
    ) -> tuple[str, str, Severity, str | None, tuple[str, ...]]:
        # for copies and worker processes
        return self.code, str(self), self.severity, self.argument, self.recordings

    def about(self, recordings: Iterable[str]) -> "Message":
        """The message with the names of the recordings that it is about, of several."""
        names = tuple(recordings)
        text = f"{', '.join(names)}: {self}"
        return Message(self.code, text, self.severity, self.argument, names)

    def to_dict(self) -> dict[str, Any]:
        """Code, severity, text and argument, JSON-ready; with the recordings it is
        about, if it is not about all."""
        own = {"recordings": list(self.recordings)} if self.recordings else {}
        return {
            "code": self.code,
            "severity": self.severity,
            "text": str(self),
            "argument": self.argument,
        } | own


def note(code: str, text: str, argument: str | None = None) -> Message:
    """A message on what was found and done."""
    return Message(code, text, "note", argument)


def warning(code: str, text: str, argument: str | None = None) -> Message:
    """A message that gives doubt."""
    return Message(code, text, "warning", argument)


def error(code: str, text: str, argument: str | None = None) -> Message:
    """A message on what makes the answer wrong."""
    return Message(code, text, "error", argument)


def codes(messages: Iterable[str]) -> set[str]:
    """Codes of the messages that have one."""
    return {message.code for message in messages if isinstance(message, Message)}


@dataclass(frozen=True)
class Verdict:
    """Whether to trust an estimate, and why not."""

    level: Level
    reasons: tuple[Message, ...] = ()
    """Why it is not good, the gravest reason first."""

    def __str__(self) -> str:
        return self.level

    @property
    def usable(self) -> bool:
        """Whether it may be used at all."""
        return self.level != "do not use"

    def others(self, messages: Iterable[str]) -> list[str]:
        """The messages that are none of its reasons."""
        return [each for each in messages if each not in self.reasons]


def verdict_of(messages: Iterable[str]) -> Verdict:
    """Verdict from an estimate's messages; those without a code give doubt."""
    coded = [m if isinstance(m, Message) else Message("unknown", m) for m in messages]
    errors = [m for m in coded if m.severity == "error"]
    doubts = [m for m in coded if m.severity == "warning" and m.code not in NO_DOUBT]
    reasons = (*errors, *doubts)
    if errors:
        return Verdict("do not use", reasons)
    return Verdict("usable with care" if doubts else "good", reasons)
