"""A small picture of a scene, where matplotlib is there."""

import base64
import io

from hefting.core.errors import MissingDependencyError
from hefting.scene import Scene

LARGEST = 100_000
"""Characters of a picture at most."""
RESOLUTIONS = (150, 100, 60)
"""Dots per inch of the shape; the first with which the picture is no larger than
`LARGEST`."""
CARD = "background:#fff;border-radius:4px;padding:4px;max-width:100%;height:auto"
"""Dark ink is drawn on white, whatever the page."""


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
    from hefting.plots.headline import subfigures_of
    from hefting.plots.style import FORMATS, figure_of, settled, style
    from hefting.plots.views import draw_scene, height_of

    with style():
        from matplotlib import rc_context

        with rc_context({"svg.fonttype": "none"}):
            figure = figure_of(height_of(scene))
            (views,) = subfigures_of(figure, 1)
            draw_scene(views, scene)
            for axes in views.axes:
                for each in axes.collections:
                    each.set_rasterized(each.get_zorder() == 0)
            settled(figure)
            content = io.BytesIO()
            figure.savefig(
                content, format="svg", dpi=resolution, metadata=FORMATS[".svg"]
            )
            return content.getvalue()
