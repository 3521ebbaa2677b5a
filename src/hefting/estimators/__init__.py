"""Estimators: one file a method, one small contract (`hefting.estimators.base`)."""

from dataclasses import MISSING, Field, fields
from typing import Any

from hefting.core.errors import InputError
from hefting.estimators.base import INVARIANCES, Estimator
from hefting.estimators.bayes import Bayes
from hefting.estimators.geo import GEO
from hefting.estimators.hps import HPS
from hefting.estimators.lmi import LMI
from hefting.estimators.ols import OLS
from hefting.estimators.pmd import PMD
from hefting.estimators.rtls import RTLS

METHODS: dict[str, type[Estimator]] = {
    "Bayes": Bayes,
    "PMD": PMD,
    "GEO": GEO,
    "HPS": HPS,
    "LMI": LMI,
    "OLS": OLS,
    "RTLS": RTLS,
}
"""Every method by its name, those first that use most of what is known."""

VARIANTS: dict[str, tuple[str, dict[str, str]]] = {
    f"{name}-{model}": (name, {"model": model})
    for name, models in (
        ("PMD", ("full", "reduced")),
        ("GEO", ("blended", "reduced")),
        ("OLS", ("blended", "reduced")),
    )
    for model in models
} | {"LMI-ellipsoid": ("LMI", {"ellipsoid": "shape"})}
"""The same with another model of the motion than their own, and LMI with a condition more; what makes them so."""


def spelled(name: str) -> str:
    """Name of a method or variant as `METHODS` and `VARIANTS` spell it. Raises `InputError` for an unknown one."""
    known = {key.lower(): key for key in (*METHODS, *VARIANTS)}
    key = known.get(name.lower()) if isinstance(name, str) else None
    if key is None:
        raise InputError(f"unknown method '{name}'", fix=f"use {', '.join(METHODS)}; see hefting methods")
    return key


def method_named(name: str) -> tuple[type[Estimator], dict[str, Any]]:
    """Estimator of a method or variant, in any case, and the hyperparameters that make it so.

    The hyperparameter ``"shape"`` of a variant stands for the shape that is known. Raises `InputError` for an unknown
    name.
    """
    key = spelled(name)
    base, settings = VARIANTS.get(key, (key, {}))
    return METHODS[base], dict(settings)


def describe_methods() -> dict[str, dict[str, Any]]:
    """What every method does, needs, guarantees and is indifferent to, by name; JSON-ready."""
    return {
        name: {
            "summary": " ".join((kind.__doc__ or "").split("\n\n")[0].split()).rstrip(":;."),
            "needs": kind.needs,
            "consistent": kind.consistent,
            "invariances": [i for i in INVARIANCES if i in kind.invariances],
            "best_for": kind.best_for,
            "source": kind.source,
            "hyperparameters": {f.name: _default(f) for f in fields(kind)},
        }
        for name, kind in METHODS.items()
    }


def _default(field: Field) -> Any:
    if field.default is MISSING:
        return None
    return list(field.default) if isinstance(field.default, tuple) else field.default


__all__ = [
    "GEO",
    "HPS",
    "LMI",
    "METHODS",
    "OLS",
    "PMD",
    "RTLS",
    "VARIANTS",
    "Bayes",
    "Estimator",
    "describe_methods",
    "method_named",
    "spelled",
]
