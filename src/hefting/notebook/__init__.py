"""Notebook: HTML of estimates, comparisons and shapes in Jupyter.

    html_of(hefting.identify("demo/log.csv"))

A value is one block without scripts, with inline styles; all text from outside is
escaped.
"""

import base64
import io
import re
from collections.abc import Callable, Iterable, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from hefting.core.errors import MissingDependencyError, printable
from hefting.core.estimate import Estimate
from hefting.core.messages import Verdict
from hefting.core.spatial import Array
from hefting.identification import Comparison
from hefting.identification.agreement import QUANTITIES, Agreement
from hefting.identification.identify import Answer
from hefting.scene import (
    Scene,
    place_of,
    plus_minus,
    power_of_thousand,
    reach,
    scene_of,
)
from hefting.shapes import Shape

TITLES = ("quantity", "estimate ± 95 %", "from", "to", "unit")
MOMENTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2)}
PRODUCTS = {"Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}
MOST_WARNINGS = 12
"""Most warnings that are shown."""
KNOWN = {
    "object": "the object's own shape",
    "bounds": "the object is somewhere inside",
    "reach": "the object is somewhere about the sensor, of any size",
}


class Row(NamedTuple):
    """One number of a body, as a row below `TITLES`."""

    name: str
    value: str
    """With ± the `reach` of its interval, or ``open``."""
    low: str
    high: str
    """Ends of its interval, or empty."""
    unit: str


def rows_of(estimate: Estimate, products: bool = True) -> list[Row]:
    """Mass, COM and moments of inertia about the COM, in sensor axes, with `products` of
    inertia if wanted."""
    p = estimate.parameters
    unit, scale = power_of_thousand(p.inertia_at_com.diagonal())

    def row(name: str, quantity: str, at: tuple[int, ...], scale: float, unit: str):
        values = np.asarray(getattr(p, quantity))
        halves, value = reach(estimate, quantity), scale * values[at]
        half = None if halves is None else scale * float(halves[at])
        ends = ["", ""]
        if estimate.intervals is not None and half is not None and np.isfinite(half):
            ends = [scale * float(end[at]) for end in estimate.intervals[quantity]]
            ends = [plus_minus(end, half).split(" ± ")[0] for end in ends]
        return Row(name, plus_minus(float(value), half), *ends, unit)

    rows = [row("mass", "mass", (), 1.0, "kg")]
    for i, axis in enumerate("xyz"):
        rows.append(row(f"COM {axis}", "center_of_mass", (i,), 1e3, "mm"))
    unit = f"{unit}kg m²"
    for name, at in (MOMENTS | PRODUCTS if products else MOMENTS).items():
        rows.append(row(f"{name} at COM", "inertia_at_com", at, scale, unit))
    return rows


def answer_html(answer: Answer | Estimate) -> str:
    """An estimate, alone or in an answer, as a block."""
    estimate = answer if isinstance(answer, Estimate) else answer.estimate
    return block(card(estimate, type(answer).__name__))


def card(estimate: Estimate, title: str) -> str:
    """Verdict, numbers and warnings beside a picture."""
    extent = "" if estimate.duration is None else f", {estimate.duration:.4g} s"
    log = estimate.provenance.get("log")
    source = f" of {log}" if isinstance(log, str) and log else ""
    after = f"{title} by {estimate.method}: {estimate.samples} samples{extent}{source}"
    what = "COM with its 95 % region and ellipsoid of equal inertia, in three views"
    picture = picture_html(scene_of({"estimate": estimate}), what)
    numbers = table_html(TITLES, rows_of(estimate))
    others = estimate.verdict.others(estimate.warnings)
    more = [f"warning: {text}" for text in others]
    if len(more) > MOST_WARNINGS:
        hidden = len(more) - MOST_WARNINGS
        more[MOST_WARNINGS:] = [f"and {hidden} more in .warnings"]
    verdict = verdict_html(estimate.verdict, after)
    return verdict + list_html(more) + beside(numbers, picture)


def comparison_html(comparison: Comparison) -> str:
    """The recommended estimate, then a table of all methods."""
    names = list(comparison.shown)
    first = next(iter(comparison.results.values()))
    units = [f"{row.name} [{row.unit}]" for row in rows_of(first, products=False)]
    head = ("method", "verdict", *units, "residual [N]", "[N m]", "time [ms]")
    rows = []
    for name, estimate in comparison.shown.items():
        numbers = [row.value for row in rows_of(estimate, products=False)]
        residual = ["", ""]
        if estimate.residual is not None:
            residual = [f"{value:.3g}" for value in estimate.residual]
        seconds = comparison.seconds.get(name)
        took = "" if seconds is None else f"{1e3 * seconds:.3g}"
        rows.append((name, str(estimate.verdict), *numbers, *residual, took))
    skipped = [f"not used: {why}" for why in comparison.skipped.values()]
    return block(
        card(comparison.estimate, "Comparison"),
        paragraph(f"recommended: {comparison.recommended}, as {comparison.reason}"),
        table_html(head, rows, bold=names.index(comparison.recommended)),
        list_html(skipped),
    )


def agreement_html(agreement: Agreement) -> str:
    """The result in words, then a table of each quantity by each estimate."""
    head = ("quantity", *agreement.values, "standard deviations apart")
    apart = np.max(list(agreement.apart.values()), axis=0)
    rows = []
    for i, (name, unit) in enumerate(QUANTITIES):
        scale, unit = (1e3, "mm") if unit == "m" else (1.0, unit)
        cells = [
            _number(scale * values[i], scale * agreement.intervals[of][:, i])
            for of, values in agreement.values.items()
        ]
        rows.append((f"{name} [{unit}]", *cells, f"{apart[i]:.1f}"))
    doubted = [f"{name}: {verdict}" for name, verdict in agreement.doubted.items()]
    words = paragraph(_agreement_text(agreement))
    return block(words, list_html(doubted), table_html(head, rows))


def _agreement_text(agreement: Agreement) -> str:
    if not agreement.tested:
        return "nothing to compare by: no two estimates determine the same quantity"
    worst = agreement.largest
    words = "agree" if agreement.agree else "contradict one another"
    return (
        f"the estimates {words}: {worst.first} and {worst.second} differ most, in "
        f"{worst.name}, by {worst.deviations:.1f} standard deviations (limit "
        f"{agreement.limit:.1f})"
    )


def _number(value: float, ends: Array) -> str:
    half = float(abs(ends - value).max())
    if half > 0.0 and half < 1e-4:  # `plus_minus` rounds to six decimals
        return f"{value:.3g} ± {half:.1g}".replace("-", "−")
    return plus_minus(value, half)


def shape_html(shape: Shape) -> str:
    """A shape as a block."""
    sides = " × ".join(f"{1e3 * side:.1f}" for side in shape.extents)
    rows = [
        ("known", KNOWN.get(shape.known, shape.known)),
        ("points", f"{shape.n:,}"),
        ("triangles", "none" if shape.faces is None else f"{len(shape.faces):,}"),
        ("bounding box [mm]", sides),
    ]
    if shape.shape_std:
        rows.append(
            ("may differ by (std)", f"{100 * shape.shape_std:.0f} % of its size")
        )
    scene = scene_of(shape=shape, known={"uniform shape": shape.homogeneous})
    picture = picture_html(
        scene.with_centers_only(), "the shape in three views, in sensor axes"
    )
    words = "".join(paragraph(line) for line in place_of(shape))
    warnings = list_html(f"warning: {text}" for text in shape.warnings)
    left = table_html(("Shape", "in sensor axes"), rows) + words
    return block(warnings, beside(left, picture))


KINDS: dict[type, Callable[[Any], str]] = {
    Comparison: comparison_html,
    Answer: answer_html,
    Estimate: answer_html,
    Agreement: agreement_html,
    Shape: shape_html,
}
"""Function that makes the HTML of each kind of value; the first matching one is used."""


def html_of(value: object) -> str | None:
    """A value as HTML for a notebook; None for other kinds of values."""
    for kind, make in KINDS.items():
        if isinstance(value, kind):
            return make(value)
    return None


LONGEST = 400
"""Most characters of a text from outside that are shown."""
LINE = "1px solid rgba(128,128,128,0.45)"
CELL = f"padding:2px 8px 2px 0;text-align:left;border-bottom:{LINE};white-space:nowrap"
HEAD = f"{CELL};font-weight:600"
BADGES = {"good": "#1b6e3c", "usable with care": "#8a5a00", "do not use": "#b3261e"}
"""Background of each verdict, on which white text is readable."""
LARGEST = 100_000
"""Most characters of a picture."""
RESOLUTIONS = (150, 100, 60)
"""Dots per inch of the shape; the first with a picture of at most `LARGEST` is used."""
CARD = "background:#fff;border-radius:4px;padding:4px;max-width:100%;height:auto"
"""Style of pictures: their dark lines need white also on a dark page."""


def text_html(text: str) -> str:
    """A text from outside, cut to `LONGEST`; arguments in backquotes become code."""
    text = printable(" ".join(str(text).split()))
    cut = text if len(text) <= LONGEST else f"{text[: LONGEST - 2]} …"
    return re.sub(r"`(\w+)`", r"<code>\1</code>", escape(cut))


def block(*parts: str) -> str:
    """Parts one below another."""
    style = "font-size:13px;line-height:1.45;max-width:100%"
    return f'<div class="hefting" style="{style}">{"".join(parts)}</div>'


def beside(left: str, right: str) -> str:
    """Two parts side by side, one below the other on a narrow page."""
    if not right:
        return left
    style = "display:flex;flex-wrap:wrap;gap:12px 28px;align-items:flex-start"
    cell = '<div style="min-width:0;max-width:100%">'
    return f'<div style="{style}">{cell}{left}</div>{cell}{right}</div></div>'


def verdict_html(verdict: Verdict, after: str) -> str:
    """The verdict, the text `after` it, and its reasons."""
    colour = BADGES[verdict.level]
    badge = f"background:{colour};color:#fff;padding:1px 8px;border-radius:3px"
    line = (
        f'<div style="margin:2px 0 6px"><b style="{badge}">verdict: {verdict}</b> '
        f"{text_html(after)}</div>"
    )
    return line + list_html(verdict.reasons)


def list_html(texts: Iterable[str]) -> str:
    """A list of texts from outside; empty without any."""
    items = "".join(f"<li>{text_html(text)}</li>" for text in texts)
    return (
        f'<ul style="margin:2px 0 8px;padding-left:20px">{items}</ul>' if items else ""
    )


def paragraph(text: str) -> str:
    """A line of text from outside."""
    return f'<div style="margin:2px 0 6px">{text_html(text)}</div>'


def table_html(
    head: Sequence[str], rows: Iterable[Sequence[str]], bold: int = -1
) -> str:
    """A table of texts from outside; the row `bold` is set in bold type."""
    top = "".join(f'<th style="{HEAD}">{text_html(cell)}</th>' for cell in head)
    body = ""
    for k, row in enumerate(rows):
        style = HEAD if k == bold else CELL
        cells = "".join(f'<td style="{style}">{text_html(cell)}</td>' for cell in row)
        body += f'<tr style="background:none">{cells}</tr>'
    style = "border-collapse:collapse;font-size:12px;font-variant-numeric:tabular-nums;color:inherit;margin:0 0 8px"
    return (
        f'<div style="overflow-x:auto"><table style="{style}"><thead>'
        f'<tr style="background:none">{top}</tr></thead><tbody>{body}</tbody></table></div>'
    )


def picture_html(scene: Scene, alt: str) -> str:
    """Three views of a scene as an SVG in the page; empty without matplotlib, and if it
    were larger than `LARGEST`.

    The SVG is the data of an image, which keeps its styles and names apart from those of
    the page and of other pictures.
    """
    try:
        for resolution in RESOLUTIONS:
            data = base64.b64encode(_svg(scene, resolution)).decode()
            html = f'<img style="{CARD}" alt="{alt}" src="data:image/svg+xml;base64,{data}"/>'
            if len(html) <= LARGEST:
                return html
    except MissingDependencyError:
        pass
    return ""


def _svg(scene: Scene, resolution: float) -> bytes:
    """The views as SVG, with the shape as pixels of a resolution [dots per inch]."""
    from hefting.plots.style import FORMATS, drawing, style, subfigures_of
    from hefting.plots.views import draw_scene, height_of

    with style():
        from matplotlib import rc_context

        with rc_context({"svg.fonttype": "none"}):
            with drawing(height_of(scene)) as figure:
                (views,) = subfigures_of(figure, 1)
                draw_scene(views, scene)
                for axes in views.axes:
                    for each in axes.collections:
                        each.set_rasterized(each.get_zorder() == 0)
            content = io.BytesIO()
            figure.savefig(
                content, format="svg", dpi=resolution, metadata=FORMATS[".svg"]
            )
            return content.getvalue()
