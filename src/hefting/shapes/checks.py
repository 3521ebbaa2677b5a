"""Checks of what shapes are made of: units, numbers and arrays, and what is suspicious
about a size."""

from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.magnitudes import SMALLEST_LENGTH
from hefting.core.messages import Message, warning
from hefting.core.spatial import Array, frozen, inverse_pose
from hefting.shapes.sampling import MAX_POINTS

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
"""Length units [m] of a shape's file."""


def arrays_of(source: Any) -> tuple[Array, np.ndarray] | None:
    """Vertices and faces of an object that has both (a trimesh or Open3D-like mesh),
    else None."""
    vertices, faces = getattr(source, "vertices", None), getattr(source, "faces", None)
    if vertices is None or faces is None:
        return None
    return np.asarray(vertices, dtype=float), np.asarray(faces, dtype=np.int64)


def unit_scale(unit: str | None) -> float:
    """Metres per `unit`."""
    if unit is None:
        return 1.0
    if unit not in UNITS:
        raise InputError(
            f"unknown unit '{unit}'{nearest(str(unit), UNITS)}",
            fix=f"use one of {', '.join(UNITS)}",
        )
    return UNITS[unit]


def positive(value: float, name: str) -> float:
    """`value` if it is a positive number, else `InputError`."""
    if not (np.isfinite(value) and value > 0):
        raise InputError(f"{name} must be positive, not {value}")
    return float(value)


def point_count(points: int) -> int:
    """`points` if it is a sensible number of points, else `InputError`."""
    if not isinstance(points, int | np.integer) or not 1 <= points <= MAX_POINTS:
        raise InputError(
            f"the number of points must be 1 to {MAX_POINTS}, not {points!r}"
        )
    return int(points)


def point_array(points: Any, where: Any = None) -> Array:
    """`points` as a finite array (n, 3), else `InputError`."""
    try:
        p = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a point cloud is an array (n, 3) of numbers", where
        ) from error
    if p.ndim != 2 or p.shape[1] != 3 or len(p) == 0:
        raise InputError(f"a point cloud is an array (n, 3), not {p.shape}", where)
    if not np.isfinite(p).all() or np.abs(p).max() > 1e9:
        raise InputError(
            "the point cloud has values that are not finite",
            where,
            "remove those points",
        )
    longest = float(np.ptp(p, axis=0).max())
    if 0.0 < longest < SMALLEST_LENGTH:
        raise InputError(
            f"the point cloud is only {longest:.3g} long", where, "check its numbers"
        )
    return p


def check_positions(positions: Array) -> None:
    """`InputError` unless `positions` of point masses are an array (n, 3), n > 0."""
    if positions.ndim != 2 or positions.shape[1] != 3 or len(positions) == 0:
        raise InputError(f"point masses are an array (n, 3), not {positions.shape}")


def checked_numbers(
    values: Any, name: str, shape: tuple[int, ...], count: int
) -> Array | None:
    """`values` of `count` point masses as a finite array of that shape, else
    `InputError`; None stays None."""
    if values is None:
        return None
    values = frozen(values)
    if values.shape != shape:
        raise InputError(
            f"{name} of {count} point masses has shape {values.shape}, not {shape}"
        )
    if not np.isfinite(values).all():
        raise InputError(f"{name} of point masses is not finite")
    return values


def shares_of(volumes: Array | None) -> Array | None:
    """`volumes` of point masses over their sum, `InputError` for negative ones; None
    stays None."""
    if volumes is None:
        return None
    if volumes.min() < 0 or volumes.sum() <= 0:
        raise InputError("volumes of point masses are negative or all zero")
    return frozen(volumes / volumes.sum())


def checked_labels(labels: Any, count: int) -> np.ndarray | None:
    """`labels` of `count` point masses as whole numbers (n,), else `InputError`; None
    stays None."""
    if labels is None:
        return None
    labels = np.array(labels, dtype=np.int64)
    labels.setflags(write=False)
    if labels.shape != (count,):
        raise InputError(f"labels of {count} point masses have shape {labels.shape}")
    return labels


def check_hull(hull: Array) -> None:
    """`InputError` unless the `hull` of point masses is a finite array (V, 3)."""
    if hull.ndim != 2 or hull.shape[1:] != (3,) or not np.isfinite(hull).all():
        raise InputError(
            f"the hull of point masses is a finite array (V, 3), not {hull.shape}"
        )


def suspicions(
    low: Array, extents: Array, pose: Array, unit: str | None
) -> tuple[Message, ...]:
    """Warnings about a bounding box (lower corner and sides in object axes) unlikely
    for a held object."""
    longest, found = float(extents.max()), []
    if longest > 3:
        what = f"the shape is {longest:.3g} m long: is its file in millimetres? pass `unit`='mm'"
        found.append(warning("shape-long", what, "unit"))
    if longest < 1e-3:
        what = f"the shape is only {longest * 1e3:.3g} mm long: is `unit`='{unit or 'm'}' too small?"
        found.append(warning("shape-small", what, "unit"))
    origin = inverse_pose(pose)[:3, 3]
    distance = float(np.linalg.norm(origin - np.clip(origin, low, low + extents)))
    if distance > 1 or (distance > 0.3 and distance > 5 * np.linalg.norm(extents)):
        what = f"the shape is {distance:.3g} m away from the sensor: check the unit and pose of the object"
        found.append(warning("shape-far", what, "pose"))
    return tuple(found)


def check_parts(labels: Array, volumes: Array | None, path: str | Path) -> None:
    """Raise `InputError` unless labels (n,) are integers and volumes (n,) usable."""
    if not (np.abs(labels) < 2**31).all() or (labels != np.round(labels)).any():
        raise InputError("labels of parts are whole numbers", path)
    if volumes is not None and (
        not np.isfinite(volumes).all() or volumes.min() < 0 or volumes.sum() <= 0
    ):
        raise InputError("volumes of parts must be positive numbers", path)
