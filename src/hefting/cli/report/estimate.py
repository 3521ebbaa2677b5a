"""An estimate as a readable table with units, in plain text without `rich`, as most runs
of the command print nothing else."""

import os
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from hefting.cli.parser import output_width, wrapped
from hefting.cli.report import Worth, aligned, verdict_lines
from hefting.core.errors import printable
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.quantity import significant, wrench_text
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, tensor_to_vector
from hefting.core.summary import samples_told, sign_told

if TYPE_CHECKING:
    from hefting.core.accuracy import Errors

AXES = "xyz"
MORE = "--verbose shows what was found, assumed and checked"
MENDED = {
    "bias-drift",
    "clock-offset",
    "contact",
    "gravity-direction",
    "pose-glitches",
    "poses-frozen",
    "poses-held-at-ends",
    "rows-lost",
    "wrench-blank",
    "wrench-stalled",
}
"""Codes of notes that are printed without --verbose: changes of the recording, and
findings besides the object."""
Style = Literal["", "bold", "yellow"]
STYLES: dict[Style, str] = {"": "", "bold": "\x1b[1m", "yellow": "\x1b[33m"}


@dataclass(frozen=True)
class Line:
    """One line of a report."""

    text: str
    style: Style = ""
    whole: bool = False
    """whether it is never wrapped, as a line of a table"""


def estimate_report(
    estimate: Estimate,
    truth: InertialParameters | None = None,
    errors: "Errors | None" = None,
    verbose: bool = False,
) -> list[Line]:
    """The answer on one screen: verdict, warnings, then mass, COM and inertia at the COM
    with intervals or standard deviations, and the truth if known; with `verbose` also
    what was found, assumed and checked."""
    verdict = estimate.verdict
    lines = [
        Line(text, "bold" if verdict.level == "good" else "yellow")
        for text in verdict_lines(verdict)
    ]
    lines += [
        Line(f"warning: {line}", "yellow") for line in verdict.others(estimate.warnings)
    ]
    holder, axes = "the sensor", "sensor axes"
    if "torque_gain_std" in estimate.provenance:
        holder, axes = (
            "the arm",
            f"axes of {estimate.provenance.get('sensor_frame', '--sensor-frame')}",
        )
    lines.append(Line(f"{estimate.method}: what {holder} holds, in {axes}"))
    lines += _table(*_numbers(estimate, truth), (0, 3))
    if errors is not None:
        lines.append(Line(_describe_errors(errors, verbose)))
    elif truth is not None:
        mass, com = plain_errors(estimate.parameters, truth)
        text = f"errors: mass {significant(mass)} %, COM {significant(1e3 * com)} mm; that of the inertia"
        lines.append(Line(f"{text} is stated in shares of the size: give `shape`"))
    if verbose:
        return lines + [Line(line) for line in facts(estimate)]
    return [*lines, *map(Line, summary(estimate)), Line(MORE)]


def plain_errors(
    found: InertialParameters, truth: InertialParameters
) -> tuple[float, float]:
    """Error of the mass [%] and distance of the COM [m], without the object's size."""
    apart = np.linalg.norm(found.center_of_mass - truth.center_of_mass)
    return 100.0 * abs(found.mass / truth.mass - 1.0), float(apart)


