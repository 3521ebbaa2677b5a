"""Known: the determined part of an estimate as a body, comments on it, and numbers in the
form that controllers read.

Parameters that neither the recording nor a shape determines are not exported, unless the
caller gives a replacement.

All controllers take the COM from the flange's origin in flange axes. If one keeps single
precision (ABB, KUKA, Fanuc), the shortest decimal of that precision is written; exponents
are never used, as not every parser reads them.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from textwrap import wrap
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, ascii_of
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import EMPTY_RUNS, subtracted_tool
from hefting.core.messages import Message, warning
from hefting.core.spatial import Array
from hefting.export.body import Body, HalfWidths
from hefting.export.target import Target
from hefting.shapes import Shape

Fill = Shape | Literal["point"] | None
"""Replacement of an open inertia: that of a shape with uniform density, or the smallest
one that simulators accept."""

POINT_RADIUS = 1e-3
"""[m] Radius of gyration of a point: far below that of objects that robots hold, and with
moments far above those that simulators refuse (MuJoCo: 1e-15 kg m²)."""


def known_body(
    estimate: Estimate, name: str, fill: Fill, accept: bool, say: Callable[[str], str]
) -> Body:
    """Mass, COM and inertia of an estimate in its frame, with the lines of a comment;
    `say` turns names of arguments in backquotes into the reader's.

    An open inertia is left out, or filled in. Raises `InputError` for an open mass or COM
    without `accept`, and for parameters that no body can have.
    """
    open_ = estimate.undetermined
    if open_.position and not accept:
        raise InputError(
            f"the recording leaves {open_.position} open",
            fix="turn the sensor about two axes, or give a shape; or give `accept` to "
            "write what the method filled in",
        )
    make = Body.without_inertia if open_.inertia else Body.from_parameters
    body = make(estimate.parameters, name, estimate.frame)
    half = estimate.half_widths
    widths = HalfWidths(
        float(half["mass"]), half["center_of_mass"], half["inertia_at_com"]
    )
    body = replace(body, half_widths=widths, notes=notes_of(estimate, say))
    tool, without = subtracted_tool(estimate.provenance), ""
    if tool is not None:
        without = f"the tool of {tool[0]:.4g} kg that was subtracted"
    elif estimate.provenance.get("arm") == EMPTY_RUNS:
        without = "the gripper that the arm carried in the empty run"
    if without:
        line = f"the object alone, without {without}"
        body = replace(body, without=without, notes=(*body.notes, line))
    if open_.position:
        origin = f"{open_.position}: open, filled in from {open_.filled_from}"
        body = replace(body, notes=(*body.notes, plain(origin)))
    return _filled(body, fill) if body.is_point else body


def _filled(body: Body, fill: Fill) -> Body:
    """The body with its open inertia filled in or left out, and a note on that."""
    if fill is None:
        line = "inertia: open, the recording does not determine it; left out"
        return replace(body, notes=(*body.notes, line))
    inertia, how = _fill_inertia(body.mass, fill)
    line = f"inertia: open, the recording does not determine it; filled in as {how}"
    widths = replace(body.half_widths, inertia=np.full((3, 3), np.inf))
    body = replace(body, half_widths=widths, notes=(*body.notes, line))
    return body.with_inertia(inertia)


def _fill_inertia(mass: float, fill: Shape | Literal["point"]) -> tuple[Array, str]:
    """The filled in tensor (3, 3) [kg m²], and its description."""
    if isinstance(fill, Shape):
        how = "that of the given shape with the mass evenly spread"
        return mass * fill.homogeneous.inertia_at_com, how
    if fill != "point":
        raise InputError(f"cannot fill in '{fill}'", fix="give a shape, or 'point'")
    how = f"that of a point (radius of gyration {1e3 * POINT_RADIUS:g} mm)"
    return mass * POINT_RADIUS**2 * np.eye(3), how


def inertia_messages(
    estimate: Estimate, target: Target, body: Body, fill: Fill
) -> list[Message]:
    """Warnings about an open inertia; `InputError` if none but the target needs one."""
    if body.is_point and target.needs_inertia:
        open_ = estimate.undetermined.inertia
        what = (
            "the recording leaves the inertia open"
            if open_
            else "the estimate is a point mass"
        )
        raise InputError(
            f"{what}, and {target.name} needs an inertia",
            fix="identify it from a motion that rotates, or with a shape; "
            "`fill_inertia`=point or `fill_inertia`=shape writes one that is not measured",
        )
    if not (estimate.undetermined.inertia and target.takes_inertia):
        return []
    if body.is_point:
        what = "the recording leaves the inertia open: written without it, mass and COM only"
        return [warning("inertia-left-out", what, "fill_inertia")]
    how = "as of a point" if fill == "point" else "from the shape"
    what = f"the recording leaves the inertia open: filled in {how}, not measured"
    return [warning("inertia-filled", what, "fill_inertia")]


LONGEST = 400
"""Most characters of a message in a comment."""
MOST = 30
"""Most messages in a comment."""
GOOD = ("estimate: good",)
"""Notes of an estimate without doubts."""
WIDTH = 96
"""Characters of a line: controllers read at most some 240."""

OPTION = re.compile(r"(?<![\w-])--(?=[a-z])")
"""Dashes of an option of a command."""
TWO_DASHES = re.compile(r"-(?=-)")


def notes_of(estimate: Estimate, say: Callable[[str], str] = str) -> tuple[str, ...]:
    """Verdict, its reasons, and other warnings, a line each; `say` turns names of
    arguments in backquotes into the reader's."""
    verdict = estimate.verdict
    lines = [f"- {text}" for text in verdict.reasons]
    lines += [f"warning: {text}" for text in verdict.others(estimate.warnings)]
    return tuple(plain(say(text)) for text in (f"estimate: {verdict}", *lines[:MOST]))


