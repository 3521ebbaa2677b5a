"""HTML of few parts: text, tables, lists, a picture, and a block around them.

Styles stand at each element: notebooks that are not trusted leave out style sheets.
Text and lines take the colours of the page, light or dark.
"""

import base64
import io
import re
from collections.abc import Iterable, Sequence
from html import escape

from hefting.core.errors import MissingDependencyError, printable
from hefting.core.messages import Verdict
from hefting.scene import Scene

LONGEST = 400
"""Characters of a text from outside that are shown."""
LINE = "1px solid rgba(128,128,128,0.45)"
CELL = f"padding:2px 8px 2px 0;text-align:left;border-bottom:{LINE};white-space:nowrap"
HEAD = f"{CELL};font-weight:600"
BADGES = {"good": "#1b6e3c", "usable with care": "#8a5a00", "do not use": "#b3261e"}
"""Colour of each verdict: white text on it is readable."""
LARGEST = 100_000
"""Characters of a picture at most."""
RESOLUTIONS = (150, 100, 60)
"""Dots per inch of the shape; the first with which the picture is no larger than
`LARGEST`."""
CARD = "background:#fff;border-radius:4px;padding:4px;max-width:100%;height:auto"
"""Dark ink is drawn on white, whatever the page."""


def text_html(text: str) -> str:
    """A text from outside, cut to `LONGEST`; arguments of the library, which it has in
    backquotes, are set as code."""
    text = printable(" ".join(str(text).split()))
    cut = text if len(text) <= LONGEST else f"{text[: LONGEST - 2]} …"
    return re.sub(r"`(\w+)`", r"<code>\1</code>", escape(cut))


def block(*parts: str) -> str:
    """Parts one below another."""
    style = "font-size:13px;line-height:1.45;max-width:100%"
    return f'<div class="hefting" style="{style}">{"".join(parts)}</div>'


def beside(left: str, right: str) -> str:
    """Two parts side by side, one below the other where the page is narrow."""
    if not right:
        return left
    style = "display:flex;flex-wrap:wrap;gap:12px 28px;align-items:flex-start"
    cell = '<div style="min-width:0;max-width:100%">'
    return f'<div style="{style}">{cell}{left}</div>{cell}{right}</div></div>'


def verdict_html(verdict: Verdict, after: str) -> str:
    """The verdict, what it is of, and its reasons."""
    colour = BADGES[verdict.level]
    badge = f"background:{colour};color:#fff;padding:1px 8px;border-radius:3px"
    line = (
        f'<div style="margin:2px 0 6px"><b style="{badge}">verdict: {verdict}</b> '
        f"{text_html(after)}</div>"
    )
    return line + list_html(verdict.reasons)


def list_html(texts: Iterable[str]) -> str:
    """Texts from outside, one to a line; nothing for none."""
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
    style = (
        "border-collapse:collapse;font-size:12px;font-variant-numeric:tabular-nums;"
        "color:inherit;margin:0 0 8px"
    )
    return (
        f'<div style="overflow-x:auto"><table style="{style}"><thead>'
        f'<tr style="background:none">{top}</tr></thead><tbody>{body}</tbody></table></div>'
    )


def picture_html(scene: Scene, alt: str) -> str:
    """Three views of a scene as an SVG within the page; nothing without matplotlib, and
    where it would be larger than `LARGEST`.

    The SVG is the address of an image: its styles and names then cannot meet those of
    the page, or of another picture.
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
    """The views as SVG; the shape itself as pixels of so many dots per inch."""
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
