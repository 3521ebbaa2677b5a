"""Summary: an estimate in a few lines, and results shown by a notebook."""

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes, verdict_of
from hefting.core.spatial import Array, Mask, tensor_to_vector
from hefting.core.undetermined import Undetermined

MOST_WARNINGS = 3
"""Largest number of warnings shown."""
LONGEST_FIRST, LONGEST_WARNING = 300, 150
"""Largest number of characters of the first warning shown, and of the others."""
MOST_DECIMALS = 9
"""Decimals of a number, at most."""
ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")
LOPSIDED = 3.0
"""Ratio of the longer to the shorter side of an interval above which its ends are
shown."""


class Shown:
    """Base of results with a notebook display beside their `repr`, by pictures that the
    results' own packages do not import."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        return import_module("hefting.notebook").html_of(self)


LABEL = 17
"""Width of the labels in `body_lines`."""


def body_lines(
    body: InertialParameters,
    intervals: Mapping[str, Array] | None,
    undetermined: Undetermined,
) -> list[str]:
    """Mass, COM and inertia, each with the half-width of its 95 % interval, or its ends
    if it is lopsided, as ``1.3 [1.3, 3.1]``. Numbers are rounded to two digits of that;
    ``open`` stands for undetermined numbers, and for intervals without an end."""
    ends = intervals or {}
    (mass,) = _shown(np.array([body.mass]), ends.get("mass"), 1.0, undetermined.mass)
    com = _shown(
        body.center_of_mass,
        ends.get("center_of_mass"),
        1e3,
        undetermined.center_of_mass,
    )
    inertia = _shown(
        body.inertia_at_com,
        ends.get("inertia_at_com"),
        1e3,
        undetermined.inertia_at_com,
    )
    tensor = [f"{name} {value}" for name, value in zip(ENTRIES, inertia, strict=True)]
    return [
        f"  mass           {mass} kg",
        f"  center of mass {', '.join(com)} mm",
        f"  inertia at COM {', '.join(tensor[:3])}",
        f"                 {', '.join(tensor[3:])} g m²",
    ]


def sign_told(made: Mapping[str, Any], warnings: Iterable[str]) -> str:
    """How the wrench's sign of an estimate is known, in words, by its provenance."""
    if not made.get("wrench_found"):
        return "as given"
    return "uncertain" if "sign-uncertain" in codes(warnings) else "found from gravity"


def samples_told(count: int) -> str:
    """``1 sample``, ``2 samples``."""
    return f"{count} sample{'' if count == 1 else 's'}"


def warning_lines(warnings: Sequence[str]) -> list[str]:
    """The gravest warnings, each cut to a line, and the number of the others."""
    verdict = verdict_of(warnings)
    ordered = [*verdict.reasons, *verdict.others(warnings)]
    lines = [f"  warning: {_cut(text, LONGEST_FIRST)}" for text in ordered[:1]]
    lines += [f"  warning: {_cut(text)}" for text in ordered[1:MOST_WARNINGS]]
    more = len(warnings) - MOST_WARNINGS
    return [*lines, f"  and {more} more in .warnings"] if more > 0 else lines


def _cut(text: str, longest: int = LONGEST_WARNING) -> str:
    return text if len(text) <= longest else f"{text[: longest - 4]} ..."


def _shown(
    values: Array, ends: Array | None, scale: float, undetermined: Mask | bool
) -> list[str]:
    """Numbers of a quantity, times `scale`, with their intervals; ``open`` for
    `undetermined` ones."""
    numbers = scale * _flat(values)
    low = high = numbers
    if ends is not None:
        low, high = (scale * _flat(end) for end in ends)
    open_ = _flat(np.array(undetermined, dtype=float)) > 0.0
    high = np.where(open_, np.inf, high)
    return [_with_interval(*each) for each in zip(numbers, low, high, strict=True)]


def _flat(values: Array) -> Array:
    values = np.atleast_1d(values)
    return tensor_to_vector(values) if values.ndim == 2 else values


def _with_interval(value: float, low: float, high: float) -> str:
    """A number with the distance to the farther end of its interval, or with both ends,
    to two digits of that."""
    shorter, longer = sorted((value - low, high - value))
    if not np.isfinite(longer):
        return "open"
    if not longer > 0.0:
        return f"{value:.6g}"
    decimals = 1 - int(f"{longer:.1e}".partition("e")[2])
    if decimals > MOST_DECIMALS:
        return f"{value:.3g} ± {longer:.2g}"
    decimals = max(decimals, 0)
    # no negative zero
    shown, least, most = (
        f"{round(each, decimals) + 0.0:.{decimals}f}" for each in (value, low, high)
    )
    if longer > LOPSIDED * shorter:
        return f"{shown} [{least}, {most}]"
    return f"{shown} ± {longer:.{decimals}f}"
