"""Inspection: what a log holds, whether it can be used, and what to do next."""

from collections.abc import Iterable

import numpy as np

from hefting.core.sensor_accuracy import Z95
from hefting.inspection import Inspection
from hefting.page.answer import Say, verdict_box
from hefting.page.frame import Section
from hefting.page.html import element, items, join, table, terms


def inspected(found: Inspection, say: Say) -> Iterable[Section]:
    """The verdict with advice, and the streams of the log."""
    parts = [verdict_box(found.verdict, found.warnings, say)]
    if found.advice:
        lines = [say(line) for line in found.advice]
        parts += [element("h3", "What to do next"), items(lines)]
    parts.append(terms(_facts(found)))
    yield Section("answer", "Answer", join(parts))
    yield _streams(found)


def _facts(found: Inspection) -> Iterable[tuple[str, str]]:
    """What can be found from it, in short."""
    facts = found.facts
    if facts is None:
        return
    if facts.mass is not None and facts.mass_std is not None:
        yield (
            "Mass",
            f"{facts.mass:.4g} ± {Z95 * facts.mass_std:.2g} kg (least squares; ± by noise alone)",
        )
    if found.sign is not None:
        sure = "certain" if found.sign.certain else "not certain"
        yield "Sign", f"{found.sign.name}, {sure}"
    moved = found.movement
    if moved is not None:
        yield (
            "Turned",
            f"gravity turned by up to {np.degrees(moved.turn):.0f}° in sensor axes",
        )
        yield "Fastest", f"{moved.angular_speed[1]:.3g} rad/s"
    if found.undetermined:
        yield "Open", f"the motion leaves {', '.join(found.undetermined)} open"
    elif found.identifiability is not None:
        yield "Open", "nothing: the motion determines all ten parameters"


def _streams(found: Inspection) -> Section:
    """Samples, rates and gaps of each stream."""
    rows = []
    for name, facts in found.streams.items():
        gaps = (
            f"{facts.gaps}, longest {facts.longest_gap:.3g} s" if facts.gaps else "none"
        )
        rate = f"{facts.rate:.4g}" if facts.rate else "–"
        cells = [] if found.static else [rate, gaps]
        rows.append((name.replace("_", " "), f"{facts.samples:,}", *cells))
    head = ["stream", "samples"] + ([] if found.static else ["rate [Hz]", "gaps"])
    return Section("streams", "What the log holds", table(head, rows))
