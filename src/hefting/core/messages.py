"""Messages: what was found, and what gives doubt, as sentences that programs can tell
apart.

A `Message` is its text, and carries a code that never changes with the wording. Where
it speaks of an argument of the library the text names it in backquotes, as in "check
`gravity`"; the command line shows its option in that place
(`--gravity`). Nothing in the project compares sentences: it compares codes.
"""

from collections.abc import Iterable
from typing import Any, Literal, Self

from hefting.core.errors import printable

Severity = Literal["note", "warning", "error"]


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
        """The message as one about some of several recordings, by their names."""
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
    """A message of what was found and done."""
    return Message(code, text, "note", argument)


def warning(code: str, text: str, argument: str | None = None) -> Message:
    """A message that gives doubt."""
    return Message(code, text, "warning", argument)


def error(code: str, text: str, argument: str | None = None) -> Message:
    """A message of what makes the answer wrong."""
    return Message(code, text, "error", argument)


def codes(messages: Iterable[str]) -> set[str]:
    """Codes of those that have one."""
    return {message.code for message in messages if isinstance(message, Message)}
