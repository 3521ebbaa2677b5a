"""Results as tables a person can read, with units: a file each kind; and the verdict as the
first lines of a report."""

from collections.abc import Iterable

from hefting.core.messages import Verdict

STATUS_DO_NOT_USE = 3
"""Exit status of a command whose answer is not to be used."""


def verdict_lines(verdict: Verdict) -> list[str]:
    """The verdict, and its reasons, a line each."""
    return [
        f"verdict: {verdict}",
        *(f"- {reason}" for reason in verdict.reasons),
    ]


def other_warnings(warnings: Iterable[str], verdict: Verdict) -> list[str]:
    """Warnings that are no reason of the verdict."""
    return [line for line in warnings if line not in verdict.reasons]


def exit_status(verdict: Verdict) -> int:
    """0, or `STATUS_DO_NOT_USE`."""
    return 0 if verdict.usable else STATUS_DO_NOT_USE
