"""A predicted wrench as a readable report: peaks, extremes, assumptions, and agreement
with the measured wrench."""

from collections.abc import Iterable

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report.estimate import MORE
from hefting.cli.report.printing import bare_table, doubt_lines
from hefting.motion.measure import DESCRIPTIONS
from hefting.prediction import Agreement, Peak, Prediction

UNITS = {"f": "N", "t": "N m"}
TINY = 1e-9
"""Largest half-width of a band that is rounding [N, N m]."""
NOTICED = 1e-3
"""Share of the largest force or torque above which errors of the motion are printed."""


def prediction_report(found: Prediction, verbose: bool) -> Group:
    """Verdict and warnings, largest force and torque, lowest and highest value of each
    component with its band, agreement with the measured wrench; with `verbose` also
    assumptions."""
    count = f"{len(found)} instant{'' if len(found) == 1 else 's'}"
    lasts = (
        f"{len(found)} static poses"
        if found.static
        else f"{found.time[-1] - found.time[0]:.4g} s, {count}"
    )
    lines: list[RenderableType] = [
        *doubt_lines(found.verdict, found.warnings),
        Text(f"{found.method}: wrench in sensor axes, {lasts} of {found.trajectory}"),
        _table(found),
    ]
    if verbose:
        lines += _assumed(found)
    if found.agreement is not None:
        lines += _agreement(found.agreement, verbose)
    if not verbose:
        return Group(*lines, Text(MORE))
    return Group(*lines, *(Text(f"- {line}") for line in found.notes))


def _table(found: Prediction) -> Table:
    """Peaks, then the lowest and highest value of each component, with band and time."""
    table = bare_table()
    table.add_column("", no_wrap=True)
    band, when = found.std is not None, "in row" if found.static else "at s"
    for name in (
        "lowest",
        *(["± 95 %"] if band else []),
        when,
        "highest",
        *(["± 95 %"] if band else []),
        when,
        "unit",
    ):
        table.add_column(
            name, justify="left" if name == "unit" else "right", no_wrap=True
        )
    blanks = [""] * (3 if band else 2)
    for name, peak in found.peaks.items():
        row = [*blanks, *_cells(peak, found.static), UNITS[name[0]]]
        table.add_row(f"|{name}|", *row, end_section=name == "torque")
    for name, (lowest, highest) in found.extremes.items():
        table.add_row(
            name,
            *_cells(lowest, found.static),
            *_cells(highest, found.static),
            UNITS[name[0]],
        )
    return table


def _cells(peak: Peak, static: bool) -> list[str]:
    """A value, half its band if there is one, and its time or row."""
    reach = peak.reach
    band = []
    if reach is not None:
        band = ["open" if np.isinf(reach) else f"{reach:.2g}" if reach > TINY else "0"]
    digits = 2 if abs(peak.value) >= 10.0 else 4
    value = f"{round(peak.value, digits) + 0.0:.{digits}f}"  # no minus before a zero
    return [value, *band, f"{peak.time + 1:.0f}" if static else f"{peak.time:.3f}"]


def _assumed(found: Prediction) -> Iterable[Text]:
    g = ", ".join(f"{x:g}" for x in found.gravity)
    yield Text(
        f"assumed: gravity ({g}) m/s² in world axes; motion from {DESCRIPTIONS[found.source]}"
    )
    yield Text(
        "the sensor exerts it on what it holds, about the sensor's origin; an on-sensor log has minus this"
    )
    if found.std is not None:
        yield Text(
            "95 %: that wrench itself, by the estimate's covariance; not a sensor's noise and bias"
        )
    peaks = np.array([peak.value for peak in found.peaks.values()])
    if found.motion_std is not None and (found.motion_std > NOTICED * peaks).any():
        force, torque = found.motion_std
        yield Text(
            f"errors of the smoothed motion add at least {force:.1g} N, {torque:.1g} N m (rms an axis)"
        )


def _agreement(a: Agreement, verbose: bool) -> Iterable[Text]:
    side = "on-object" if a.sign.on_object else "on-sensor"
    yield Text(
        f"measured ({side}) minus predicted: {a.rms[0]:.3g} N, {a.rms[1]:.3g} N m root mean square"
    )
    yield Text(
        f"  less its mean, which may be another bias: {a.varying[0]:.3g} N, {a.varying[1]:.3g} N m"
    )
    if verbose and a.own is not None:
        yield Text(
            f"  least squares on this recording itself leaves {a.own[0]:.3g} N, {a.own[1]:.3g} N m"
        )
    if a.within is not None:
        force, torque = (f"{100.0 * share:.0f} %" for share in a.within)
        yield Text(
            f"  in the band, widened by this residual: {force} of forces, {torque} of torques; 95 % are expected"
        )
    if verbose:
        yield from (Text(f"  {line}") for line in a.notes)
