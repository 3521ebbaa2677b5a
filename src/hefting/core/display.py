"""Display: results show themselves in a notebook, by pictures that the results' own
packages do not import."""

from importlib import import_module


class Shown:
    """Base of results with a notebook display beside their `repr`."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        return import_module("hefting.notebook").html_of(self)