def _numbers(
    estimate: Estimate, truth: InertialParameters | None
) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table of mass, COM and inertia, with the digits that their
    intervals justify."""
    columns = {"estimate": _ten_of(estimate.parameters)} | _spread(estimate)
    if truth is not None:
        columns["truth"] = _ten_of(truth)
    moments = zip(TENSOR_ROWS, TENSOR_COLUMNS, strict=True)
    inertia = (f"J{AXES[i]}{AXES[j]} at COM" for i, j in moments)
    names = ["mass", *(f"COM {a}" for a in AXES), *inertia]
    units = ["kg", *["mm"] * 3, *["kg m²"] * 6]
    worth = Worth.of(estimate)
    cells = [
        [worth.text(c[i], i, name == "estimate") for name, c in columns.items()]
        for i in range(len(names))
    ]
    groups = (cells[:1], cells[1:4], cells[4:])
    padded = [row for group in groups for row in aligned(group)]
    rows = [[n, *row, u] for n, row, u in zip(names, padded, units, strict=True)]
    return ["quantity", *columns, "unit"], rows


def _spread(estimate: Estimate) -> dict[str, list[float]]:
    """Columns of the ends of intervals, or else of standard deviations, or none."""
    keys = ("mass", "center_of_mass", "inertia_at_com")
    if (intervals := estimate.intervals) is not None:
        ends = np.array([_ten(*(intervals[k][i] for k in keys)) for i in (0, 1)])
        # a single finite end is a value in place of an open one
        half_open = estimate.undetermined.ten & ~np.isfinite(ends).all(axis=0)
        ends[:, half_open] = np.nan
        return dict(zip(("95 % from", "to"), ends.tolist(), strict=True))
    if (std := estimate.std) is not None:
        return {"± std": _ten(*(std[k] for k in keys))}
    return {}


def _describe_errors(errors: "Errors", verbose: bool) -> str:
    mass, com = (
        f"errors: mass {significant(errors.mass)} %",
        f"{significant(errors.center_of_mass)} %",
    )
    inertia = f"inertia {significant(errors.inertia_at_com)} %"
    if not verbose:
        return f"{mass}, COM {com} of box sides, {inertia} of box moments"
    return (
        f"{mass}, COM {com}, {inertia} about the COM and "
        f"{significant(errors.inertia_at_origin)} % about the sensor; "
        f"Riemannian distance {errors.riemannian:.3g}; COM in shares of the bounding box's "
        "sides, inertia of a uniform box's moments (Nadeau et al. 2022, eq. 10 to 12)"
    )


def print_lines(lines: Iterable[Line], render: Callable[[str], str] = str) -> None:
    """Print on standard output, wrapped to the terminal, or to `WIDTH` columns.

    `render` replaces the library's names of arguments by the reader's. Characters that
    control a terminal, as in a name from a file, become question marks.
    """
    takes_styles = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    styled = sys.stdout.isatty() and takes_styles
    width = output_width()
    for line in lines:
        text = "\n".join(map(printable, render(line.text).split("\n")))
        text = text if line.whole else wrapped(text, width)
        style = STYLES[line.style] if styled else ""
        print(f"{style}{text}\x1b[0m" if style else text)


def _table(
    head: list[str], rows: list[list[str]], ends: tuple[int, ...]
) -> Iterable[Line]:
    """A table with first and last column left-aligned, the others right-aligned, and a
    line after the rows `ends`; without blanks around cells where it is too wide."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    blank = " " if sum(widths) + 3 * len(widths) < output_width() else ""

    def ruled(left: str, line: str, between: str, right: str) -> Line:
        columns = (line * (width + 2 * len(blank)) for width in widths)
        return Line(left + between.join(columns) + right, whole=True)

    def cells(row: list[str], bar: str, style: Style = "") -> Line:
        last = len(row) - 1
        padded = [
            f"{blank}{c:<{w}}{blank}" if j in (0, last) else f"{blank}{c:>{w}}{blank}"
            for j, (c, w) in enumerate(zip(row, widths, strict=True))
        ]
        return Line(bar + bar.join(padded) + bar, style, whole=True)

    yield ruled(*"┏━┳┓")
    yield cells(head, "┃", "bold")
    yield ruled(*"┡━╇┩")
    for i, row in enumerate(rows):
        yield cells(row, "│")
        if i in ends:
            yield ruled(*"├─┼┤")
    yield ruled(*"└─┴┘")


def _ten_of(p: InertialParameters) -> list[float]:
    return _ten(p.mass, p.center_of_mass, p.inertia_at_com)


def _ten(mass: float | Array, com: Array, inertia: Array) -> list[float]:
    return [float(mass), *1e3 * com, *tensor_to_vector(inertia)]


def assumptions(estimate: Estimate) -> Iterable[str]:
    """What was read, found and assumed, one sentence each."""
    made = estimate.provenance
    when = "" if not estimate.duration else f" over {estimate.duration:.3g} s"
    what = f"{samples_told(estimate.samples)}{when}"
    if "motion" in made:
        what += f"; motion from {made['motion']}"
    yield what
    yield from _describe_recordings(estimate)
    if "wrench" in made:
        yield _describe_wrench(estimate)
    if "torque_gain_std" in made:
        yield _describe_torques(made)
    if made.get("tool"):
        yield f"a tool of {made['tool'][0]:.4f} kg was subtracted: what is shown is the object alone"
    for note in made.get("notes", ()):
        if getattr(note, "code", "") != "wrench-sign":  # said above
            yield f"- {note}"
    if made.get("bias_searched") and made.get("bias") == "none":
        yield "wrench bias: none beyond three standard deviations, so none assumed"
    if estimate.common_bias is not None:
        yield _describe_bias(estimate.common_bias, made.get("wrench") == "on-sensor")


def _describe_recordings(estimate: Estimate) -> Iterable[str]:
    """Each of several recordings, with its bias."""
    each = estimate.provenance.get("recordings", ())
    if not each:
        return
    own = estimate.bias
    what = "clock" if own is None else "clock and a wrench bias"
    yield (
        f"assumed: {len(each)} recordings of one object in one grasp, in the same sensor "
        f"frame, each with a {what} of its own:"
    )
    biases = [None] * len(each) if own is None or own.ndim == 1 else own
    for one, bias in zip(each, biases, strict=True):
        span = f" over {one['duration']:.3g} s" if one.get("duration") else ""
        text = f"- {one['name']}: {one['samples']} samples{span}"
        if bias is None:
            yield text
        else:
            yield f"{text}; {_describe_bias(bias, one.get('wrench') == 'on-sensor')}"


