"""Display: how results show themselves in a notebook.

Notebooks show pictures, which the results' own packages do not import. The package
itself names the module that makes them.
"""

from importlib import import_module

_makers: list[str] = []


def shown_by(module: str) -> None:
    """Name the module whose ``html_of(value)`` makes the notebook display of a
    value."""
    _makers[:] = [module]


class Shown:
    """Base of results with a notebook display beside their `repr`."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        return import_module(_makers[0]).html_of(self) if _makers else None
