"""Registry of the methods: by name, their variants and their options."""

from dataclasses import MISSING, Field, dataclass, fields
from typing import Any, cast

from hefting.core.errors import InputError, nearest
from hefting.estimators import methods
from hefting.estimators.base import INVARIANCES
from hefting.estimators.base import Estimator as Estimator
from hefting.estimators.methods import *  # noqa: F403

_KINDS: list[type[Estimator]] = [
    kind for kind in vars(methods).values() if isinstance(kind, type)
]
METHODS: dict[str, type[Estimator]] = {
    kind.__name__: kind for kind in sorted(_KINDS, key=lambda kind: kind.rank)
}
"""Every method by its name, in order of rank."""

_VARIANTS: list[tuple[str, str, dict[str, Any]]] = [
    (f"{name}-{ending}", name, dict(settings))
    for name, kind in METHODS.items()
    for ending, settings in kind.variants.items()
]
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    variant: (name, settings)
    for variant, name, settings in sorted(
        _VARIANTS, key=lambda variant: "model" not in variant[2]
    )
}
"""Variants by name: the method and the hyperparameters that make them; other models of
the motion first, then further conditions."""


@dataclass(frozen=True)
class Option:
    """A hyperparameter that users may set to a number."""

    help: str
    """Its meaning, for each method that states one."""
    metavar: str | None
    """Placeholder of the number in a usage message; None for its name."""


def spelled(name: str) -> str:
    """Name of a method or variant in the spelling of `METHODS` and `VARIANTS`, from one
    in any case. Raises `InputError` for an unknown one."""
    known = {key.lower(): key for key in (*METHODS, *VARIANTS)}
    key = known.get(name.lower()) if isinstance(name, str) else None
    if key is None:
        what = f"unknown method '{name}'{nearest(str(name), METHODS)}"
        raise InputError(what, fix=f"use {', '.join(METHODS)}; see hefting methods")
    return key


def method_named(
    name: str | type[Estimator],
) -> tuple[type[Estimator], dict[str, Any]]:
    """Class of a method or variant, named in any case, and the hyperparameters of a
    variant, of which ``"shape"`` stands for the known shape; a class is its own. Raises
    `InputError` for an unknown name."""
    if isinstance(name, type):
        return name, {}
    key = spelled(name)
    base, settings = VARIANTS.get(key, (key, {}))
    return METHODS[base], dict(settings)


def default_method(shape_known: bool) -> str:
    """Name of the default method: the first by rank, or without a shape the first that
    needs none."""
    return next(
        name for name, kind in METHODS.items() if shape_known or kind.needs == "nothing"
    )


def methods_with(hyperparameter: str) -> list[str]:
    """Names of the methods that have a hyperparameter in their default model."""
    return [
        name
        for name, kind in METHODS.items()
        if hyperparameter in kind.hyperparameters()
    ]


def options() -> dict[str, Option]:
    """Every hyperparameter that users may set to a number, by name, as methods rank."""
    found: dict[str, Option] = {}
    for method, kind in METHODS.items():
        for field in fields(kind):
            if "help" in field.metadata:
                text = f"{method}: {field.metadata['help']}"
                if (before := found.get(field.name)) is None:
                    found[field.name] = Option(text, field.metadata.get("metavar"))
                else:
                    found[field.name] = Option(f"{before.help}; {text}", before.metavar)
    return found


def settings_text(provenance: dict[str, Any]) -> str:
    """``"name = value"`` of numbers that users set, from an estimate's provenance."""
    numbers = {name: provenance.get(name) for name in ("points", *options())}
    return ", ".join(
        f"{name} = {value:g}"
        for name, value in numbers.items()
        if isinstance(value, float | int)
    )


def describe_methods() -> dict[str, dict[str, Any]]:
    """JSON-ready description of every method by name."""
    return {
        name: {
            "summary": " ".join((kind.__doc__ or "").split("\n\n")[0].split()).rstrip(
                ":;."
            ),
            "needs": kind.needs,
            "consistent": kind.consistent,
            "invariances": [i for i in INVARIANCES if i in kind.invariances],
            "best_for": kind.best_for,
            "source": kind.source,
            "hyperparameters": {f.name: _default(f) for f in fields(kind)},
        }
        for name, kind in METHODS.items()
    }


def _default(field: Field[Any]) -> Any:
    default: Any = field.default
    if default is MISSING:
        return None
    return (
        list(cast(tuple[Any, ...], default)) if isinstance(default, tuple) else default
    )