def _describe_wrench(estimate: Estimate) -> str:
    made = estimate.provenance
    how = sign_told(made, estimate.warnings)
    g = ", ".join(f"{x:g}" for x in made["gravity"])
    found = ", found" if made.get("gravity_found") else ""
    std = made.get("gravity_std")
    known = f", its size ± {std:.2g} m/s²" if std else ""
    return f"assumed: wrench {made['wrench']} ({how}), gravity ({g}) m/s² in world axes{found}{known}"


def _describe_torques(made: Mapping[str, Any]) -> str:
    gains = made.get("torque_gains")
    unit = "in N m" if gains is None else f"times {', '.join(f'{x:g}' for x in gains)}"
    g = ", ".join(f"{x:g}" for x in made["gravity"])
    return (
        f"assumed: torques as recorded {unit}, each joint's right to "
        f"{100.0 * made['torque_gain_std']:g} %; the arm of {made['arm']}; gravity "
        f"({g}) m/s² in the axes of the base"
    )


def _describe_bias(bias: Array, on_sensor: bool) -> str:
    """The wrench bias found, with the sign of the recorded wrench."""
    recorded = wrench_text(-bias if on_sensor else bias)
    return f"wrench bias as recorded: {recorded}"


def summary(estimate: Estimate) -> Iterable[str]:
    """The data that the answer is from, in a few lines."""
    made = estimate.provenance
    when = f" over {estimate.duration:.3g} s" if estimate.duration else ""
    when = " of static poses" if estimate.duration is None else when
    text = f"from {samples_told(estimate.samples)}{when}"
    if recordings := made.get("recordings"):
        text += (
            f" in {len(recordings)} recordings, taken to be of one object, grasp and "
            "sensor frame"
        )
    elif "wrench" in made:
        side = "object" if made["wrench"] == "on-object" else "sensor"
        how = sign_told(made, estimate.warnings)
        text += f"; wrench on the {side}, {how}"
    yield text
    yield from (
        f"- {note}" for note in made.get("notes", ()) if codes((note,)) & MENDED
    )
    if made.get("tool"):
        yield f"without the tool of {made['tool'][0]:.4g} kg, which was subtracted"
    yield from _describe_scale(made)
    if "until" in made:
        yield _describe_until(estimate)


def _describe_scale(made: Mapping[str, Any]) -> Iterable[str]:
    if "sensor_gain" not in made:
        return
    gain = round(100.0 * made["sensor_gain"], 2)
    off = f"{abs(gain):g} % too {'much' if gain > 0.0 else 'little'}"
    by_it = f"the sensor shows {off}" if gain else "the sensor's gain is right"
    by_it = "" if "torque_gain_std" in made else f"; by it {by_it}"
    yield f"the scale's {made['mass']} was used{by_it}"


def _describe_until(estimate: Estimate) -> str:
    """The part of the recording that the requested accuracy took."""
    made = estimate.provenance
    of = f"{made['used']:.4g} of {made['of']:.4g} {made['used_unit']} used"
    known = "" if estimate.accuracy is None else f": sure (95 %) to {estimate.accuracy}"
    return f"{of}, asked for {made['until']}{known}"


def facts(estimate: Estimate) -> Iterable[str]:
    """`assumptions`, then the shape's accuracy, settings, residual and certificate."""
    yield from assumptions(estimate)
    made = estimate.provenance
    if "until" in made:
        yield _describe_until(estimate)
    yield from _describe_scale(made)
    if any(made.get("pose_std", ())):
        m, rad = made["pose_std"]
        yield f"the shape's pose is taken as known to {1e3 * m:.3g} mm and {np.degrees(rad):.3g}°"
    if made.get("shape_std"):
        yield f"the shape is taken as known to {100 * made['shape_std']:.3g} % of its size"
    if made.get("shape_known") == "bounds":
        yield "the object is taken to be somewhere inside the box, of any shape"
    from hefting.estimators import settings_text

    if settings := settings_text(made):
        yield settings
    if estimate.residual is not None:
        yield f"residual: {estimate.residual[0]:.3g} N, {estimate.residual[1]:.3g} N m root mean square"
    consistency = estimate.consistency
    yield (
        "physically consistent"
        if consistency.is_consistent
        else f"not physically consistent: {consistency}"
    )
    if estimate.certificate is not None:
        c = estimate.certificate
        how = f"at most {c.gap:.1g} above" if c.gap > 0.0 else "to rounding"
        yield f"certificate: objective {c.objective:.6g}, {how} the optimum"
