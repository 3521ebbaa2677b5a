"""Truth: known parameters of an object, and the errors of an estimate of them."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.accuracy import Errors, errors_between
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import SCHEMA
from hefting.core.files import read_json
from hefting.core.inertia import InertialParameters
from hefting.core.magnitudes import LARGEST_PARAMETER, check_magnitude
from hefting.core.spatial import Array, immutable
from hefting.shapes import Shape


@immutable
class Truth:
    """True parameters in the sensor frame, with the bounding box where known."""

    parameters: InertialParameters
    extents: Array | None = None
    """(3,) sides of the bounding box [m] along the columns of `axes`"""
    axes: Array | None = None
    """(3, 3) axes of the shape's own file in the sensor frame"""

    def errors(
        self, estimate: InertialParameters, shape: Shape | None = None
    ) -> Errors:
        """Errors of `estimate`; the bounding box is that of the truth, else that of
        `shape`.

        Raises `InputError` when neither has one.
        """
        extents, axes = self.extents, self.axes
        if extents is None and shape is not None:
            extents, axes = shape.extents, shape.pose[:3, :3]
        if extents is None:
            what = "the errors need the object's size"
            raise InputError(what, fix="give `shape`, or mesh_extents_m in the truth")
        return errors_between(estimate, self.parameters, extents, axes)


TRUTH_KEYS = (
    ("mass",),
    ("center_of_mass", "center_of_mass_sensor"),
    ("inertia_at_com", "inertia_at_com_sensor_axes"),
)
"""Alternative keys of mass, COM and inertia about the COM; the first are those of results."""
TRUTH_INERTIA_AT_ORIGIN = ("inertia_at_origin", "inertia_at_sensor")
"""Keys that may replace those of the inertia about the COM."""
TRUTH_EXAMPLE = (
    'write {"mass": 0.5, "center_of_mass": [0, 0.1, 0.05], "inertia_at_com": '
    "[[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]]}, SI units, in sensor axes"
)


def load_truth(path: str | Path) -> Truth:
    """Truth from a JSON file: another estimate, or an object with the keys

    ``mass`` [kg], ``center_of_mass`` [m], ``inertia_at_com`` or ``inertia_at_origin``
    [kg m²], as results have them, or as simulations do ``center_of_mass_sensor``,
    ``inertia_at_com_sensor_axes`` and ``inertia_at_sensor``; and optionally
    ``mesh_extents_m`` [m] and ``object_pose_in_sensor`` (4 x 4).

    Raises `InputError` when the file cannot be read or a key is missing or malformed.
    """
    data = read_json(path, TRUTH_EXAMPLE)
    if isinstance(data, dict) and data.get("schema") == SCHEMA:
        return Truth(Estimate.load(path).parameters)
    if not isinstance(data, dict):
        raise InputError("is not a JSON object", where=path, fix=TRUTH_EXAMPLE)
    array = partial(_array, data, path)
    parameters, extents, axes = _parameters(data, path), None, None
    if "mesh_extents_m" in data:
        extents = array("mesh_extents_m", 3)
    if "object_pose_in_sensor" in data:
        axes = array("object_pose_in_sensor", 4, 4)[:3, :3]
    return Truth(parameters, extents, axes)


def _parameters(data: dict[str, Any], path: str | Path) -> InertialParameters:
    """The parameters by the first key of each that `data` has."""
    array = partial(_array, data, path)
    mass_key, com_key, inertia_key = (
        next((key for key in keys if key in data), "") for keys in TRUTH_KEYS
    )
    origin_key = next((key for key in TRUTH_INERTIA_AT_ORIGIN if key in data), "")
    found = mass_key, com_key, inertia_key or origin_key
    missing = [
        f"'{keys[0]}'" for keys, key in zip(TRUTH_KEYS, found, strict=True) if not key
    ]
    if missing:
        raise InputError(f"has no {', '.join(missing)}", path, TRUTH_EXAMPLE)
    mass, com = float(array(mass_key)), array(com_key, 3)
    if not mass > 0.0:
        raise InputError(f"'mass' must be positive, not {mass:g}", where=path)
    if origin_key:
        return InertialParameters.from_origin(mass, com, array(origin_key, 3, 3))
    return InertialParameters.from_com(mass, com, array(inertia_key, 3, 3))


def _array(data: dict[str, Any], path: str | Path, key: str, *shape: int) -> Array:
    """The finite numbers under a key, of a shape; `InputError` for anything else."""
    try:
        values = np.array(data[key], dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"'{key}' is not an array of numbers", where=path) from error
    if values.shape != shape or not np.isfinite(values).all():
        size = " x ".join(map(str, shape)) or "one"
        raise InputError(f"'{key}' is not {size} finite number(s)", where=path)
    check_magnitude(values, LARGEST_PARAMETER, f"'{key}'", path)
    return values
