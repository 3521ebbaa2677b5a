"""Sphinx: how the site is built. ``make docs`` writes it to docs/_build/html."""

import gc
import sys
from pathlib import Path

gc.set_threshold(1_000_000)  # nearly all nodes stay: a fifth of the time was collecting

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from pygments.lexers.special import TextLexer  # noqa: E402
from sphinx.highlighting import lexers  # noqa: E402

import hefting  # noqa: E402
from site_parts import gallery  # noqa: E402

project = "Hefting"
author = "the Hefting authors"
project_copyright = author
version = release = hefting.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.intersphinx",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_parser",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "site_parts",
]
exclude_patterns = ["_build", "README.md"]

# what a page says
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
smartquotes = False  # -- begins options
default_role = "known"
highlight_language = "none"  # formulas in docstrings; code says its language
lexers["sh"] = TextLexer()  # the shell's would take `hefting export` for its own word
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say types, shapes and units
numpydoc_show_class_members = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = False

# Names of others that pages link to. The inventories are the few lines that are needed,
# kept here, so that a build asks nobody.
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", str(HERE / "inventories" / "python.inv")),
    "numpy": ("https://numpy.org/doc/stable", str(HERE / "inventories" / "numpy.inv")),
    "scipy": (
        "https://docs.scipy.org/doc/scipy",
        str(HERE / "inventories" / "scipy.inv"),
    ),
}

# examples/, run at build: a page each, with what it prints and draws
sphinx_gallery_conf = gallery.settings(HERE)

# how it looks
html_theme = "furo"
html_title = "Hefting"
html_static_path = ["_static"]
html_css_files = ["hefting.css"]
html_copy_source = html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
html_theme_options = {"navigation_with_keys": True}
