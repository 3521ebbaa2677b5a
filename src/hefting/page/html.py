"""HTML: elements whose text is escaped; bars of intervals or counts on one scale; and
sections with figures as one page that needs no network."""

import base64
import gzip
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from html import escape as _escape
from importlib.resources import files
from importlib.util import find_spec

import numpy as np

from hefting import __version__
from hefting.core.errors import MissingDependencyError
from hefting.core.spatial import immutable
from hefting.page.figure import DARK, LIGHT, Figure
from hefting.scene import plus_minus

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"
)
"""Content security policy: the page runs what is in it and fetches nothing. Plotly
compiles functions from descriptions of shaders, which needs ``unsafe-eval``."""


class Markup(str):
    """Text that is already HTML."""

    __slots__ = ()


def escape(text: object) -> Markup:
    """Any text as HTML; `Markup` is unchanged."""
    return text if isinstance(text, Markup) else Markup(_escape(str(text)))


def element(tag: str, *content: object, **attributes: object) -> Markup:
    """An element with its content; in names of attributes ``_`` becomes ``-``, a trailing
    one is removed, as in ``class_``."""
    named = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{_escape(str(value))}"'
        for name, value in attributes.items()
    )
    return Markup(f"<{tag}{named}>{join(*content)}</{tag}>")


def join(*parts: object) -> Markup:
    """The parts, concatenated."""
    return Markup("".join(map(escape, parts)))


def note(text: object) -> Markup:
    """A paragraph in small print."""
    return element("p", text, class_="note")


def wrapped(text: object) -> Markup:
    """A text in a cell that may have several lines."""
    return element("span", text, class_="text")


def items(lines: Iterable[object], **attributes: object) -> Markup:
    """A list of items; empty without any."""
    rows = [element("li", line) for line in lines]
    return element("ul", *rows, **attributes) if rows else Markup()


def table(head: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """A table in a box that scrolls; the first cell of a row is its heading."""
    top = element("tr", *(element("th", name, scope="col") for name in head))
    body = []
    for name, *cells in rows:
        others = [element("td", cell) for cell in cells]
        body.append(element("tr", element("th", name, scope="row"), *others))
    whole = element("table", element("thead", top), element("tbody", *body))
    return element("div", whole, class_="wide")


def terms(pairs: Iterable[tuple[object, object]]) -> Markup:
    """A list of terms with their descriptions."""
    rows = [
        element("div", element("dt", name), element("dd", what)) for name, what in pairs
    ]
    return element("dl", *rows)


@immutable
class Section:
    """A part of a page, with a heading."""

    name: str
    """Unique name, for its place in the page"""
    title: str
    content: Markup
    figures: tuple[Figure, ...] = ()
    """Drawn after the content"""

    @property
    def html(self) -> Markup:
        """The section with the places of its figures."""
        title = element("h2", self.title)
        places = map(_place, self.figures)
        return element("section", title, self.content, *places, id=self.name)


def page_of(
    title: str, lines: Iterable[str], sections: Iterable[Section | None]
) -> str:
    """The page, which includes the drawing library if there are figures; `lines` follow
    its title. Raises `MissingDependencyError` without plotly."""
    shown = [section for section in sections if section is not None]
    figures = [figure for section in shown for figure in section.figures]
    links = [element("a", s.title, href=f"#{s.name}") for s in shown]
    body = join(
        element(
            "header",
            element("h1", title),
            *(element("p", line, class_="muted") for line in lines),
            element("nav", *links, aria_label="sections"),
        ),
        element("main", *(section.html for section in shown)),
        element("footer", f"Made by Hefting {__version__}."),
        _json("palettes", {"light": LIGHT, "dark": DARK}),
        _json("figures", [vars(figure) for figure in figures]),
        _plotly() if figures else Markup(),
        Markup(f"\n<script>{_package_file('report.js')}</script>"),
    )
    head = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}"><link rel="icon" href="data:,">'
    return document(title, body, head)


def document(title: str, body: Markup, head: str = "") -> str:
    """A whole page in the style of reports, with `head` among what describes it."""
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">{head}'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{_styles()}</style></head>\n"
        f"<body>{body}</body></html>\n"
    )


def _place(figure: Figure) -> Markup:
    return element(
        "div",
        id=f"figure-{figure.name}",
        class_="figure solid" if "scene" in figure.layout else "figure",
        style=f"min-height:{figure.height}px",
        role="img",
        aria_label=figure.about,
    )


def _styles() -> str:
    light, dark = (
        "".join(f"--{name}:{value};" for name, value in colours.items())
        for colours in (LIGHT, DARK)
    )
    in_the_dark = f"@media (prefers-color-scheme: dark){{:root{{{dark}}}}}"
    return f":root{{{light}}}{in_the_dark}\n{_package_file('report.css')}"


