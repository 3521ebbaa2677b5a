"""Notes: what an exported text says of the estimate in its comments.

The sentences may come from a file of somebody else's. They are cut to plain ASCII lines
of bounded length, so that none can end a comment or add a line to a program.
"""

import re
from collections.abc import Callable
from textwrap import wrap

from hefting.core.estimate import Estimate
from hefting.core.plain_text import ascii_of

LONGEST = 400
"""Characters of a sentence that are repeated."""
MOST = 30
"""Sentences that are repeated."""
GOOD = ("estimate: good",)
"""What there is to say where nothing gives doubt."""
WIDTH = 96
"""Characters of a line: controllers read no longer ones than some 240."""

OPTION = re.compile(r"(?<![\w-])--(?=[a-z])")
"""What an option of a command begins with."""
TWO_DASHES = re.compile(r"-(?=-)")


def notes_of(estimate: Estimate, say: Callable[[str], str] = str) -> tuple[str, ...]:
    """Verdict, its reasons, and all other warnings, a line each; `say` turns names of
    arguments in backquotes into the reader's."""
    verdict = estimate.verdict
    others = [text for text in estimate.warnings if text not in verdict.reasons]
    said = [f"- {text}" for text in verdict.reasons]
    said += [f"warning: {text}" for text in others]
    return tuple(plain(say(text)) for text in (f"estimate: {verdict}", *said[:MOST]))


def plain(text: str) -> str:
    """One line of printable ASCII."""
    ascii_ = ascii_of(text[:LONGEST].replace("`", ""))
    return " ".join("".join(c if c.isprintable() else " " for c in ascii_).split())


def wrapped(notes: tuple[str, ...]) -> list[str]:
    """The notes as lines of bounded length; those that continue are indented."""
    return [
        line
        for note in notes
        for line in wrap(plain(note), WIDTH, subsequent_indent="  ")
    ]


def xml_comment(notes: tuple[str, ...]) -> str:
    """An XML comment, of one line or of several. It must not hold two dashes: options
    are without theirs."""
    plain_ = [OPTION.sub("", note) for note in notes]
    lines = [TWO_DASHES.sub("- ", line).rstrip("-") for line in wrapped(tuple(plain_))]
    return "<!-- " + "\n     ".join(lines) + " -->"


def with_comment(element: str, notes: tuple[str, ...]) -> str:
    """An XML element whose first child is a comment; as it is where there is nothing
    beyond a verdict that it is good."""
    if notes == GOOD:
        return element
    comment = xml_comment(notes)
    end = element.index(">")
    if element[end - 1] == "/":
        tag = element[1:].split()[0]
        return f"{element[: end - 1]}>\n  {comment}\n</{tag}>"
    return f"{element[: end + 1]}\n  {comment}{element[end + 1 :]}"
