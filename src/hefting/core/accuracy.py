"""Accuracy: limits of the errors of mass, centre of mass and inertia, asked for or
claimed by a posterior; and a certificate of how close an estimate is to the optimum of
its problem."""

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.inertia import InertialParameters
from hefting.core.quantity import quantity
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array

NAMES = {"mass": "mass", "com": "center_of_mass", "inertia": "inertia"}
"""Names of the three in a text, and their attributes."""


@dataclass(frozen=True)
class Accuracy:
    """Limits of three errors; None for one that does not matter, infinite if open."""

    mass: float | None = None
    """|dm| / m"""
    center_of_mass: float | None = None
    """|dc| [m]"""
    inertia: float | None = None
    """|dJ| / |J|, Frobenius norms of tensors about the COM"""

    def __post_init__(self):
        limits = [limit for limit in asdict(self).values() if limit is not None]
        if not limits or not all(limit > 0.0 for limit in limits):
            what = "an accuracy is one or more positive limits"
            raise InputError(what, fix="as in mass=1%,com=2mm,inertia=20%")

    @classmethod
    def parse(cls, text: str) -> Self:
        """From a text like ``mass=1%,com=2mm,inertia=20%``, with any of the three.
        Raises `InputError`."""
        found: dict[str, Any] = {}
        for part in text.split(","):
            name, equals, value = (word.strip() for word in part.partition("="))
            if name not in NAMES or not equals:
                meant = nearest(name, NAMES) if name not in NAMES else ""
                what = f"'{part.strip()}' is no accuracy{meant}"
                raise InputError(what, fix="as in mass=1%,com=2mm,inertia=20%")
            if NAMES[name] in found:
                raise InputError(f"{name} is given twice in '{text}'")
            try:
                found[NAMES[name]] = quantity(
                    value, "length" if name == "com" else "percentage"
                )
            except InputError as error:
                raise InputError(f"{name}: {error.what}", fix=error.fix) from None
        return cls(**found)

    @classmethod
    def of_draws(cls, draws: Array, body: InertialParameters, level: float) -> Self:
        """Limits that the errors of `body` do not exceed with probability `level`, each
        by itself, if the truth is like `draws` (n, 10); infinite if too many of those
        have no positive mass."""
        if not body.mass > 0.0:  # no COM, and no inertia about it
            return cls(np.inf, np.inf, np.inf)
        m, c, J = draws[:, 0], draws[:, 1:4] / draws[:, :1], _about_com(draws)
        own = _about_com(body.vector[None])
        size = _frobenius(J)
        errors = (
            np.abs(m - body.mass) / m,
            np.linalg.norm(c - body.center_of_mass, axis=1),
            _frobenius(J - own) / np.maximum(size, 1e-300),
        )
        errors = (np.where(m > 0.0, error, np.inf) for error in errors)
        return cls(
            *(
                max(float(np.quantile(error, level, method="higher")), 1e-300)
                for error in errors
            )
        )

    def met_by(self, claimed: "Accuracy") -> bool:
        """Whether `claimed` is at least as good in all that is asked for."""
        return all(self._share(name, claimed) <= 1.0 for name in NAMES.values())

    def shortfall(self, claimed: "Accuracy") -> str:
        """The errors of `claimed` that are too large, in words; empty for none."""
        lacking = [name for name in NAMES.values() if self._share(name, claimed) > 1.0]
        return " and ".join(
            f"the {_WORDS[name]} is {self._lack(name, getattr(claimed, name))}"
            for name in lacking
        )

    def __str__(self) -> str:
        """A readable text, which `parse` takes unless something is open."""
        return ",".join(
            f"{word}={_shown(name, getattr(self, name))}"
            for word, name in NAMES.items()
            if getattr(self, name) is not None
        )

    def _share(self, name: str, claimed: "Accuracy") -> float:
        asked, got = getattr(self, name), getattr(claimed, name)
        if asked is None or np.isinf(asked):
            return 0.0
        return np.inf if got is None else got / asked

    def _lack(self, name: str, got: float | None) -> str:
        wanted = _shown(name, getattr(self, name))
        if got is None or np.isinf(got):
            return f"open, not known to {wanted}"
        known = next(
            (
                text
                for text in (_shown(name, got, n) for n in range(3, 12))
                if text != wanted
            ),
            wanted,
        )
        return f"known to {known}, not {wanted}"


_WORDS = {"mass": "mass", "center_of_mass": "COM", "inertia": "inertia"}
_ENTRIES = np.array((1.0, 2.0, 2.0, 1.0, 2.0, 1.0))


def _shown(name: str, value: float, digits: int = 3) -> str:
    if np.isinf(value):
        return "open"
    if name == "center_of_mass":
        return f"{1e3 * value:.{digits}g}mm"
    return f"{100.0 * value:.{digits}g}%"


def _about_com(vectors: Array) -> Array:
    """(n, 6) inertia about the COM of parameters (n, 10)."""
    m, h = vectors[:, 0], vectors[:, 1:4]
    products = h[:, TENSOR_ROWS] * h[:, TENSOR_COLUMNS] / m[:, None]
    moved = vectors[:, 4:] + products
    moved[:, [0, 3, 5]] -= (products[:, 0] + products[:, 3] + products[:, 5])[:, None]
    return moved


def _frobenius(tensors: Array) -> Array:
    return np.sqrt(np.square(tensors) @ _ENTRIES)


@dataclass(frozen=True)
class Certificate:
    """Evidence, independent of the solver, of how close an estimate is to the optimum
    of its own problem.

    For every admissible answer the objective is at least ``bound``; so ``gap`` =
    objective - bound limits what a perfect solver could still gain.

    Examples
    --------
    >>> hefting.Certificate(objective=2.5, bound=2.25).gap
    0.25
    """

    objective: float
    """Objective at the estimate, computed anew from the data."""
    bound: float
    """Lower bound on the optimum: a dual-feasible value."""
    iterations: int = 0
    """Linear systems solved."""
    converged: bool = True
    """Whether the gap met the solver's own tolerance."""

    @property
    def gap(self) -> float:
        """Objective minus bound, in the objective's units."""
        return self.objective - self.bound
