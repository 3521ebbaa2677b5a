"""Conventions of the whole project, and the frame changes that follow from them.

Fixed here and nowhere else:

- SI units; right-handed frames ``world``, ``sensor`` (the force-torque sensor) and
  ``object`` (the frame of the shape's file). A pose ``pose_object_in_sensor`` is the 4
  x 4 matrix that takes object coordinates to sensor coordinates.
- Quaternions are x, y, z, w; q and -q are the same rotation.
- A wrench is force, then torque, **exerted by the sensor on the object**, in sensor
  axes, about the sensor origin. A sensor that reports what the object exerts on it
  ("on-sensor") has the opposite sign.
- Gravity is a vector in world axes, by default (0, 0, -9.80665) m/s².
- Acceleration is classical: the second derivative of the sensor origin's position.
- Inertial parameters are taken about the sensor origin, in sensor axes, in the order of
  `PARAMETERS`; products of inertia are those of the tensor: Jxy = -∫ x y dm.
"""

from dataclasses import dataclass, field
from typing import Any, TypeVar, dataclass_transform

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hefting.core.errors import InputError
from hefting.core.magnitudes import (
    LARGEST_DISTANCE,
    LARGEST_GRAVITY,
    SMALLEST_GRAVITY,
    check_magnitude,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Scalar = TypeVar("Scalar", bound=np.generic)

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Default gravity in world axes [m/s²]."""

SPEED_LIMIT = 0.25
"""Largest speed of the tool centre point [m/s] near people, by ISO 10218-1 (2011)."""

PARAMETERS = ("m", "mcx", "mcy", "mcz", "Jxx", "Jxy", "Jxz", "Jyy", "Jyz", "Jzz")
"""Order of the ten inertial parameters [kg, kg m (3), kg m² (6)]."""

TENSOR_ROWS = np.array([0, 0, 0, 1, 1, 2])
TENSOR_COLUMNS = np.array([0, 1, 2, 1, 2, 2])
"""Row and column of each of the six tensor entries xx, xy, xz, yy, yz, zz."""
TENSOR_ENTRIES = np.array([0, 1, 2, 1, 3, 4, 2, 4, 5])
"""Which of these six stands in each place of the tensor, row by row."""

STEINER: Array = np.array(
    [
        (a == b) * np.eye(3) - 0.5 * (np.outer(e_a, e_b) + np.outer(e_b, e_a))
        for a, b in zip(TENSOR_ROWS, TENSOR_COLUMNS, strict=True)
        for e_a, e_b in [np.eye(3)[[a, b]]]
    ]
)
"""(6, 3, 3): h' STEINER[s] h is entry s of the tensor |h|² I - h h'."""

WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Order of a wrench's components [N (3), N m (3)]."""


CHUNK = 65_536
"""Number of samples processed at a time, to bound the memory."""


T = TypeVar("T")


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def immutable(cls: type[T]) -> type[T]:
    """A dataclass that holds arrays and is never changed: it compares by identity, as
    arrays have no single answer, and no type checker lets its fields be set.

    ``dataclass(frozen=True, eq=False)`` makes four functions a class, this one, in a
    third of the time. What users are handed is frozen at run time, too.
    """
    return dataclass(eq=False, repr=False)(cls)


def frozen(values: ArrayLike, dimensions: int = 0) -> Array:
    """`values` as a read-only contiguous float array of at least `dimensions`
    dimensions: a copy unless they are one."""
    if (
        type(values) is np.ndarray
        and values.dtype == float
        and values.ndim >= dimensions
        and is_immutable(values)
    ):
        return values
    try:
        array = np.array(values, dtype=float, order="C", ndmin=dimensions)
    except (TypeError, ValueError) as error:
        raise InputError(f"these are not numbers in an array ({error})") from error
    array.setflags(write=False)
    return array


def freeze(value: object, *names: str) -> None:
    """Make attributes of a frozen dataclass read-only arrays, except None."""
    for name in names:
        given = getattr(value, name)
        if given is not None:
            object.__setattr__(value, name, frozen(given))


def own(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """`array`, to which nothing else refers, made read-only without a copy."""
    array.setflags(write=False)
    return array


def is_immutable(array: NDArray[Any]) -> bool:
    """Whether nothing can write to a C-contiguous array or what it is a view of."""
    flags, base = array.flags, array.base
    if flags.writeable or not flags.c_contiguous:
        return False
    return base is None or (isinstance(base, np.ndarray) and not base.flags.writeable)


def changed_rows(values: NDArray[Any]) -> Mask:
    """(K,) whether each row (K, d) differs from the one before; True for the first."""
    changed = np.ones(len(values), dtype=bool)
    changed[1:] = values[1:, 0] != values[:-1, 0]  # decides most of them
    same = np.flatnonzero(~changed)
    changed[same] = (values[same] != values[same - 1]).any(axis=1)
    return changed


def runs_of(mask: Mask) -> list[tuple[int, int]]:
    """(first sample, sample after the last) of each run of True in a mask (K,)."""
    edges = np.flatnonzero(np.diff(mask.astype(int), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def interpolated(at: Array, time: Array, values: NDArray[Any]) -> Array:
    """(L, d) values (K, d) at increasing `time` (K,), linearly interpolated at times
    (L,); the first and last value outside."""
    columns: list[Array] = [np.interp(at, time, column) for column in values.T]
    return np.column_stack(columns)


def angle_between(one: Array, other: Array) -> float:
    """Angle [rad] between two vectors (3,), exact where it is small, too."""
    return float(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


def median(values: NDArray[Any]) -> float:
    """Median of finite numbers; NaN for none. `numpy.median` takes five times as long
    for a few numbers, and imports `numpy.ma`."""
    return float(column_medians(np.ravel(values)))


def column_medians(values: NDArray[Any]) -> Array:
    """Medians (...) of finite numbers (N, ...) along the first axis, as `median`."""
    if not len(values):
        return np.full(values.shape[1:], np.nan)
    half = len(values) // 2
    # for one place it takes forty times as long where few values differ
    ordered = np.partition(values, (max(half - 1, 0), half), axis=0)
    return 0.5 * ordered[half - 1 + len(values) % 2] + 0.5 * ordered[half]


def quantile(values: Array, share: float) -> float:
    """The number below which a `share` of some finite numbers (N,) are, as
    `numpy.quantile`, which imports `numpy.ma`."""
    place = share * (len(values) - 1)
    low = int(place)
    high = min(low + 1, len(values) - 1)
    ordered = np.partition(values, (low, high))
    return float(ordered[low] + (place - low) * (ordered[high] - ordered[low]))


def distinct(values: ArrayLike) -> Array:
    """Different numbers, sorted, as `numpy.unique`, which imports `numpy.ma`."""
    ordered = np.sort(np.asarray(values, dtype=float), axis=None)
    return ordered[np.diff(ordered, prepend=np.nan) != 0.0]


def check_gravity(gravity: ArrayLike) -> Array:
    """Gravity (3,) in world axes [m/s²] read-only; `InputError` for anything else."""
    g = frozen(gravity)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        what = f"gravity must be three numbers, not all zero, and is {g.tolist()}"
        raise InputError(what, fix="give `gravity` X,Y,Z in m/s²")
    if not SMALLEST_GRAVITY <= np.abs(g).max() <= LARGEST_GRAVITY:
        what = f"gravity of {np.abs(g).max():.3g} m/s² cannot be"
        raise InputError(what, fix="give `gravity` X,Y,Z in m/s²")
    return g


def skew(vector: ArrayLike) -> Array:
    """Cross-product matrices: vectors (..., 3) to matrices (..., 3, 3) with ``skew(u) @
    v == cross(u, v)``."""
    v = np.asarray(vector, dtype=float)
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1] = -v[..., 2]
    matrix[..., 0, 2] = v[..., 1]
    matrix[..., 1, 2] = -v[..., 0]
    matrix[..., 1, 0] = v[..., 2]
    matrix[..., 2, 0] = -v[..., 1]
    matrix[..., 2, 1] = v[..., 0]
    return matrix


def cross(u: Array, v: Array) -> Array:
    """Cross products (3, ...) of vectors (3, ...): faster than `numpy.cross`, and for
    vectors whose components come first."""
    ahead, behind = (1, 2, 0), (2, 0, 1)
    return u.take(ahead, 0) * v.take(behind, 0) - u.take(behind, 0) * v.take(ahead, 0)


def tensor_to_vector(tensor: ArrayLike) -> Array:
    """Symmetric matrices (..., 3, 3) to entries xx, xy, xz, yy, yz, zz (..., 6)."""
    return np.asarray(tensor, dtype=float)[..., TENSOR_ROWS, TENSOR_COLUMNS]


def vector_to_tensor(vector: ArrayLike) -> Array:
    """Entries xx, xy, xz, yy, yz, zz (..., 6) to symmetric matrices (..., 3, 3)."""
    v = np.asarray(vector, dtype=float)
    return v[..., TENSOR_ENTRIES].reshape(*v.shape[:-1], 3, 3)


def rotation_matrices(quaternions: ArrayLike) -> Array:
    """Rotation matrices (K, 3, 3) of unit quaternions (K, 4) x, y, z, w: sensor axes to
    world axes."""
    q = np.asarray(quaternions, dtype=float)
    x, y, z, w = (q[..., i] for i in range(4))
    twice_x, twice_y, twice_z = 2.0 * x, 2.0 * y, 2.0 * z
    xx, yy, zz = x * twice_x, y * twice_y, z * twice_z
    xy, yz, zx = x * twice_y, y * twice_z, z * twice_x
    xw, yw, zw = w * twice_x, w * twice_y, w * twice_z
    rows = np.array(
        (
            (1.0 - (yy + zz), xy - zw, zx + yw),
            (xy + zw, 1.0 - (xx + zz), yz - xw),
            (zx - yw, yz + xw, 1.0 - (xx + yy)),
        )
    )
    return rows.transpose(*range(2, rows.ndim), 0, 1)


def lengths(vectors: Array) -> Array:
    """(...,) lengths of vectors (..., n), ten times as fast as `numpy.linalg.norm`."""
    return np.sqrt(np.square(vectors) @ np.ones(vectors.shape[-1]))


def squared_lengths(wrenches: Array) -> Array:
    """(..., 2) squared lengths of force and torque of wrenches (..., 6)."""
    squares = np.square(wrenches)
    lengths = squares[..., 0::3] + squares[..., 1::3]
    lengths += squares[..., 2::3]
    return lengths


def rotation_by(vector: ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad]."""
    v = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(v))
    half = 0.5 * float(np.sinc(0.5 * angle / np.pi))  # sin(angle / 2) / angle
    return rotation_matrices(np.append(half * v, np.cos(0.5 * angle)))


def quaternion_of(rotation: ArrayLike) -> Array:
    """Unit quaternion (4,) x, y, z, w of a rotation matrix (3, 3), w not negative.

    The largest column of 4 q q', whose entries are linear in those of the matrix
    (Shepperd, J. Guidance and Control 1, 1978).
    """
    R = np.asarray(rotation, dtype=float)
    difference = (R - R.T)[(2, 0, 1), (1, 2, 0)]
    square = np.empty((4, 4))
    square[:3, :3] = R + R.T + (1.0 - np.trace(R)) * np.eye(3)
    square[:3, 3] = square[3, :3] = difference
    square[3, 3] = 1.0 + np.trace(R)
    q = square[np.argmax(square.diagonal())]
    return q / np.linalg.norm(q) * (-1.0 if q[3] < 0.0 else 1.0)


def rotation_vector(rotation: ArrayLike) -> Array:
    """Rotation vector (3,) [rad] of a rotation matrix (3, 3), half a turn at most."""
    q = quaternion_of(rotation)
    sine = float(np.linalg.norm(q[:3]))
    return q[:3] * (2.0 * np.arctan2(sine, q[3]) / sine if sine > 0.0 else 2.0)


def in_sensor_axes(orientation: Array, vectors: ArrayLike) -> Array:
    """Vectors in world axes, (3,) or (K, 3), in the axes (K, 3) of sensors of
    orientation (K, 4) xyzw."""
    world = np.broadcast_to(np.asarray(vectors, dtype=float), (len(orientation), 3))
    out = np.empty((len(orientation), 3))
    for first in range(0, len(out), CHUNK):
        part = slice(first, first + CHUNK)
        np.einsum(
            "kji,kj->ki",
            rotation_matrices(orientation[part]),
            world[part],
            out=out[part],
        )
    return out


def pose_matrix(seven_numbers: ArrayLike) -> Array:
    """Pose (4, 4) from x, y, z [m] and a quaternion x, y, z, w.

    Raises `InputError` unless there are seven finite numbers whose quaternion has unit
    norm within 1e-3.
    """
    numbers = np.asarray(seven_numbers, dtype=float)
    if numbers.shape != (7,) or not np.isfinite(numbers).all():
        raise InputError("a pose is seven finite numbers x,y,z,qx,qy,qz,qw")
    norm = np.linalg.norm(np.clip(numbers[3:], -1e3, 1e3))
    if abs(norm - 1) > 1e-3:
        what = f"pose quaternion has norm {norm:.4g}, not 1"
        raise InputError(what, fix="give x,y,z,qx,qy,qz,qw (w last)")
    check_magnitude(numbers[:3], LARGEST_DISTANCE, "a distance [m]")
    pose = np.eye(4)
    pose[:3, :3] = rotation_matrices(numbers[3:] / norm)
    pose[:3, 3] = numbers[:3]
    return pose


def plain(values: Any) -> Any:
    """Rotations or rigid motions of scipy, or a list of them, as matrices; else the
    values."""
    if type(values) in (list, tuple) and hasattr(next(iter(values), None), "as_matrix"):
        return [value.as_matrix() for value in values]
    return values.as_matrix() if hasattr(values, "as_matrix") else values


def check_pose(pose: ArrayLike) -> Array:
    """`pose` as a (4, 4) float array; `InputError` unless it is a proper rigid motion
    within 1e-3. One that is off by more than 1e-6, as written with few digits, becomes
    the nearest."""
    try:
        matrix = np.asarray(pose, dtype=float)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise InputError("a pose is a finite 4 x 4 matrix")
    check_magnitude(matrix, LARGEST_DISTANCE, "a number in the pose matrix")
    rotation = matrix[:3, :3]
    off = np.abs(rotation @ rotation.T - np.eye(3)).max()
    proper = off < 1e-3 and np.linalg.det(rotation) > 0
    end = (0, 0, 0, 1)
    if proper and np.allclose(matrix[:, 3], end) and not np.allclose(matrix[3], end):
        what = "the pose matrix has its translation in the last row"
        raise InputError(what, fix="transpose it: its last row is 0, 0, 0, 1")
    if not proper or not np.allclose(matrix[3], end):
        raise InputError("the pose matrix is not a proper rotation with a translation")
    if off > 1e-6:
        left, _, right = np.linalg.svd(rotation)
        matrix = matrix.copy()
        matrix[:3, :3] = left @ right
    return matrix


def inverse_pose(pose: ArrayLike) -> Array:
    """Inverse (4, 4) of a rigid motion (4, 4)."""
    matrix = np.asarray(pose, dtype=float)
    inverse = np.eye(4)
    inverse[:3, :3] = matrix[:3, :3].T
    inverse[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return inverse


def move_wrench(
    pose_old_in_new: ArrayLike, force: ArrayLike, torque: ArrayLike
) -> tuple[Array, Array]:
    """Force and torque (..., 3) given in an old frame, in the axes and about the origin
    of a new one."""
    pose = np.asarray(pose_old_in_new, dtype=float)
    new_force = np.asarray(force, dtype=float) @ pose[:3, :3].T
    return new_force, np.asarray(torque, dtype=float) @ pose[:3, :3].T + np.cross(
        pose[:3, 3], new_force
    )


def move_motion(
    pose_old_in_new: ArrayLike,
    acceleration: ArrayLike,
    velocity: ArrayLike,
    angular_acceleration: ArrayLike,
) -> tuple[Array, Array, Array]:
    """Rigid-body motion (..., 3) seen from another frame fixed to the same body.

    `acceleration` [m/s²] is the classical acceleration of the old origin, `velocity`
    [rad/s] the angular velocity; returned are acceleration of the new origin, angular
    velocity and angular acceleration, in new axes.
    """
    pose = np.asarray(pose_old_in_new, dtype=float)
    a, w, alpha = (
        np.asarray(v, dtype=float) @ pose[:3, :3].T
        for v in (acceleration, velocity, angular_acceleration)
    )
    offset = -pose[:3, 3]  # from the old origin to the new one, in new axes
    return a + np.cross(alpha, offset) + np.cross(w, np.cross(w, offset)), w, alpha
