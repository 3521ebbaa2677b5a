"""What stands beside the scene, as HTML: the answer, and what the colours mean."""

from collections.abc import Callable
from html import escape

from hefting.viewer.colours import ARROWS, AXES, COM, INERTIA, MASSES, SURFACE, TRUTH
from hefting.viewer.drawing import axes_length
from hefting.viewer.session import Answer

MOST_REASONS = 3
"""Reasons for doubt that are shown."""
GOOD, CARE, BAD = "#16916B", "#C07500", "#D64937"
"""Of the verdict, read on white and on black."""
LEVELS = {"good": GOOD, "usable with care": CARE, "do not use": BAD}


def answer_html(
    answer: Answer, used: str, static: bool, say: Callable[[str], str] = str
) -> str:
    """Verdict, reasons for doubt, numbers with half their 95 % intervals, and what they
    rest on. All text is escaped.

    Parameters
    ----------
    answer : Answer
        What is known at the instant.
    used : str
        How much of the recording that is.
    static : bool
        Whether the recording consists of static poses.
    say : callable
        Turns names of arguments in backquotes into the reader's.
    """
    if answer.estimate is None:
        return block(bold("no answer yet", BAD) + line(say(answer.refusal)))
    headline, verdict = answer.headline, answer.estimate.verdict
    assert headline is not None
    lines = [bold(f"verdict: {verdict.level}", LEVELS[verdict.level])]
    lines += [small(say(str(reason))) for reason in verdict.reasons[:MOST_REASONS]]
    more = len(verdict.reasons) - MOST_REASONS
    lines += [small(f"and {more} more")] if more > 0 else []
    lines += [line(number) for number in headline.numbers]
    kind = "poses" if static else "samples"
    lines.append(
        small(
            f"± 95 %. {answer.estimate.method}, {used}, {answer.estimate.samples} {kind}"
        )
    )
    missing = {body.missing for body in answer.scene.bodies if body.missing}
    lines += [small(f"no ellipsoid: {why}") for why in sorted(missing)]
    return block("".join(lines))


def legend_html(answer: Answer, size: float, largest: tuple[float, float]) -> str:
    """What the colours mean, and how long things are. `size` is that of the scene [m],
    `largest` the largest force [N] and torque [N m]."""
    scene = answer.scene
    rows = [_mark(COM, "COM, with the region that holds it (95 %)")]
    rows.append(_mark(INERTIA, "uniform ellipsoid of equal inertia"))
    if any(body.name == "truth" for body in scene.bodies):
        rows.append(_mark(TRUTH, "truth: COM, uniform ellipsoid"))
    if scene.surface is not None:
        is_object = scene.surface.is_object
        rows.append(_mark(SURFACE, "shape" if is_object else "box around the object"))
    masses = None if scene.points is None else scene.points.masses
    if masses is not None:
        rows.append(_scale(1e3 * float(masses.max())))
    rows += [_mark(colour, name) for name, colour in ARROWS.items()]
    rows += [_mark(colour, f"{axis} of the sensor") for axis, colour in AXES.items()]
    force, torque = largest
    rows.append(
        small(
            f"axes: {1e3 * axes_length(size):g} mm long; longest arrows: "
            f"{force:.3g} N, {torque:.3g} N m; without bias"
        )
    )
    return block("".join(rows))


def block(inner: str) -> str:
    """What stands in the panel, with its margins."""
    return f'<div style="padding:0.4em 0.8em;font-size:13px;line-height:1.35">{inner}</div>'


def bold(text: str, colour: str) -> str:
    """A line in bold, of a colour; the text is escaped."""
    return f'<div style="font-weight:700;color:{colour}">{escape(text)}</div>'


def line(text: str) -> str:
    """A line; the text is escaped."""
    return f'<div style="overflow-wrap:anywhere">{escape(text)}</div>'


def small(text: str) -> str:
    """A line of small print; the text is escaped."""
    style = "font-size:85%;opacity:0.8;overflow-wrap:anywhere"
    return f'<div style="{style}">{escape(text)}</div>'


def _mark(colour: str, text: str) -> str:
    square = (
        "display:inline-block;width:0.8em;height:0.8em;margin-right:0.5em;"
        f"border-radius:2px;background:{colour}"
    )
    return (
        f'<div style="font-size:85%"><span style="{square}"></span>{escape(text)}</div>'
    )


def _scale(largest: float) -> str:
    """A bar of the colours of masses."""
    bar = (
        "display:inline-block;width:6em;height:0.8em;margin:0 0.5em;"
        f"border-radius:2px;background:linear-gradient(to right,{','.join(MASSES)})"
    )
    return (
        f'<div style="font-size:85%">mass of a point: 0<span style="{bar}"></span>'
        f"{largest:.3g} g</div>"
    )