def plain(text: str) -> str:
    """One line of printable ASCII."""
    ascii_ = ascii_of(text[:LONGEST].replace("`", ""))
    return " ".join("".join(c if c.isprintable() else " " for c in ascii_).split())


def wrapped(notes: tuple[str, ...]) -> list[str]:
    """The notes as lines of at most `WIDTH`; continuation lines are indented."""
    return [
        line
        for note in notes
        for line in wrap(plain(note), WIDTH, subsequent_indent="  ")
    ]


def xml_comment(notes: tuple[str, ...]) -> str:
    """An XML comment of one or several lines. It must not contain two dashes, so those of
    options are removed."""
    plain_ = [OPTION.sub("", note) for note in notes]
    lines = [TWO_DASHES.sub("- ", line).rstrip("-") for line in wrapped(tuple(plain_))]
    return "<!-- " + "\n     ".join(lines) + " -->"


def with_comment(element: str, notes: tuple[str, ...]) -> str:
    """An XML element with a comment as first child; unchanged if the notes are `GOOD`."""
    if notes == GOOD:
        return element
    comment = xml_comment(notes)
    end = element.index(">")
    if element[end - 1] == "/":
        tag = element[1:].split()[0]
        return f"{element[: end - 1]}>\n  {comment}\n</{tag}>"
    return f"{element[: end + 1]}\n  {comment}{element[end + 1 :]}"


DIGITS = 12
"""Significant digits of a double, few enough to hide rounding by a change of unit."""


def in_double(values: ArrayLike) -> list[str]:
    """Shortest decimals, without exponents, that read back as the same doubles to
    `DIGITS` digits."""
    return [
        np.format_float_positional(
            v + 0.0, precision=DIGITS, unique=True, fractional=False, trim="0"
        )
        for v in np.atleast_1d(values)
    ]


def in_single(values: ArrayLike) -> list[str]:
    """Shortest decimals, without exponents, that read back as the same single-precision
    numbers."""
    array = np.atleast_1d(values).astype(np.float32)
    return [
        np.format_float_positional(v + np.float32(0), unique=True, trim="0")
        for v in array
    ]


def named(values: list[str], names: str) -> str:
    """``"X 1.0, Y 2.0"`` of the values and the letters ``"XY"``."""
    return ", ".join(
        f"{name} {value}" for name, value in zip(names, values, strict=True)
    )


def comment(mark: str, body: Body, *lines: str) -> str:
    """Lines that start with a controller's comment mark: the frame, the part that the
    values describe, the notes on the estimate, and `lines`."""
    doubt = " - NOT flange axes, unless both are the same: the pose of the sensor in the flange was not given"
    return remarks(mark, body, *lines, doubt="" if body.frame == "flange" else doubt)


def remarks(mark: str, body: Body, *lines: str, doubt: str = "") -> str:
    """As `comment`, for a target not in flange axes; `doubt` follows the frame."""
    where = f"{body.frame} axes, from the {body.frame} origin{doubt}"
    what = "the object" if body.without else "what the sensor carries"
    what += "; the mass of the sensor itself and of an adapter is not in it"
    text = (where, what, *wrapped(body.notes), *lines)
    return "".join(f"{mark} {line}\n" for line in text)
