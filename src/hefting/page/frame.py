"""Frame: sections and their figures as one HTML page that asks nothing of a network."""

import base64
import gzip
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from importlib.util import find_spec

from hefting import __version__
from hefting.core.errors import MissingDependencyError
from hefting.page.figure import Figure
from hefting.page.html import Markup, element, escape, join
from hefting.page.palette import DARK, LIGHT, style_of

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"
)
"""What the page may do: what stands in it, and nothing that is fetched. Plotly makes
functions of shaders' descriptions, which needs ``unsafe-eval``."""


@dataclass(frozen=True, eq=False)
class Section:
    """A part of a page, with a heading."""

    name: str
    """Of its place in the page, unique"""
    title: str
    content: Markup
    figures: tuple[Figure, ...] = ()
    """Drawn after the content, unless it has their `place`"""


@dataclass(frozen=True, eq=False)
class Heading:
    """What stands at the top of a page."""

    title: str
    lines: tuple[str, ...] = field(default=())


def place(figure: Figure) -> Markup:
    """Where a figure is drawn."""
    kind = "figure solid" if "scene" in figure.layout else "figure"
    height = f"min-height:{figure.height}px"
    return element(
        "div",
        id=f"figure-{figure.name}",
        class_=kind,
        style=height,
        role="img",
        aria_label=figure.about,
    )


def page_of(heading: Heading, sections: Sequence[Section]) -> str:
    """The page, with the library that draws its figures inside.

    Raises `MissingDependencyError` without plotly.
    """
    figures = [figure for section in sections for figure in section.figures]
    links = [element("a", s.title, href=f"#{s.name}") for s in sections]
    body = join(
        (
            element(
                "header",
                element("h1", heading.title),
                *(element("p", line, class_="muted") for line in heading.lines),
                element("nav", *links, aria_label="sections"),
            ),
            element("main", *map(_section, sections)),
            element("footer", f"Made by Hefting {__version__}."),
            *_data(figures),
        )
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{escape(heading.title)}</title><style>{_styles()}</style></head>\n"
        f"<body>{body}\n<script>{_own('report.js')}</script></body></html>\n"
    )


def _section(section: Section) -> Markup:
    drawn = [
        place(figure)
        for figure in section.figures
        if f'id="figure-{figure.name}"' not in section.content
    ]
    return element(
        "section",
        element("h2", section.title),
        section.content,
        *drawn,
        id=section.name,
    )


def _styles() -> str:
    dark = f"@media (prefers-color-scheme: dark){{:root{{{style_of(DARK)}}}}}"
    return f":root{{{style_of(LIGHT)}}}{dark}\n{_own('report.css')}"


def _data(figures: Sequence[Figure]) -> list[Markup]:
    """What the script reads: palettes, figures and the packed library."""
    found = [
        _json("palettes", {"light": LIGHT, "dark": DARK}),
        _json("figures", [vars(figure) for figure in figures]),
    ]
    if figures:
        found.append(
            Markup(f'<script type="text/plain" id="plotly">{_plotly()}</script>')
        )
    return found


def _json(name: str, value: object) -> Markup:
    """Data for the script. No text in it can end the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    text = text.replace("<", "\\u003c").replace("&", "\\u0026")
    return Markup(f'<script type="application/json" id="{name}">{text}</script>')


def require_plotly() -> None:
    """`MissingDependencyError` unless plotly is installed."""
    if find_spec("plotly") is None:
        raise MissingDependencyError("plotly", "view")


@lru_cache(maxsize=1)
def _plotly() -> str:
    """The drawing library, packed to two fifths of its size."""
    require_plotly()
    source = files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(source, mtime=0)).decode()


def _own(name: str) -> str:
    return files("hefting.page").joinpath(name).read_text()
