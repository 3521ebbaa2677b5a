"""What the controllers' files share: numbers as controllers read them, and the comment
above them.

All take the COM from the flange's origin in flange axes. Where a controller keeps
single precision (ABB, KUKA, Fanuc), the shortest decimal of that precision is written;
nowhere an exponent, which not every parser knows.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.export.body import Body
from hefting.export.known import wrapped

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
