"""Display: how results show themselves in a notebook.

What a notebook is shown needs pictures, which the results' own packages know nothing of.
So the package itself names, from above, the module that makes it.
"""

from importlib import import_module

_makers: list[str] = []


def shown_by(module: str) -> None:
    """Name the module whose ``html_of(value)`` makes what a notebook shows of a
    value."""
    _makers[:] = [module]


class Shown:
    """Base of results that a notebook shows as more than their `repr`."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        """HTML for a notebook; None where nothing makes it."""
        return import_module(_makers[0]).html_of(self) if _makers else None
