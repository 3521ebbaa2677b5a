"""Base and sensor axes: gravity points elsewhere in the logged world, as the base is
tilted or the world has other axes than assumed; or the wrench is in the axes of the
robot's base, as some controllers state the force at the tool, not in those of the
sensor."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.spatial import Array, angle_between, skew
from hefting.ingest.model import REGRESSOR_BY_FEATURE, tangents_of, tilt_gravity
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    beside_body,
    fit_rows,
    is_hopeless,
    linear_step,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    Around,
    Explanation,
    Undone,
    explains_nothing,
    fit_as_given,
    over_offsets,
)
from hefting.ingest.rivals.wrench_compensated import OR_HEAVIER

IN_BASE_AXES = "wrench-in-base-axes"
IN_BASE = "the wrench seems to be in the axes of the robot's base"
FIX_IN_BASE = (
    'log it in sensor axes, or say axes = "world" of the wrench in a column map '
    "(hefting map LOG writes one), of a bag after hefting convert to CSV"
)
ABOUT_BASE = ", with its torque about the base's origin"
FIX_ABOUT_BASE = "log it in sensor axes about the sensor's origin"


def explain_axes(case: Case) -> Explanation | None:
    """The wrench turned into sensor axes, with a constant bias in both."""
    fitted, _ = over_offsets(
        case, lambda motion: _turned_rows(case, motion, case.wrench)
    )
    what = IN_BASE
    fix = FIX_IN_BASE
    if case.recording.has("position"):
        about = _about_sensor(case, case.time, case.wrench)
        other, _ = over_offsets(case, lambda motion: _turned_rows(case, motion, about))
        if other.likelihood.max() > fitted.likelihood.max():
            fitted, what, fix = other, IN_BASE + ABOUT_BASE, FIX_ABOUT_BASE
    return Explanation(IN_BASE_AXES, what, fix, fitted, 0, argument="column_map")


def axes_undone(case: Case) -> Iterator[Undone]:
    """The wrench in sensor axes, with its torque as logged or about the sensor's
    origin."""
    first_time, first = case.consecutive
    axes = case.motion_as_found.axes[0]
    first_axes = case.motion_at(first_time[None] - case.offset).axes[0]
    changed = [(IN_BASE, FIX_IN_BASE, case.wrench, first)]
    if case.recording.has("position"):
        about = _about_sensor(case, case.time, case.wrench)
        first_about = _about_sensor(case, first_time, first)
        changed.append((IN_BASE + ABOUT_BASE, FIX_ABOUT_BASE, about, first_about))
    for what, fix, wrench, consecutive in changed:
        other = replace(
            case,
            wrench=_turned(axes, wrench),
            consecutive=(first_time, _turned(first_axes, consecutive)),
        )
        yield Undone(IN_BASE_AXES, what, fix, other, argument="column_map")


def _turned(axes: Array, wrench: Array) -> Array:
    """A wrench (K, 6) in axes (K, 3, 3) that differ at each time."""
    return np.einsum("kij,kpj->kpi", axes, wrench.reshape(-1, 2, 3)).reshape(-1, 6)


def _about_sensor(case: Case, time: Array, wrench: Array) -> Array:
    """(K, 6) wrench at times (K,) [s] with its torque, which is about the world's
    origin, about the sensor's."""
    place = case.places(time - case.offset)
    force, torque = np.split(wrench, 2, axis=1)
    return np.hstack((force, torque - np.cross(place, force)))


def _turned_rows(case: Case, motion: Motion, recorded: Array) -> Rows:
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


CODE = "base-tilted"
STEPS = 8
"""Gauss-Newton steps of gravity's direction from each start."""
FIRST_STEPS = 3
"""Number of steps after which the best start is chosen, and hopeless ones are given
up."""
LIKELIEST_STARTS = 2
"""Number of starts along axes of the world, beside gravity as given."""
LARGEST_STEP = 4.0
"""[m/s²] Largest change of gravity along each tangent in a step."""
REVERSED = np.radians(175.0)
"""[rad] Angle between given and found gravity above which it is reversed."""
FAR = np.radians(30.0)
"""[rad] Angle above which numbers for gravity are advised, as the world has other axes
rather than a tilted base."""
NEAR_AXIS = np.radians(3.0)
"""[rad] Angle to an axis of the world within which such gravity is taken to be along
it."""
SENSOR_ERROR = np.radians(0.3)
"""[rad] Standard deviation of gravity's direction by errors of the sensor alone."""


def explain(case: Case) -> Explanation | None:
    """The direction of gravity, from the given one and from directions along axes."""
    if not _is_modelled(case) or explains_nothing(case, partial(_freed, case)):
        return None
    given, offset = fit_as_given(case)
    starts = [case.gravity, *_starts_along_axes(case, offset)]
    found = [_from(case, start, offset, FIRST_STEPS) for start in starts]
    gravity, fitted, _ = max(found, key=lambda each: each[1].likelihood[0])
    if is_hopeless(case, fitted, given):
        return None
    gravity, _, _ = _from(case, gravity, offset, STEPS - FIRST_STEPS)
    # so far the clock offset is that of gravity as given
    _, offset = over_offsets(case, lambda m: _rows(case, m, gravity))
    gravity, fitted, std = _from(case, gravity, offset, free_offset=case.path.moves)
    angle = angle_between(case.gravity, gravity)
    std = float(np.hypot(std, SENSOR_ERROR))
    if angle > REVERSED:
        return next(undone(case)).explanation(fitted)
    x, y, z = gravity
    force = abs(fitted.solution[0, 0]) * np.linalg.norm(gravity - case.gravity)
    what = (
        f"gravity seems to point along ({x:.2f}, {y:.2f}, {z:.2f}) m/s², "
        f"{np.degrees(angle):.1f}° ± {np.degrees(std):.1g}° from where it is given, as on "
        f"a tilted base or by a steady force of {force:.2g} N"
    )
    fix = f"give {gravity_to_give(gravity, angle)}"
    return Explanation(
        CODE, what, fix, fitted, 2, argument="gravity", effect=angle / std
    )


