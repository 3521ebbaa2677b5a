"""What the site needs besides Sphinx and its extensions: pages made at build, links that
leave the folder, names in code that become links, and formulas without scripts."""

from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer

import figures
from site_parts import docstrings, gallery, links, mathml, pages


def write(app: Any) -> None:
    """Write what is made at build (``builder-inited``)."""
    pages.write(Path(app.srcdir))
    figures.write(Path(app.srcdir) / "drawn")


def setup(app: Any) -> dict[str, Any]:
    """Connect the parts, as Sphinx asks of an extension."""
    docstrings.compile_templates_once()
    app.connect("builder-inited", write)
    app.connect("autodoc-process-docstring", docstrings.prepare, priority=100)
    app.connect("source-read", links.rewrite)
    app.connect("source-read", gallery.without_archives)
    app.add_role("known", links.known)
    app.add_post_transform(links.KnownNames)
    app.connect("missing-reference", links.as_text)
    app.connect("html-page-context", links.without_ways_back)
    app.add_lexer("csv", TextLexer)
    app.add_html_math_renderer(
        "mathml",
        inline_renderers=(mathml.visit_inline, None),
        block_renderers=(mathml.visit_block, None),
    )
    app.config.html_math_renderer_name = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
