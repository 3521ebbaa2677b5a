"""The wrench is in the axes of the robot's base, as some controllers state the force at
the tool, not in those of the sensor."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Rows, beside_body
from hefting.ingest.rivals.explanation import Explanation, Undone, over_offsets

CODE = "wrench-in-base-axes"
WHAT = "the wrench seems to be in the axes of the robot's base"
FIX = (
    'log it in sensor axes, or say axes = "world" of the wrench in a column map, '
    "of a bag after hefting convert to CSV"
)
ABOUT_BASE = ", with its torque about the base's origin"
FIX_ABOUT_BASE = "log it in sensor axes about the sensor's origin"


def explain(case: Case) -> Explanation | None:
    """The wrench turned into sensor axes, with a constant bias in both."""
    fitted, _ = over_offsets(case, lambda motion: _rows(case, motion, case.wrench))
    what = WHAT
    fix = FIX
    if case.recording.has("position"):
        about = _about_sensor(case, case.time, case.wrench)
        other, _ = over_offsets(case, lambda motion: _rows(case, motion, about))
        if other.likelihood.max() > fitted.likelihood.max():
            fitted, what, fix = other, WHAT + ABOUT_BASE, FIX_ABOUT_BASE
    return Explanation(CODE, what, fix, fitted, 0, argument="column_map")


def undone(case: Case) -> Iterator[Undone]:
    """The wrench in sensor axes, with its torque as logged or about the sensor's
    origin."""
    first_time, first = case.consecutive
    axes = case.motion_as_found.axes[0]
    first_axes = case.motion_at(first_time[None] - case.offset).axes[0]
    changed = [(WHAT, FIX, case.wrench, first)]
    if case.recording.has("position"):
        about = _about_sensor(case, case.time, case.wrench)
        first_about = _about_sensor(case, first_time, first)
        changed.append((WHAT + ABOUT_BASE, FIX_ABOUT_BASE, about, first_about))
    for what, fix, wrench, consecutive in changed:
        other = replace(
            case,
            wrench=_turned(axes, wrench),
            consecutive=(first_time, _turned(first_axes, consecutive)),
        )
        yield Undone(CODE, what, fix, other, argument="column_map")


def _turned(axes: Array, wrench: Array) -> Array:
    """A wrench (K, 6) in axes (K, 3, 3) that differ at each time."""
    return np.einsum("kij,kpj->kpi", axes, wrench.reshape(-1, 2, 3)).reshape(-1, 6)


def _about_sensor(case: Case, time: Array, wrench: Array) -> Array:
    """(K, 6) wrench at times (K,) [s] with its torque, which is about the world's
    origin, about the sensor's."""
    place = case.places(time - case.offset)
    force, torque = np.split(wrench, 2, axis=1)
    return np.hstack((force, torque - np.cross(place, force)))


def _rows(case: Case, motion: Motion, recorded: Array) -> Rows:
    axes = motion.axes
    wrench = np.einsum("okij,kpj->okpi", axes, recorded.reshape(-1, 2, 3))
    O, K = motion.known.shape
    known, maps = case.features(motion), REGRESSOR_BY_FEATURE
    if case.biased:
        known = np.concatenate((known, axes.reshape(O, K, 9), np.ones((O, K, 1))), 2)
        maps = beside_body(_both_biases())
    return Rows(known, maps, motion.known.astype(float), wrench.reshape(O, K, 6))


def _both_biases() -> Array:
    """(10, 6, 12) columns of a bias that is constant in base axes, by the entries (i, j)
    of the rotation to sensor axes, and of one that is constant in these."""
    columns = np.zeros((10, 6, 12))
    columns[:9, :3, :3] = columns[:9, 3:, 3:6] = np.eye(9).reshape(9, 3, 3)
    columns[-1, :, 6:] = np.eye(6)
    return columns
