"""All parties that are installed."""

from importlib import import_module
from importlib.util import find_spec

from benchmarks.against.party import Party

MODULES = {
    "benchmarks.against.ours": (),
    "benchmarks.against.regressor": ("pinocchio",),
    "benchmarks.against.conic": ("cvxpy", "clarabel"),
    "benchmarks.against.sysid": (
        "mujoco",
        "absl",
        "colorama",
        "imageio",
        "jinja2",
        "matplotlib",
        "plotly",
        "tabulate",
        "yaml",
    ),
}
"""Where parties are made, and what those need."""


def parties() -> list[Party]:
    """Of all modules whose packages are here."""
    return [
        party
        for module, needed in MODULES.items()
        if not missing(needed)
        for party in import_module(module).parties()
    ]


def missing(needed: tuple[str, ...]) -> list[str]:
    """Packages that are not installed."""
    return [name for name in needed if find_spec(name) is None]


def absent() -> list[str]:
    """Why parties are left out, a line each."""
    return [
        f"{module.rpartition('.')[2]} is left out: {', '.join(lacking)} not installed"
        for module, needed in MODULES.items()
        if (lacking := missing(needed))
    ]
