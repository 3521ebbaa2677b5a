"""Notebook: what estimates, comparisons and shapes show of themselves in Jupyter.

    html_of(hefting.identify("demo/log.csv"))

What is shown is one block without scripts; all its styles are its own, and all text
from outside is escaped.
"""

from hefting.notebook.kinds import KINDS, html_of

__all__ = ["KINDS", "html_of"]
