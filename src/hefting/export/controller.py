"""What the controllers' files share: numbers as controllers read them, and the comment
above them.

All take the COM from the flange's origin in flange axes. Where a controller keeps
single precision (ABB, KUKA, Fanuc), the shortest decimal of that precision is written;
nowhere an exponent, which not every parser knows.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.export.body import Body


def in_double(values: Array | float) -> list[str]:
    """Shortest decimals, without exponents, that read back as the same doubles."""
    return [
        np.format_float_positional(v + 0.0, unique=True, trim="0")
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
    """Lines that start with a controller's comment mark: the frame, what is meant, and
    `lines`."""
    where = f"{body.frame} axes, from the {body.frame} origin"
    if body.frame != "flange":
        where += (
            " - NOT flange axes: the pose of the sensor in the flange was not given"
        )
    what = "what the sensor carries; the mass of the sensor itself and of an adapter is not in it"
    how = f"estimate: {body.verdict}"
    return "".join(f"{mark} {line}\n" for line in (where, what, how, *lines))
