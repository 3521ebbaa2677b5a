"""Accuracy: errors of mass, centre of mass and inertia, as the paper's and a distance on
the manifold of bodies; limits of them, asked for or claimed by a posterior; and a
certificate of how close an estimate is to the optimum of its problem."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.inertia import InertialParameters
from hefting.core.magnitudes import LIGHTEST_OBJECT, SMALLEST_LENGTH
from hefting.core.quantity import quantity
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, tensor_to_vector

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

    def met_by(self, claimed: Accuracy) -> bool:
        """Whether `claimed` is at least as good in all that is asked for."""
        return all(self._share(name, claimed) <= 1.0 for name in NAMES.values())

    def shortfall(self, claimed: Accuracy) -> str:
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

    def _share(self, name: str, claimed: Accuracy) -> float:
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


@dataclass(frozen=True)
class Errors:
    """Errors in percent, and a unitless distance."""

    mass: float
    """|dm| / m [%] (Nadeau et al. 2022, eq. 10)."""
    center_of_mass: float
    """|dc_i| / a_i, mean over the axes [%] (eq. 11)."""
    inertia_at_origin: float
    """Mean over the six entries, tensors about the sensor origin [%] (eq. 12)."""
    inertia_at_com: float
    """The same with each tensor about its own COM [%]."""
    riemannian: float
    """Affine-invariant distance of the pseudo-inertias (Lee & Park 2018); NaN when the
    estimate is no body."""

    def to_dict(self) -> dict[str, float]:
        """By name."""
        return asdict(self)


def errors_between(
    estimate: InertialParameters,
    truth: InertialParameters,
    extents: ArrayLike,
    axes: ArrayLike | None = None,
) -> Errors:
    """Errors of `estimate` against `truth`, both in one frame.

    `extents` (3,) are the sides [m] of the object's bounding box along the columns of
    `axes` (3, 3), the axes of the shape's own file in that frame (identity by default):
    differences are rotated into them first. Raises `InputError` when the extents are
    not positive.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv").estimate.parameters
    >>> errors = hefting.errors_between(found, found, extents=[0.1, 0.3, 0.05])
    >>> errors.mass
    0.0
    """
    a = np.asarray(extents, dtype=float)
    if a.shape != (3,) or not (a >= SMALLEST_LENGTH).all():
        raise InputError(
            f"bounding-box sides must be three positive lengths, not {a.tolist()}"
        )
    R = np.eye(3) if axes is None else np.asarray(axes, dtype=float)
    m = truth.mass
    if not m >= LIGHTEST_OBJECT:
        raise InputError(f"the true mass must be positive, not {m:g}")
    across = (a * a)[[1, 0, 0]] + (a * a)[[2, 2, 1]]  # not (a @ a) - a * a: it rounds
    products = np.outer(a, a) * (1.0 - np.eye(3))
    scale = tensor_to_vector(m / 12.0 * (np.diag(across) - products))

    def inertia_error(difference: np.ndarray) -> float:
        return 100.0 * float(
            np.mean(np.abs(tensor_to_vector(R.T @ difference @ R) / scale))
        )

    return Errors(
        mass=100.0 * abs(estimate.mass - m) / m,
        center_of_mass=100.0
        * float(
            np.mean(np.abs(R.T @ (estimate.center_of_mass - truth.center_of_mass)) / a)
        ),
        inertia_at_origin=inertia_error(
            estimate.inertia_at_origin - truth.inertia_at_origin
        ),
        inertia_at_com=inertia_error(estimate.inertia_at_com - truth.inertia_at_com),
        riemannian=riemannian_distance(estimate, truth),
    )


def riemannian_distance(first: InertialParameters, second: InertialParameters) -> float:
    """sqrt(½ sum of squared logs of the eigenvalues of P1^-1 P2), P the 4 x 4
    pseudo-inertias (Lee & Park 2018).

    Independent of frame and units. NaN unless both pseudo-inertias are positive
    definite.
    """
    P1, P2 = first.pseudo_inertia, second.pseudo_inertia
    if not (P2.diagonal() > 0.0).all():
        return float("nan")
    scale = 1.0 / np.sqrt(np.abs(P2.diagonal()))
    P1, P2 = P1 * np.outer(scale, scale), P2 * np.outer(scale, scale)
    # importing it takes longer than importing NumPy
    from scipy.linalg import eigh  # pyright: ignore[reportUnknownVariableType]

    try:
        values: Array = np.asarray(eigh(P1, P2, eigvals_only=True), dtype=float)
    except (np.linalg.LinAlgError, ValueError):
        return float("nan")
    if not values.min() > 1e-14 * values.max():  # below it is rounding: a flat body
        return float("nan")
    return float(np.sqrt(0.5 * np.sum(np.log(values) ** 2)))
