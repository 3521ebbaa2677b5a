"""Known: what of an estimate may be told to a simulator or a controller, what comments
say of it, and numbers as controllers read them.

What neither the recording nor a shape determines is not exported, unless the caller
says what to put in its place.

All controllers take the COM from the flange's origin in flange axes. Where one keeps
single precision (ABB, KUKA, Fanuc), the shortest decimal of that precision is written;
nowhere an exponent, which not every parser knows.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from textwrap import wrap
from typing import Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import EMPTY_RUNS, subtracted_tool
from hefting.core.messages import Message, warning
from hefting.core.plain_text import ascii_of
from hefting.core.spatial import Array
from hefting.export.body import Body, HalfWidths
from hefting.export.target import Target
from hefting.shapes import Shape

Fill = Shape | Literal["point"] | None
"""What takes the place of an inertia that is open: that of the shape with its mass
evenly spread, or the smallest one that simulators take."""

POINT_RADIUS = 1e-3
"""[m] Radius of gyration of a point: far below that of anything a robot holds, and far
above what simulators refuse (MuJoCo: moments of 1e-15 kg m²)."""


def known_body(
    estimate: Estimate,
    name: str,
    fill: Fill,
    accept: bool,
    say: Callable[[str], str] = str,
) -> Body:
    """Mass, COM and inertia of an estimate in sensor axes, with what a comment says;
    `say` turns names of arguments in backquotes into the reader's.

    An inertia that is open is left out, or filled in. Raises `InputError` where the
    mass or the COM is open and it is not accepted, and for what no body can have.
    """
    open_ = estimate.undetermined
    if open_.position and not accept:
        raise InputError(
            f"the recording leaves {open_.position} open",
            fix="turn the sensor about two axes, or give a shape; or give `accept` to "
            "write what the method filled in",
        )
    make = Body.without_inertia if open_.inertia else Body.from_parameters
    body = make(estimate.parameters, name, "sensor")
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
        said = f"the object alone, without {without}"
        body = replace(body, without=without, notes=(*body.notes, said))
    if open_.position:
        origin = f"{open_.position}: open, filled in from {open_.filled_from}"
        body = replace(body, notes=(*body.notes, plain(origin)))
    return _filled(body, fill) if body.is_point else body


def _filled(body: Body, fill: Fill) -> Body:
    if fill is None:
        said = "inertia: open, the recording does not determine it; left out"
        return replace(body, notes=(*body.notes, said))
    inertia, how = _inertia_of(body.mass, fill)
    said = f"inertia: open, the recording does not determine it; filled in as {how}"
    widths = replace(body.half_widths, inertia=np.full((3, 3), np.inf))
    body = replace(body, half_widths=widths, notes=(*body.notes, said))
    return body.with_inertia(inertia)


def _inertia_of(mass: float, fill: Shape | Literal["point"]) -> tuple[Array, str]:
    """The tensor (3, 3) [kg m²] that is filled in, and what it is."""
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
    """What to know of an inertia that is open. Raises `InputError` where the target
    needs one."""
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
        what = (
            "the recording leaves the inertia open: written without it, mass and "
            "COM only"
        )
        return [warning("inertia-left-out", what, "fill_inertia")]
    how = "as of a point" if fill == "point" else "from the shape"
    what = f"the recording leaves the inertia open: filled in {how}, not measured"
    return [warning("inertia-filled", what, "fill_inertia")]


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


DIGITS = 12
"""Significant digits of a double: more would show the rounding of a change of unit."""


def in_double(values: Array | float) -> list[str]:
    """Shortest decimals, without exponents, that read back as the same doubles to
    `DIGITS` digits."""
    return [
        np.format_float_positional(
            v + 0.0, precision=DIGITS, unique=True, fractional=False, trim="0"
        )
        for v in np.atleast_1d(values)
    ]


def in_single(values: Array | float) -> list[str]:
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
    """Lines that start with a controller's comment mark: the frame, what is meant, what
    is said of the estimate, and `lines`."""
    doubt = " - NOT flange axes, unless both are the same: the pose of the sensor in the flange was not given"
    return remarks(mark, body, *lines, doubt="" if body.frame == "flange" else doubt)


def remarks(mark: str, body: Body, *lines: str, doubt: str = "") -> str:
    """The same for a target that does not want flange axes; `doubt` stands behind the
    frame."""
    where = f"{body.frame} axes, from the {body.frame} origin{doubt}"
    what = "the object" if body.without else "what the sensor carries"
    what += "; the mass of the sensor itself and of an adapter is not in it"
    said = (where, what, *wrapped(body.notes), *lines)
    return "".join(f"{mark} {line}\n" for line in said)
