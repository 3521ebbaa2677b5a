"""Estimators: one file a method, one small contract (`hefting.estimators.base`), one
list (`.methods`).

What is in `hefting.estimators.registry` is here, too: with every method, it is imported
where it is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hefting.estimators.registry import *  # noqa: F403


def __getattr__(name: str) -> Any:
    if name.startswith("_"):
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module("hefting.estimators.registry"), name)


def __dir__() -> list[str]:
    return dir(import_module("hefting.estimators.registry"))
