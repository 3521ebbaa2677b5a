"""Headline: verdict and numbers of an estimate, or the place of a shape, in few lines
above a picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.scene.surface import com_reach, reach
from hefting.shapes import Shape

MOST_DIGITS = 6
"""Most digits after the point."""
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Headline:
    """Verdict and numbers of an estimate."""

    verdict: str
    """Such as ``"verdict: good"``, and the meaning of ±."""
    reason: str
    """The gravest reason why it is not good, or empty. Arguments of the library are in
    backquotes, as in every message."""
    usable: bool
    """Whether the estimate may be used at all."""
    numbers: tuple[str, ...]
    """Mass, COM and inertia, a line each, ± the `reach` of their 95 % intervals."""


def headline_of(estimate: Estimate) -> Headline:
    """The headline of an estimate."""
    verdict = estimate.verdict
    return Headline(
        f"verdict: {verdict}   (±: 95 %)",
        str(verdict.reasons[0]) if verdict.reasons else "",
        verdict.usable,
        (_mass(estimate), _center(estimate), _inertia(estimate)),
    )


def plus_minus(value: float, half_width: float | None) -> str:
    """A value and the half-width of its interval, such as ``172.24 ± 0.83``, to the
    second significant digit of the half-width; ``open`` if this is infinite, the value
    alone without one."""
    if half_width is None or np.isnan(half_width):
        return f"{value:.4g}".replace("-", "−")
    if np.isinf(half_width):
        return "open"
    if half_width <= 0.0:
        return f"{value:.4g} ± 0".replace("-", "−")
    digits = min(max(0, 1 - int(np.floor(np.log10(half_width)))), MOST_DIGITS)
    shown = round(value, digits) + 0.0  # no minus before a zero
    return f"{shown:.{digits}f} ± {half_width:.{digits}f}".replace("-", "−")


def vector_text(values: ArrayLike, digits: int = 3) -> str:
    """Numbers in brackets, rounded to `digits` significant digits of the largest."""
    numbers = np.asarray(values, dtype=float)
    largest = float(np.abs(numbers).max()) or 1.0
    rounded = np.round(numbers, digits - 1 - int(np.floor(np.log10(largest)))) + 0.0
    return f"({', '.join(f'{x:g}' for x in rounded)})".replace("-", "−")


def power_of_thousand(values: Array) -> tuple[str, float]:
    """The power of a thousand that suits the largest value, as the prefix of a unit, such
    as ``"10⁻³ "``, and the factor from values to numbers in that unit."""
    largest = float(np.nan_to_num(np.abs(values)).max()) or 1.0
    power = 3 * int(np.floor(np.log10(largest) / 3.0))
    before = "" if power == 0 else f"10{str(power).translate(SUPERSCRIPTS)} "
    return before, 10.0**-power


def inertia_doubt(estimate: Estimate) -> float | None:
    """The `reach` of the widest 95 % interval of the moments at the COM over the largest
    moment; infinite if an entry of the tensor is open, None without intervals."""
    tensor = estimate.parameters.inertia_at_com
    half = reach(estimate, "inertia_at_com")
    if half is None:
        return None
    if np.isinf(half).any():
        return float("inf")
    if np.isnan(half).any():
        return None
    largest = float(tensor.diagonal().max())
    widest = float(half.diagonal().max())
    return widest / largest if largest > 0.0 else float("inf")


def _mass(estimate: Estimate) -> str:
    mass = estimate.parameters.mass
    half = reach(estimate, "mass")
    number = plus_minus(mass, None if half is None else float(half))
    return f"mass {number} kg" + (" (no intervals)" if half is None else "")


def _center(estimate: Estimate) -> str:
    center = 1e3 * estimate.parameters.center_of_mass
    half = com_reach(estimate)
    return f"COM {_each('xyz', center, None if half is None else 1e3 * half)} mm"


def _inertia(estimate: Estimate) -> str:
    """The moments at the COM, in a unit that suits them."""
    tensor = estimate.parameters.inertia_at_com
    half = reach(estimate, "inertia_at_com")
    moments = tensor.diagonal()
    if half is not None and np.isinf(half.diagonal()).all():
        return "inertia at the COM: open"
    unit, scale = power_of_thousand(moments)
    halves = None if half is None else scale * half.diagonal()
    numbers = _each(("Jxx", "Jyy", "Jzz"), scale * moments, halves)
    return f"at the COM [{unit}kg m²]: {numbers}"


def _each(names: tuple[str, ...] | str, values: Array, halves: Array | None) -> str:
    widths = [None] * len(values) if halves is None else halves
    return ", ".join(
        f"{name} {plus_minus(value, half)}"
        for name, value, half in zip(names, values, widths, strict=True)
    )


def place_of(shape: Shape) -> tuple[str, ...]:
    """Extent of a shape along the axes of the sensor, and its COM if its density is
    uniform; a line each."""
    low, high = 1e3 * shape.hull.min(axis=0), 1e3 * shape.hull.max(axis=0)
    reach = ", ".join(
        f"{axis} {_mm(a)} to {_mm(b)}"
        for axis, a, b in zip("xyz", low, high, strict=True)
    )
    center = 1e3 * shape.homogeneous.center_of_mass
    at = ", ".join(f"{axis} {_mm(c)}" for axis, c in zip("xyz", center, strict=True))
    return (f"reaches {reach} mm", f"COM of uniform density {at} mm")


def depth_of(shape: Shape, point: ArrayLike) -> float:
    """Depth [m] of a point (3,) [m] in the convex hull of a shape; negative outside."""
    return shape.margin(point) * (float(shape.extents.max()) or 1.0)


def _mm(value: float) -> str:
    return f"{np.round(value, 1) + 0.0:.1f}".replace("-", "−")
