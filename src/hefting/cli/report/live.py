"""Output of hefting live while it runs: a line that changes in place on a terminal, lines
otherwise, or JSON."""

import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from shutil import get_terminal_size
from typing import TYPE_CHECKING

import numpy as np

from hefting.cli.parser import say
from hefting.cli.report import with_reach

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.online import LiveEstimate
    from hefting.sources.live import Pump

EVERY = 1.0
"""[s] Time between lines where they cannot change in place."""

BAR = " | "
"""Between the parts of a line."""
LEAST_OF_MESSAGE = 20
"""Characters of a message that are worth showing."""
UP_TO_COM = 4
"""Number of parts up to the COM: time and state, verdict, mass, COM."""

Render = Callable[[str], str]


class Display:
    """Shows messages only; the other displays derive from it."""

    def __init__(self, render: Render):
        self.render, self._last_reason = render, ""
        self._lock = threading.Lock()

    def show(self, found: "LiveEstimate", pump: "Pump") -> None:
        """Show an estimate."""

    def tell_mistake(self, found: "LiveEstimate") -> None:
        """Name the reason why the answer is not to be used, unless it was the last."""
        verdict = None if found.estimate is None else found.estimate.verdict
        if (
            verdict is None
            or verdict.usable
            or verdict.reasons[0].code == self._last_reason
        ):
            return
        self._last_reason = verdict.reasons[0].code
        self.say(f"{verdict}: {self.render(verdict.reasons[0])}")

    def say(self, text: str) -> None:
        """Print a message on standard error."""
        with self._lock:
            self.clear()
            say(text)

    def clear(self) -> None:
        """Make room for a message."""

    def end(self) -> None:
        """Make room for further output."""
        with self._lock:
            self.clear()


class JsonDisplay(Display):
    """One JSON object for each line."""

    def show(self, found: "LiveEstimate", pump: "Pump") -> None:
        """Print an estimate."""
        import json

        print(self.render(json.dumps(found.to_dict())), flush=True)


class LinesDisplay(Display):
    """A line where the state changes, and every second."""

    def __init__(self, render: Render):
        super().__init__(render)
        self._state, self._due = "", 0.0

    def show(self, found: "LiveEstimate", pump: "Pump") -> None:
        """Print an estimate whose state is new, or that is due."""
        self.tell_mistake(found)
        now = time.monotonic()
        if found.state != self._state or now >= self._due:
            self._state, self._due = found.state, now + EVERY
            print(line_of(found, pump, self.render), flush=True)


class TerminalDisplay(Display):
    """A line that changes in place."""

    def __init__(self, render: Render):
        super().__init__(render)
        self._is_shown = False

    def show(self, found: "LiveEstimate", pump: "Pump") -> None:
        """Replace the last estimate."""
        self.tell_mistake(found)
        columns = max(get_terminal_size().columns, 20) - 1
        text = fitting(*parts_of(found, pump, self.render), columns)
        with self._lock:
            sys.stdout.write(f"\r{text}\x1b[K")
            sys.stdout.flush()
            self._is_shown = True

    def clear(self) -> None:
        """Erase the line."""
        if self._is_shown:
            sys.stdout.write("\r\x1b[K")
            sys.stdout.flush()
            self._is_shown = False


def display_of(json: bool, render: Render) -> Display:
    """The display for standard output."""
    if json:
        return JsonDisplay(render)
    return (TerminalDisplay if sys.stdout.isatty() else LinesDisplay)(render)


def line_of(found: "LiveEstimate", pump: "Pump", render: Render) -> str:
    """An estimate in a line: time, verdict, mass, COM, samples, last message."""
    parts, message = parts_of(found, pump, render)
    return BAR.join([*parts, message] if message else parts)


def fitting(parts: list[str], message: str, columns: int) -> str:
    """The parts of a line and the last message, by what fits: of a message its begin, of
    the parts whole ones, as half a number misleads. The verdict goes before the COM does,
    unless it is one of an answer that is not to be used."""
    text = BAR.join([*parts, message] if message else parts)
    if len(text) > columns >= len(BAR.join([*parts, ""])) + LEAST_OF_MESSAGE:
        return f"{text[: columns - 4]} ..."
    left = list(parts)
    while len(BAR.join(left)) > columns and len(left) > 1:
        is_verdict = len(left) == UP_TO_COM and left[1] != "do not use"
        left.pop(1 if is_verdict else -1)
    text = BAR.join(left)
    return text if len(text) <= columns else f"{text[: columns - 4]} ..."


def parts_of(
    found: "LiveEstimate", pump: "Pump", render: Render
) -> tuple[list[str], str]:
    """The parts of `line_of`, and its message, which may be empty."""
    number = f" object {found.object}" if found.object > 1 else ""
    parts = [f"{found.time:.1f} s{number}: {found.state}"]
    if found.estimate is not None:
        parts += [str(found.estimate.verdict), *numbers_of(found.estimate)]
        parts.append(f"{found.estimate.samples} samples")
    else:
        parts.append(f"{pump.counts['samples']} samples of all streams")
    if skipped := +pump.source.skipped.copy():
        why, _ = skipped.most_common(1)[0]
        parts.append(f"{skipped.total()} skipped ({why})")
    last = found.messages[-1] if found.messages else None
    # a note, as on the source, is shown until there are numbers
    is_told = last is not None and (found.estimate is None or last.severity != "note")
    return parts, render(str(last)) if is_told else ""


def numbers_of(estimate: "Estimate") -> list[str]:
    """Mass and COM, each with the larger half of its 95 % interval."""
    ends = estimate.intervals or {}
    body = estimate.parameters
    mass = com = None
    if "mass" in ends:
        mass = float(np.abs(ends["mass"] - body.mass).max())
    if "center_of_mass" in ends:
        com = 1e3 * float(np.abs(ends["center_of_mass"] - body.center_of_mass).max())
    return [
        f"{with_reach([body.mass], mass)} kg",
        f"COM {with_reach(1e3 * body.center_of_mass, com)} mm",
    ]


def no_answer(found: "LiveEstimate | None", render: Render) -> str:
    """A line with the reasons why there is no final answer."""
    if found is None:
        return "no answer: no sample came in"
    why = [str(text) for text in found.messages] or [found.state]
    skipped: Counter[str] = +Counter(found.counts.get("skipped", {}))
    why += [f"{count} skipped ({reason})" for reason, count in skipped.most_common(1)]
    return f"no answer: {render('; '.join(why))}"
