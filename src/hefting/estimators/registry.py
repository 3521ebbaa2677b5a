"""Registry: every method by its name, and what they are asked for all together."""

from dataclasses import MISSING, Field, dataclass, fields
from typing import Any, cast

from hefting.core.errors import InputError, nearest
from hefting.estimators import methods
from hefting.estimators.base import INVARIANCES
from hefting.estimators.base import Estimator as Estimator
from hefting.estimators.methods import *  # noqa: F403


def _rank(kind: type[Estimator]) -> int:
    return kind.rank


METHODS: dict[str, type[Estimator]] = {
    kind.__name__: kind
    for kind in sorted(
        (kind for kind in vars(methods).values() if isinstance(kind, type)), key=_rank
    )
}
"""Every method by its name, those first that use most of what is known."""

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
"""The same with another model of the motion than their own, then those with a condition
more; what makes them so."""


@dataclass(frozen=True)
class Option:
    """A number that users may give as a hyperparameter."""

    help: str
    """What it means, for each method that says so."""
    metavar: str | None
    """What stands for the number in a usage; None: its name."""


def spelled(name: str) -> str:
    """Name of a method or variant as `METHODS` and `VARIANTS` spell it. Raises
    `InputError` for an unknown one."""
    known = {key.lower(): key for key in (*METHODS, *VARIANTS)}
    key = known.get(name.lower()) if isinstance(name, str) else None
    if key is None:
        raise InputError(
            f"unknown method '{name}'{nearest(str(name), METHODS)}",
            fix=f"use {', '.join(METHODS)}; see hefting methods",
        )
    return key


def method_named(name: str) -> tuple[type[Estimator], dict[str, Any]]:
    """Estimator of a method or variant, in any case, and the hyperparameters that make
    it so.

    The hyperparameter ``"shape"`` of a variant stands for the shape that is known.
    Raises `InputError` for an unknown name.
    """
    key = spelled(name)
    base, settings = VARIANTS.get(key, (key, {}))
    return METHODS[base], dict(settings)


def default_method(shape_known: bool) -> str:
    """Name of the method to use where none is named: the first, or the first that needs
    no shape."""
    return next(
        name for name, kind in METHODS.items() if shape_known or kind.needs == "nothing"
    )


def methods_with(hyperparameter: str) -> list[str]:
    """Names of the methods that have a hyperparameter, in their own model of the
    motion."""
    return [
        name
        for name, kind in METHODS.items()
        if hyperparameter in kind.hyperparameters()
    ]


def options() -> dict[str, Option]:
    """Every number that users may give as a hyperparameter, by its name, in the order
    of the methods."""
    found: dict[str, Option] = {}
    for method, kind in METHODS.items():
        for field in fields(kind):
            if "help" in field.metadata:
                text = f"{method}: {field.metadata['help']}"
                before = found.get(field.name)
                if before is not None:
                    found[field.name] = Option(f"{before.help}; {text}", before.metavar)
                else:
                    found[field.name] = Option(text, field.metadata.get("metavar"))
    return found


def describe_methods() -> dict[str, dict[str, Any]]:
    """What every method does, needs, guarantees and is indifferent to, by name;
    JSON-ready."""
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
