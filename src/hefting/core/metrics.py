"""How far an estimate is from the truth: the paper's three errors and a distance on the
manifold of bodies."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.magnitudes import LIGHTEST_OBJECT, SMALLEST_LENGTH
from hefting.core.spatial import Array, tensor_to_vector


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
