"""Looking: how one gets from a row of a batch to its recording, by a link and by a
command."""

import json
import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hefting.page.html import Markup, element

MOST_RECORDINGS = 20
"""Recordings of an object that a command names at most."""


def link(name: str, recording: str | None) -> Markup:
    """A name that leads to the recording; the name alone where there is no file."""
    if recording is None:
        return element("span", name, class_="text")
    try:
        target = Path(recording).absolute().as_uri()
    except ValueError:
        return element("span", name, class_="text")
    return element("a", name, href=target, class_="text")


def look_at(row: Mapping[str, Any]) -> str | None:
    """The command that identifies what a row is of once more, and writes its report;
    None where it is of very many recordings.

    Parameters
    ----------
    row : columns `recording`, `name`, `object`, `recordings` and `options`.
    """
    alone = row["recording"]
    recordings = [alone] if alone is not None else row["recordings"] or ()
    if not 0 < len(recordings) <= MOST_RECORDINGS:
        return None
    name = row["name"] or (Path(alone).stem if alone is not None else row["object"])
    words = ["hefting", "identify", *map(_path, recordings)]
    words += _options(json.loads(row["options"] or "{}"))
    return shlex.join([*words, "--report", f"{_plain(name)}.html"])


def _options(options: Mapping[str, Any]) -> Sequence[str]:
    """Options as they are typed."""
    words: list[str] = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif value is not False:
            words.append(f"{option}={value}")
    return words


def _path(recording: str) -> str:
    """A path that is not taken for an option."""
    return f"./{recording}" if recording.startswith("-") else recording


def _plain(name: str) -> str:
    """A name for a file, whatever is in it."""
    return re.sub(r"[^\w.-]+", "-", name).strip("-.")[:80] or "report"