def _starts_along_axes(case: Case, offset: float) -> list[Array]:
    """The likeliest directions of gravity along axes of the world, at a clock offset [s],
    other than the given one."""
    size = float(np.linalg.norm(case.gravity))
    starts = [size * s * e for e in np.eye(3) for s in (-1.0, 1.0)]
    motion = case.motion_late(offset)
    features = np.concatenate([motion.features(start) for start in starts])
    used = np.repeat(motion.known, len(features), axis=0)
    rows = with_bias(case, features, REGRESSOR_BY_FEATURE, used)
    best = np.argsort(fit_rows(case, rows).likelihood)[-LIKELIEST_STARTS:]
    return [starts[i] for i in best if not np.allclose(starts[i], case.gravity)]


def undone(case: Case) -> Iterator[Undone]:
    """Gravity reversed: weight and inertia then have opposite signs."""
    if _is_modelled(case):
        x, y, z = 0.0 - case.gravity
        # as where it was given downwards, as usual
        heavier = OR_HEAVIER if case.gravity[2] < 0.0 else ""
        yield Undone(
            "gravity-reversed",
            f"gravity seems to point the other way{heavier}",
            f"give `gravity`='{x:g},{y:g},{z:g}'",
            case.with_gravity(-case.gravity),
            argument="gravity",
            is_grave=True,  # weight and inertia have opposite signs
            is_linear=True,
        )


def _is_modelled(case: Case) -> bool:
    return not case.path.gravity_measured and bool(case.gravity.any())


def gravity_to_give(gravity: Array, angle: float) -> str:
    """Argument to advise for gravity (3,), at an angle [rad] to the given one."""
    if not angle > FAR:
        return "`gravity`='estimate'"
    x, y, z = 0.0 + _along_axis(gravity)
    return f"`gravity`='{x:.6g},{y:.6g},{z:.6g}'"


def _along_axis(gravity: Array) -> Array:
    """Gravity (3,), exactly along an axis of the world if it nearly is."""
    size, axis = float(np.linalg.norm(gravity)), int(np.argmax(np.abs(gravity)))
    along = np.zeros(3)
    along[axis] = np.copysign(size, gravity[axis])
    return along if gravity @ along > np.cos(NEAR_AXIS) * size**2 else gravity


def _freed(case: Case, motion: Motion) -> Rows:
    """Rows of a body on which also acts any force that is constant in world axes, each
    component at any point; gravity in any direction is a special case."""
    axes = motion.axes.reshape(*motion.known.shape, 9)
    known = np.concatenate((motion.a, motion.rest, axes), axis=2)
    return with_bias(case, known, beside_body(_columns_of_freed()), motion.known)


def _columns_of_freed() -> Array:
    """(9, 6, 12) columns of the force's components and their moments, per unit of the
    entries (i, j) of the rotation to sensor axes."""
    columns = np.zeros((9, 6, 12))
    columns[:, :3, :3] = np.eye(9).reshape(9, 3, 3)
    for k in range(9):
        i, j = divmod(k, 3)
        # of a force along x_i at points along the three axes
        columns[k, 3:, 3 + 3 * j : 6 + 3 * j] = -skew(np.eye(3)[i])
    return columns


def _rows(case: Case, motion: Motion, gravity: Array) -> Rows:
    return with_bias(case, motion.features(gravity), REGRESSOR_BY_FEATURE, motion.known)


def _from(
    case: Case,
    gravity: Array,
    offset: float,
    steps: int = STEPS,
    *,
    free_offset: bool = False,
) -> tuple[Array, Fitted, float]:
    """Gravity (3,) that fits best near a start, its fit, and its standard deviation
    [rad]; the clock offset [s] is free or fixed."""
    here = Around.of(case, partial(_rows, case, gravity=gravity), offset)
    size = float(np.linalg.norm(gravity))
    for _ in range(steps):
        fitted = here.fitted
        along = -(here.motion.axes[0] @ tangents_of(gravity).T)  # (K, 3, 2)
        effect = REGRESSOR_BY_FEATURE[:3] @ fitted.solution[0, :10]
        columns = np.einsum("kxt,xc->kct", along, effect)
        if free_offset:
            columns = np.concatenate((columns, here.offset_columns), axis=2)
        step = linear_step(fitted, columns)
        change = np.clip(step.change[:2], -LARGEST_STEP, LARGEST_STEP)
        gravity = tilt_gravity(gravity, change)
        if free_offset:
            offset += float(np.clip(step.change[2], -0.02, 0.02))
        here = Around.of(case, partial(_rows, case, gravity=gravity), offset, fitted)
        if np.abs(change).max() < 1e-4 * size:
            break
    std = float(np.sqrt(step.covariance[:2, :2].trace() / 2.0)) / size
    return gravity, here.fitted, std
