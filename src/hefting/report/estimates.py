"""Estimates, comparisons and methods as tables a person can read, with units."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.estimate import Estimate
from hefting.estimators import VARIANTS, describe_methods, method_named
from hefting.estimators.base import INVARIANCES
from hefting.inertia import EXPLANATIONS, InertialParameters
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.metrics import Errors
from hefting.plausibility import MISFIT
from hefting.report.printing import warning_lines
from hefting.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array

if TYPE_CHECKING:
    from hefting.comparison import Comparison

AXES = "xyz"
SETTINGS = ("points", "c1", "regularization", "gamma")
"""Hyperparameters that are shown."""


def methods_report() -> RenderableType:
    """Every method: what it does, needs, guarantees, is best for and does not depend on."""
    known = describe_methods()
    table = Table(box=SIMPLE_HEAD, show_lines=True, pad_edge=False)
    for name in ("method", "what it does", "needs", "best for"):
        table.add_column(name, no_wrap=name == "method")
    for name, of in known.items():
        what = f"{of['summary']}\n[dim]{of['source']}[/dim]"
        table.add_row(f"[bold]{name}[/bold]", what, of["needs"], of["best_for"])
    lines = [f"always a body that can exist: {', '.join(name for name in known if known[name]['consistent'])}"]
    lines.append("where the motion determines all and the noise is known, these find the same body for")
    for invariance, of in INVARIANCES.items():
        others = [name for name in known if invariance not in known[name]["invariances"]]
        lines.append(f"- {of}: {'all but ' + ', '.join(others) if others else 'all'}")
    lines.append(f"with another model of the motion, or a condition more: {', '.join(VARIANTS)}")
    return Group(table, *map(Text, lines))


def estimate_report(
    estimate: Estimate, truth: InertialParameters | None = None, errors: Errors | None = None
) -> RenderableType:
    """Mass, COM and inertia at the COM, beside intervals or standard deviations, and the truth, where known."""
    columns = {"estimate": _values(estimate.parameters)}
    std, intervals = estimate.std, estimate.intervals
    if intervals is not None:
        for name, i in (("95 % from", 0), ("to", 1)):
            columns[name] = _ten(*(intervals[key][i] for key in ("mass", "center_of_mass", "inertia_at_com")))
    elif std is not None:
        columns["± std"] = _ten(std["mass"], std["center_of_mass"], std["inertia_at_com"])
    if truth is not None:
        columns["truth"] = _values(truth)
    table = Table()
    table.add_column("quantity")
    for name in columns:
        table.add_column(name, justify="right")
    table.add_column("unit")
    names = ["mass", *(f"COM {a}" for a in AXES), *_inertia_names()]
    units = ["kg", *["mm"] * 3, *["kg m²"] * 6]
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        table.add_row(name, *(_number(column[i], i) for column in columns.values()), unit, end_section=i in (0, 3))
    lines: list[RenderableType] = [Text(f"{estimate.method}: what the sensor holds, in sensor axes"), table]
    if errors is not None:
        lines.append(
            Text(
                f"errors: mass {errors.mass:.2g} %, COM {errors.center_of_mass:.2g} %, inertia "
                f"{errors.inertia_at_origin:.2g} % about the sensor and {errors.inertia_at_com:.2g} % about the COM, "
                f"Riemannian {errors.riemannian:.3g}"
            )
        )
    return Group(*lines, *_facts(estimate), *warning_lines(estimate.warnings))


def _values(p: InertialParameters) -> list[float]:
    return _ten(p.mass, p.center_of_mass, p.inertia_at_com)


def _ten(mass: float | Array, com: Array, inertia: Array) -> list[float]:
    return [float(mass), *1e3 * com, *inertia[TENSOR_ROWS, TENSOR_COLUMNS]]


def _inertia_names() -> list[str]:
    return [f"J{AXES[i]}{AXES[j]} at COM" for i, j in zip(TENSOR_ROWS, TENSOR_COLUMNS, strict=True)]


def _number(value: float, row: int) -> str:
    if not np.isfinite(value):
        return "open"
    return f"{value:.4f}" if row == 0 else f"{value:.2f}" if row < 4 else f"{value:.3e}"


def _assumptions(estimate: Estimate) -> Iterable[Text]:
    made = estimate.provenance
    when = "" if not estimate.duration else f" over {estimate.duration:.3g} s"
    what = f"{estimate.samples} samples{when}"
    if "motion" in made:
        what += f"; motion from {made['motion']}"
    yield Text(what)
    if "wrench" in made:
        how = "found from gravity" if made.get("wrench_found") else "as given"
        g = ", ".join(f"{x:g}" for x in made["gravity"])
        found = ", found" if made.get("gravity_found") else ""
        yield Text(f"assumed: wrench {made['wrench']} ({how}), gravity ({g}) m/s² in world axes{found}")
    if made.get("tool"):
        yield Text(f"a tool of {made['tool'][0]:.4f} kg was subtracted: what is shown is the object alone")
    for note in made.get("notes", ()):
        if not note.startswith("the wrench is on-"):  # said above
            yield Text(f"- {note}")
    if made.get("bias_searched") and made.get("bias") == "none":
        yield Text("wrench bias: none beyond three standard deviations, so none assumed")
    if estimate.bias is not None:
        recorded = -estimate.bias if made.get("wrench") == "on-sensor" else estimate.bias
        f, t = recorded[:3], recorded[3:]
        force, torque = ", ".join(f"{x:.3g}" for x in f), ", ".join(f"{x:.3g}" for x in t)
        yield Text(f"wrench bias found with it, as recorded: ({force}) N, ({torque}) N m")


def _facts(estimate: Estimate) -> Iterable[Text]:
    yield from _assumptions(estimate)
    made = estimate.provenance
    if "until" in made:
        of = f"{made['used']:.4g} of {made['of']:.4g} {made['used_unit']} used"
        known = "" if estimate.accuracy is None else f": sure (95 %) to {estimate.accuracy}"
        yield Text(f"{of}, asked for {made['until']}{known}")
    if any(made.get("pose_std", ())):
        m, rad = made["pose_std"]
        yield Text(f"the shape's pose is taken as known to {1e3 * m:.3g} mm and {np.degrees(rad):.3g}°")
    if made.get("shape_std"):
        yield Text(f"the shape is taken as known to {100 * made['shape_std']:.3g} % of its size")
    settings = [f"{k} = {made[k]:g}" for k in SETTINGS if isinstance(made.get(k), float | int)]
    if settings:
        yield Text(", ".join(settings))
    if estimate.residual is not None:
        yield Text(f"residual: {estimate.residual[0]:.3g} N, {estimate.residual[1]:.3g} N m root mean square")
    consistency = estimate.consistency
    yield Text("physically consistent" if consistency.is_consistent else f"not physically consistent: {consistency}")
    if estimate.certificate is not None:
        c = estimate.certificate
        how = f"at most {c.gap:.1g} above" if c.gap > 0.0 else "to rounding"
        yield Text(f"certificate: objective {c.objective:.6g}, {how} the optimum")


def comparison_report(comparison: "Comparison", errors: dict[str, Errors] | None = None) -> RenderableType:
    """Methods as rows: mass, COM, inertia, residual, consistent or why not, time; and which one to trust."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("method", no_wrap=True)
    for name in ("mass\nkg", "COM x, y, z\nmm", "Jxx, Jyy, Jzz at COM\n10⁻³ kg m²", "residual\nN, N m"):
        table.add_column(name, justify="right", overflow="fold")
    table.add_column("consistent", overflow="fold")
    table.add_column("time\nms", justify="right", no_wrap=True)
    names = list(comparison.results)
    noise, open_ = comparison.prepared.fit.noise, comparison.prepared.fit.open_parameters(TYPICAL_SIZE)
    for name, following in zip(names, [*names[1:], None], strict=True):
        e = comparison.results[name]
        p, r = e.parameters, e.residual
        moments = p.inertia_at_com.diagonal()
        J = ", ".join(f"{1e3 * x if abs(x) > 1e-9 * np.abs(moments).max() else 0.0:.2g}" for x in moments)
        if method_named(name)[0].needs == "nothing" and {"Jxx", "Jyy", "Jzz"} & set(open_):
            J = "open"
        misfit = r is not None and bool((r > MISFIT * np.array((noise.force, noise.torque))).any())
        row = [
            f"[bold]{name}[/bold] ◀" if name == comparison.recommended else name,
            f"{p.mass:.4g}",
            ", ".join(f"{1e3 * x:.1f}" for x in p.center_of_mass),
            J,
            "" if r is None else f"{'! ' if misfit else ''}{r[0]:.2g}, {r[1]:.2g}",
            "yes" if e.physically_consistent else f"no: {FAILURES[e.consistency.violated or 'mass']}",
            f"{1e3 * comparison.seconds[name]:.1f}",
        ]
        table.add_row(*row, end_section=following in VARIANTS and name not in VARIANTS)
    lines: list[RenderableType] = [table]
    if errors:
        lines.append(_errors_table(errors))
    failed = {e.consistency.violated for e in comparison.results.values()} - {None}
    lines += [Text(f"no: {FAILURES[name]}: {EXPLANATIONS[name]}") for name in EXPLANATIONS if name in failed]
    if any(name in VARIANTS for name in names):
        lines.append(Text("below the line: variants, see hefting methods"))
    lines.extend(Text(f"left out: {why}") for why in comparison.skipped.values())
    lines.append(Text(f"recommended: {comparison.recommended}, as {comparison.reason}", style="bold"))
    best = comparison.results[comparison.recommended]
    return Group(*lines, *_assumptions(best), *warning_lines(best.warnings))


def _errors_table(errors: dict[str, Errors]) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("error in %", no_wrap=True)
    for name in ("mass", "COM", "inertia, sensor", "inertia, COM"):
        table.add_column(name, justify="right", no_wrap=True)
    for name, e in errors.items():
        found = (e.mass, e.center_of_mass, e.inertia_at_origin, e.inertia_at_com)
        table.add_row(name, *map(_percent, found))
    return table


def _percent(value: float) -> str:
    return "< 0.01" if value < 0.01 else f"{value:.2g}" if value < 10.0 else f"{value:.0f}"


FAILURES = {
    "mass": "mass",
    "inertia": "inertia",
    "triangle": "triangle",
    "pseudo_inertia": "pseudo",
    "hull": "COM",
}
"""The condition of consistency that fails, in a word or two."""