def _json(name: str, value: object) -> Markup:
    """Data for the script, escaped so that no text in it ends the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    text = text.replace("<", "\\u003c").replace("&", "\\u0026")
    return Markup(f'<script type="application/json" id="{name}">{text}</script>')


def require_plotly() -> None:
    """`MissingDependencyError` unless plotly is installed."""
    if find_spec("plotly") is None:
        raise MissingDependencyError("plotly", "view")


@lru_cache(maxsize=1)
def _plotly() -> Markup:
    """The drawing library, compressed to two fifths of its size."""
    require_plotly()
    source = files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    packed = base64.b64encode(gzip.compress(source, mtime=0)).decode()
    return Markup(f'<script type="text/plain" id="plotly">{packed}</script>')


def _package_file(name: str) -> str:
    return files("hefting.page").joinpath(name).read_text("utf-8")


@dataclass(frozen=True)
class Row:
    """One quantity with its interval, in the unit of the scale."""

    name: str
    value: float | None
    """None if only the interval is known; not shown if open"""
    low: float
    """lower end, minus infinity if open; NaN if the method has no interval"""
    high: float
    truth: float | None = None
    matters: bool = True
    """whether the scale must hold it"""

    @property
    def is_open(self) -> bool:
        """Whether the interval is infinite on both sides."""
        return bool(np.isinf((self.low, self.high)).all())


def bars(rows: Sequence[Row], unit: str, *, from_zero: bool = False) -> Markup:
    """Rows of one unit as HTML: name, number, and the interval as a bar, with a common
    scale below, which holds zero if `from_zero`."""
    rows = [replace(row, value=None) if row.is_open else row for row in rows]
    low, high = _scale(rows, from_zero=from_zero)
    cells: list[Markup] = []
    for row in rows:
        number = _number(row)
        shown = number if number == "open" else f"{number} {unit}"
        cells += _cells(row.name, shown, *_marks(row, low, high))
    marked = not all(row.is_open and row.truth is None for row in rows)
    labels = _labels(low, high, unit) if marked else ()
    scale = element("div", *labels, class_="scale")
    return element("div", *cells, scale, class_="bars")


def _cells(name: str, number: str, *drawn: Markup) -> list[Markup]:
    return [
        element("span", name),
        element("span", number, class_="value"),
        element("span", *drawn, class_="track"),
    ]


def _number(row: Row) -> str:
    """The value ± the distance of the farther end of its interval; without a value the
    middle of the interval."""
    if row.value is None and np.isfinite((row.low, row.high)).all():
        middle, half = 0.5 * (row.low + row.high), 0.5 * (row.high - row.low)
        return plus_minus(middle, half)
    if row.value is None or not np.isfinite(row.value):
        return "open"
    if np.isnan(row.low):
        return plus_minus(row.value, None)
    return plus_minus(row.value, max(row.high - row.value, row.value - row.low))


def _scale(rows: Sequence[Row], *, from_zero: bool) -> tuple[float, float]:
    """Ends of a scale for all finite numbers of rows that matter, with a margin."""
    held = [0.0] if from_zero else []
    for row in rows:
        if row.matters:
            given = (row.value, row.low, row.high, row.truth)
            held += [v for v in given if v is not None and np.isfinite(v)]
    low, high = (min(held), max(held)) if held else (0.0, 1.0)
    room = 0.08 * (high - low) or max(abs(high), 1e-9)
    return (low - room if low < 0.0 or not from_zero else 0.0), high + room


def _marks(row: Row, low: float, high: float) -> Iterable[Markup]:
    def at(value: float) -> float:
        return float(np.clip(100.0 * (value - low) / (high - low), 0.0, 100.0))

    if row.is_open:
        yield element("i", class_="open", title="open: not determined")
    elif not np.isnan(row.low):
        left, right = at(row.low), at(row.high)
        style = f"left:min({left:.3f}%,100% - 4px);width:{right - left:.3f}%"
        yield element("i", class_="range", style=style)
    if low < 0.0 < high:
        yield element("i", class_="zero", style=f"left:{at(0.0):.3f}%")
    if row.value is not None and np.isfinite(row.value) and low <= row.value <= high:
        yield element("i", class_="at", style=f"left:{at(row.value):.3f}%")
    if row.truth is not None:
        title = f"truth: {row.truth:.5g}"
        yield element(
            "i", class_="true", style=f"left:{at(row.truth):.3f}%", title=title
        )


def _labels(low: float, high: float, unit: str) -> list[Markup]:
    def text(value: float) -> str:
        return f"{value:.3g}".replace("-", "−")

    share = -low / (high - low)
    middle = []
    if 0.25 < share < 0.65:
        style = f"left:{100.0 * share:.3f}%;transform:translateX(-50%)"
        middle = [element("span", "0", style=style)]
    return [
        element("span", text(low), style="left:0"),
        *middle,
        element("span", f"{text(high)} {unit}", style="right:0"),
    ]


@dataclass(frozen=True)
class Count:
    """An amount of one kind."""

    name: str
    value: float
    shown: str
    """The value as text"""
    colour: str = "x"
    """Name of a colour of `hefting.page.figure`"""


def counts(rows: Sequence[Count]) -> Markup:
    """Rows as HTML: name, number, and its share of the total as a bar."""
    total = sum(row.value for row in rows) or 1.0
    cells: list[Markup] = []
    for row in rows:
        width = f"left:0;width:{100.0 * row.value / total:.3f}%"
        bar = element("i", style=f"{width};background:var(--{row.colour})")
        cells += _cells(row.name, row.shown, bar)
    return element("div", *cells, class_="bars")
