"""Newton-Euler regressors: the wrench as a linear map of the ten inertial parameters.

Both models are linear in the 22 *features* of a sample,

    x = [a - g (3), alpha (3), vech(w w') (6), g (3), f (3), tau (3), 1],

because [w]x [w]x = w w' - |w|² I and w x (J w) are linear in w w'. With d = a - g and W
= [w]x,

    full:     f = m d + ([alpha]x + W W) m c,   tau = (m c) x d + L(alpha) J + W L(w) J
    reduced:  the same with a = w = alpha = 0 (gravity only; Nadeau et al. 2022, eq. 7)

where L(v) (Jxx..Jzz) = J v. See Atkeson, An & Hollerbach 1986 for the full model.
"""

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.spatial import (
    CHUNK,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Array,
    skew,
    vector_to_tensor,
)

MOTION = slice(0, 12)
"""Features the full model is built from."""
GRAVITY = slice(12, 15)
WRENCH = slice(15, 21)
ONE = 21
FEATURES = 22

_ONES = np.ones(3)


def _full_map() -> Array:
    """Constant (12, 6, 10): regressor of each unit motion feature."""
    tensor_basis = vector_to_tensor(np.eye(6))  # (6, 3, 3)
    unit = np.eye(3)
    full = np.zeros((12, 6, 10))
    full[0:3, 0:3, 0] = unit
    full[0:3, 3:6, 1:4] = -skew(unit)
    full[3:6, 0:3, 1:4] = skew(unit)
    full[3:6, 3:6, 4:10] = np.einsum("sij,aj->ais", tensor_basis, unit)
    # a symmetric S in the place of w w': force S - tr(S) I, torque eps_ijk S_jl J_kl
    full[6:12, 0:3, 1:4] = (
        tensor_basis - np.einsum("sii->s", tensor_basis)[:, None, None] * unit
    )
    levi_civita = -skew(unit)  # levi_civita[i, j, k] = eps_ijk
    full[6:12, 3:6, 4:10] = np.einsum(
        "ijk,tjl,skl->tis", levi_civita, tensor_basis, tensor_basis
    )
    return full


FULL_MAP = _full_map().reshape(12, 60)
"""(12, 60): motion features to the 6 x 10 full regressor, row by row."""
REDUCED_MAP = np.ascontiguousarray(-_full_map()[:3].reshape(3, 60))
"""(3, 60): gravity to the 6 x 10 reduced regressor."""


def features(measurements: Measurements) -> Array:
    """Features (K, 22) of K samples, column-major, scaled by the root of the weight."""
    z = measurements
    x = np.empty((len(z), FEATURES), order="F")
    _write_motion(z, x)
    x[:, GRAVITY] = z.gravity
    x[:, 15:18] = z.force
    x[:, 18:21] = z.torque
    x[:, ONE] = 1.0
    if z.weights is not None:
        x *= np.sqrt(z.weights)[:, None]
    return x


def motion_features(measurements: Measurements) -> Array:
    """The first twelve features (K, 12), of the motion alone, without weights."""
    x = np.empty((len(measurements), 12), order="F")
    _write_motion(measurements, x)
    return x


def _write_motion(z: Measurements, x: Array) -> None:
    np.subtract(z.linear_acceleration, z.gravity, out=x[:, 0:3])
    x[:, 3:6] = z.angular_acceleration
    w = z.angular_velocity.T
    np.multiply(w.take(TENSOR_ROWS, 0), w.take(TENSOR_COLUMNS, 0), out=x[:, 6:12].T)


def full_rows(x: Array) -> Array:
    """Full regressors (K, 6, 10) of (virtual) samples' features (K, 22)."""
    return (x[:, MOTION] @ FULL_MAP).reshape(-1, 6, 10)


def reduced_rows(x: Array) -> Array:
    """Reduced regressors (K, 6, 10) of (virtual) samples' features (K, 22); the inertia
    columns are zero."""
    return (x[:, GRAVITY] @ REDUCED_MAP).reshape(-1, 6, 10)


def full_regressor(measurements: Measurements) -> Array:
    """Full Newton-Euler regressors (K, 6, 10): wrench = regressor @ parameters."""
    return full_rows(features(measurements))


def reduced_regressor(measurements: Measurements) -> Array:
    """Gravity-only regressors (K, 6, 10) (Nadeau et al. 2022, eq. 7 and force rows)."""
    return reduced_rows(features(measurements))


def dynamism(measurements: Measurements) -> Array:
    """Dynamism nu (K,) = |a|² + |alpha|² + (|w| / 0.5)² (Nadeau et al. 2022, eq. 4, n1
    = n2 = 1, n3 = 0.5)."""
    a = measurements.linear_acceleration
    alpha = measurements.angular_acceleration
    w = measurements.angular_velocity
    # quicker than a reduction
    return (a * a + alpha * alpha + 4.0 * (w * w)).dot(_ONES)


def full_model_weight(measurements: Measurements, c1: float) -> Array:
    """Weight w (K,) = tanh(3 nu / c1) of the full model against the reduced (Nadeau et
    al. 2022, eq. 9)."""
    return np.tanh((3.0 / c1) * dynamism(measurements))


def predict_wrench(measurements: Measurements, vector: Array) -> Array:
    """Wrench (K, 6) [N, N m] that a body with the ten parameters `vector` needs for the
    measured motion."""
    z = measurements
    effect = FULL_MAP.reshape(-1, 10) @ np.asarray(vector, dtype=float)
    wrench = np.empty((len(z), 6))
    for first in range(0, len(z), CHUNK):
        part = slice(first, first + CHUNK)
        # (12, 6): each feature's effect on the wrench
        wrench[part] = motion_features(z[part]) @ effect.reshape(12, 6)
    return wrench
