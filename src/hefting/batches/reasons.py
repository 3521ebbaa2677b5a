"""Reasons: what failed, counted by what is said of it, with a few examples of each."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

MOST_EXAMPLES = 5
"""Recordings that are named for a reason."""
MOST_REASONS = 500
"""Reasons that are told apart; what comes after them counts as one, so that memory is
bounded where each text differs."""
OTHER = "other reasons: see the table"


@dataclass
class Reason:
    """Why some failed."""

    error: str
    """Class of the error."""
    text: str
    """What it says, without what differs between recordings."""
    count: int = 0
    examples: list[str] = field(default_factory=list)
    """Some of what failed so, by what identifies it."""
    paths: list[str | None] = field(default_factory=list)
    """Of each example the path, unless it stands for several recordings."""


class Reasons:
    """Failures, counted."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], Reason] = {}

    def add(
        self,
        failure: Mapping[str, str],
        name: str,
        path: str | None,
        of: str | None = None,
    ) -> None:
        """Count a failure among those that say the same of other recordings.

        Parameters
        ----------
        failure : `error`, its class, and `error_text`, what it says.
        name, path : of what failed.
        of : path that the text speaks of, where that is another.
        """
        error, own = failure["error"], _without_path(failure["error_text"], path or of)
        general = re.sub(r"\d[\d.,:e+-]*", "#", own)
        key = error, general
        if key not in self._found and len(self._found) >= MOST_REASONS:
            key, own, general = ("", OTHER), OTHER, OTHER
        reason = self._found.setdefault(key, Reason(key[0], own))
        reason.count += 1
        if reason.count > 1 and reason.text != own:
            reason.text = general
        if len(reason.examples) < MOST_EXAMPLES:
            reason.examples.append(name)
            reason.paths.append(path)

    def sorted(self) -> tuple[Reason, ...]:
        """The reasons, the most frequent first."""
        return tuple(sorted(self._found.values(), key=lambda reason: -reason.count))


def _without_path(text: str, recording: str | None) -> str:
    """What is said, without the recording it is said of."""
    for path in filter(None, (recording, Path(recording or "").name)):
        text = text.replace(path, "...")
    return re.sub(r"^\.\.\.[^:]*: ", "", text)
