"""Placement: where the sensor is in the logged frame, by Gauss-Newton steps of its
turn, its place and the clock offset; and how to correct it. With the same axes it is
displaced: the pose is that of a flange behind it, or the torque is about a point of the
tool.

A point r of the turning frame has the acceleration a + alpha x r + w x (w x r). The
wrench about it is that of a body held there.
"""

import numpy as np

from hefting.core.spatial import (
    Array,
    immutable,
    quaternion_of,
    rotation_by,
    rotation_vector,
    skew,
    tensor_to_vector,
    vector_to_tensor,
)
from hefting.ingest.model import REGRESSOR_BY_FEATURE, tangents_of, tilt_gravity
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, is_hopeless, linear_step
from hefting.ingest.rivals.explanation import (
    Around,
    Build,
    Explanation,
    fit_as_given,
    newton_euler,
)

LARGEST_LEVER = 0.5
"""[m] Largest distance of a sensor from the logged frame; a larger one is found where
force and torque do not belong together."""
SMALL_LEVER = 0.005
"""[m] Distance up to which a sensor counts as at the logged frame's origin, in spite of
a pose that was given."""
LARGEST_STEP = 0.3
"""[rad, m] Largest turn about, and change of the place along, each axis in one step."""
LARGEST_OFFSET_STEP = 0.02
"""[s] Largest change of the clock offset in one step."""
ROUND_ANGLE = np.radians(0.5)
"""[rad] Largest standard deviation of an angle that is rounded to whole degrees."""

CONVERGED = 0.03
"""Step over its standard deviation for white residuals, below which the iteration
ends."""
STEPS = 6
"""Gauss-Newton steps of turn, place and clock offset."""
FIRST_STEPS = 2
"""Number of steps after which a placement that explains nothing is given up. A lever
and a turn that explained half in the end had explained a quarter and a third by then.
"""


@immutable
class Placement:
    """Pose of the sensor in the logged frame, and the fit with it."""

    R: Array
    """(3, 3) rotation from sensor to logged axes"""
    point: Array
    """(3,) the sensor's origin [m]"""
    offset: float
    """[s] clock offset"""
    fitted: Fitted
    """fit in logged axes about the sensor's origin"""
    covariance: Array
    """(n, n) of the rotation vector in logged axes [rad], of the place [m], and of
    gravity's direction [rad], as far as they were free"""
    gravity: Array
    """(3,) in world axes [m/s²]"""

    @property
    def parameters(self) -> Array:
        """(10,) in the sensor's axes, about its origin."""
        vector = self.fitted.solution[self.fitted.best][:10]
        J = self.R.T @ vector_to_tensor(vector[4:]) @ self.R
        return np.concatenate((vector[:1], self.R.T @ vector[1:4], tensor_to_vector(J)))


def find_placement(
    case: Case,
    R: Array,
    offset: float,
    *,
    turns: bool,
    moves: bool,
    steps: int,
    tilts: bool = False,
    gravity: Array | None = None,
    only: int | None = None,
) -> Placement:
    """The likeliest placement near a rotation and a clock offset [s].

    `turns`, `moves` and `tilts` say whether the rotation, the place and gravity's
    direction are free. A place that is not free is the logged frame's origin. The
    direction is searched for near `gravity` (3,), by default that of the case. The force
    turns alone where `only` is 0, the torque where it is 1. The iteration ends early
    where the placement explains nothing.
    """
    logged, (given, _) = case, fit_as_given(case)
    if gravity is not None:
        case = case.with_gravity(gravity)
    point, build = np.zeros(3), _builder(case, R, np.zeros(3), only)
    here = Around.of(case, build, offset)
    parts = np.cumsum((3 * turns, 3 * moves, 2 * tilts))
    size = float(np.linalg.norm(case.gravity))
    for taken in range(steps):
        fitted = here.fitted
        if taken >= FIRST_STEPS and is_hopeless(logged, fitted, given):
            break
        tilt_scale = size if tilts else None
        columns = _columns(case, R, here, turns, moves, tilt_scale, only)
        step = linear_step(fitted, columns)
        if (np.abs(step.change) < CONVERGED * np.sqrt(step.white.diagonal())).all():
            break
        change = np.clip(step.change, -LARGEST_STEP, LARGEST_STEP)
        turn, move, tilt, _ = np.split(change, parts)
        if turns:
            R = rotation_by(turn) @ R
        if moves:
            point = point + move
        if tilts:
            case = case.with_gravity(tilt_gravity(case.gravity, size * tilt))
        if case.path.moves:
            late = float(step.change[-1])
            offset += float(np.clip(late, -LARGEST_OFFSET_STEP, LARGEST_OFFSET_STEP))
        build = _builder(case, R, point, only)
        here = Around.of(case, build, offset, fitted)
    known = step.covariance[: parts[-1], : parts[-1]]
    return Placement(R, point, offset, here.fitted, known, case.gravity)


def _columns(
    case: Case,
    R: Array,
    here: Around,
    turns: bool,
    moves: bool,
    tilt_scale: float | None,
    only: int | None,
) -> Array:
    """(K, 6, q) derivatives of the wrench by what is free: the rotation vector [rad] and
    the place [m], in logged axes, two tilts of gravity, and the clock offset [s] of
    poses that move. `tilt_scale` is gravity [m/s²], for tilts in rad; None where its
    direction is not free."""
    columns: list[Array] = []
    if turns:
        columns.append(_turn_columns(case, R, here, only))
    if moves:
        columns.append(_acceleration_columns(here, _arms(here.motion)[0]))
    if tilt_scale is not None:
        along = tilt_scale * (here.motion.axes[0] @ tangents_of(case.gravity).T)
        columns.append(-_acceleration_columns(here, along))
    if case.path.moves:
        columns.append(here.offset_columns)
    return np.concatenate(columns, axis=2)


def _turn_columns(case: Case, R: Array, here: Around, only: int | None) -> Array:
    """(K, 6, 3) derivative of the wrench by a turn of the sensor, or of what turns alone:
    d x w for a turn d of a wrench w, without the residual."""
    predicted = turned_by(case, R, only) - here.fitted.residual[0]
    columns = skew(predicted.reshape(-1, 2, 3))
    if only is not None:
        columns[:, 1 - only] = 0.0
    return columns.reshape(-1, 6, 3)


def _acceleration_columns(here: Around, change: Array) -> Array:
    """(K, 6, n) derivative of the wrench by n unknowns that change the acceleration by
    `change` (K, 3, n) each."""
    effect = REGRESSOR_BY_FEATURE[:3] @ here.fitted.solution[0, :10]
    return np.einsum("kxj,xc->kcj", change, effect)


def moved(motion: Motion, point: Array) -> Motion:
    """The motion of the point (3,) [m] of the moving frame."""
    return Motion(
        motion.a + _arms(motion) @ point, motion.rest, motion.axes, motion.known
    )


def _arms(motion: Motion) -> Array:
    """(O, K, 3, 3) derivative of a point's acceleration by its place: [alpha]x + [w]x
    [w]x."""
    S = vector_to_tensor(motion.rest[..., 3:])
    turning = S - np.trace(S, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    return skew(motion.rest[..., :3]) + turning


def turned_by(case: Case, R: Array, only: int | None = None) -> Array:
    """(K, 6) the recorded wrench turned by R into logged axes; the force alone where
    `only` is 0, the torque alone where it is 1."""
    recorded = case.wrench.reshape(-1, 2, 3)
    turned = recorded @ R.T
    if only is not None:
        turned[:, 1 - only] = recorded[:, 1 - only]
    return turned.reshape(-1, 6)


def _builder(case: Case, R: Array, point: Array, only: int | None) -> Build:
    turned = turned_by(case, R, only)[None]
    if not point.any():
        return lambda motion: newton_euler(case, motion, turned)
    return lambda motion: newton_euler(case, moved(motion, point), turned)


def seen_from_log(vector: Array, point: Array) -> Array:
    """Parameters (10,) with the COM relative to the logged frame's origin, for a sensor
    at a point (3,) in the same axes."""
    seen = vector.copy()
    seen[1:4] += vector[0] * point
    return seen


def turn_text(R: Array, std: float) -> str:
    """A rotation in words: its angle with the standard deviation [rad], and its
    axis."""
    angle, axis = angle_and_axis(R)
    x, y, z = np.round(axis, 2) + 0.0  # no -0.00
    return (
        f"{np.degrees(angle):.1f}° ± {np.degrees(std):.1g}° about "
        f"({x:.2f}, {y:.2f}, {z:.2f})"
    )


def place_text(point: Array, std: Array) -> str:
    """A place (3,) with its standard deviations, in millimetres."""
    pairs = zip(np.round(1e3 * point) + 0.0, 1e3 * std, strict=True)
    return f"({', '.join(f'{x:.0f} ± {s:.0f}' for x, s in pairs)}) mm"


def angle_and_axis(R: Array) -> tuple[float, Array]:
    """Angle [rad] and axis (3,) of a rotation (3, 3); z for the identity."""
    vector = rotation_vector(R)
    angle = float(np.linalg.norm(vector))
    return angle, vector / angle if angle > 0.0 else np.array((0.0, 0.0, 1.0))


def advice(
    case: Case,
    R: Array,
    point: Array,
    turn_covariance: Array | None = None,
    otherwise: str = "",
) -> str:
    """Advice for a sensor that is turned by R and at a `point` of the logged frame, in
    combination with a pose that was given.

    It is a turn by whole degrees about an axis if that agrees with the covariance (3, 3)
    of the turn in logged axes, else a pose, with `otherwise` as an alternative.
    """
    if case.path.gravity_measured:  # the poses do not say how the accelerometer moves
        return "give wrench and accelerometer in the same axes, about the same point"
    given, instead = case.recording.sensor_pose, ""
    if given is not None:
        before, instead = given[:3, :3], " in place of the pose that was given"
        R, point = before @ R, before @ point + given[:3, 3]
        if turn_covariance is not None:
            turn_covariance = before @ turn_covariance @ before.T
        if angle_and_axis(R)[0] < ROUND_ANGLE and np.linalg.norm(point) < SMALL_LEVER:
            return "leave out the pose of the sensor that was given"
    if turn_covariance is not None and not point.any():
        round_turn = _round_turn(R, turn_covariance)
        if round_turn is not None:
            return f"give `sensor_turned`='{round_turn}'{instead}"
    place = ",".join(_number(x, 4) for x in point)
    turn = ",".join(_number(q, 5) for q in quaternion_of(R))
    return f"give `sensor_pose_in_log`='{place},{turn}'{instead}{otherwise}"


def _number(value: float, digits: int) -> str:
    """A number with at most so many decimals, without trailing zeros."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _round_turn(R: Array, covariance: Array) -> str | None:
    """A turn by whole degrees about a sensor axis, as text; None if it differs
    significantly from R, or R is not known well enough."""
    angle, axis = angle_and_axis(R)
    degrees = round(float(np.degrees(angle)))
    main = int(np.argmax(np.abs(axis)))
    sign = 1.0 if axis[main] > 0.0 else -1.0
    rounded = np.zeros(3)
    rounded[main] = sign * np.radians(degrees)
    off = rotation_vector(rotation_by(rounded).T @ R)
    known = np.sqrt(np.trace(covariance) / 3.0)
    if known >= ROUND_ANGLE or off @ np.linalg.solve(covariance, off) >= 9.0:
        return None
    return f"{'xyz'[main]}:{180 if degrees == 180 else round(sign * degrees)}"


def turned_and_moved(
    case: Case, code: str, R: Array, offset: float
) -> Explanation | None:
    """A sensor that is both turned and moved, found from a rotation (3, 3) and a clock
    offset [s]; `code` is that of the one which explains more alone."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    found = find_placement(case, R, offset, turns=True, moves=True, steps=STEPS)
    point, C = found.point, found.covariance
    if not np.linalg.norm(point) <= LARGEST_LEVER:
        return None
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ C[:3, :3] @ axis))
    std = np.sqrt(C.diagonal()[3:])
    return Explanation(
        code,
        f"the sensor's axes seem turned by {turn_text(found.R, known)} of the logged "
        f"ones, and its origin at {place_text(point, std)} of the logged frame",
        advice(case, found.R, point),
        found.fitted,
        6,
        argument="sensor_pose_in_log",
        parameters=seen_from_log(found.parameters, found.R.T @ point),
        effect=min(
            angle / max(known, 1e-12),
            float(np.linalg.norm(point / np.maximum(std, 1e-12))),
        ),
    )


LEVER_ARM = "lever-arm"
LEVER_STEPS = 5
"""Number of Gauss-Newton steps of the point and the clock offset."""
CHANCE = 3.0
"""Distance, in standard deviations, of the point from the line to the COM that is
chance: up to 1.5 for torques of another gain, 14 and more for lever arms of 120 mm."""


def explain_lever(case: Case) -> Explanation | None:
    """The point, from the logged frame's origin."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    _, offset = fit_as_given(case)
    found = find_placement(
        case, np.eye(3), offset, turns=False, moves=True, steps=LEVER_STEPS
    )
    point, std = found.point, np.sqrt(found.covariance.diagonal())
    if not np.linalg.norm(point) <= LARGEST_LEVER:
        return None
    otherwise = " if the sensor is there, or log the torque about the logged frame"
    parameters = seen_from_log(found.parameters, point)
    # torques of another gain are those about a point on the line to the COM
    com = parameters[1:4] / (parameters[0] or 1.0)
    far, times = float(np.linalg.norm(com)), ""
    gain = 1.0 - float(point @ com) / max(far**2, 1e-12)
    off = np.linalg.norm(np.cross(point, com))
    if off < CHANCE * far * np.linalg.norm(std):
        times = f", or to be {gain:.2f} times what it is"
        otherwise += ", after its sign, unit and calibration are checked"
    return Explanation(
        LEVER_ARM,
        f"the torque seems to act about a point {place_text(point, std)} from the "
        f"logged frame{times}",
        advice(case, np.eye(3), point, otherwise=otherwise),
        found.fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=parameters,
        effect=float(np.linalg.norm(point / np.maximum(std, 1e-12))),
        # a sensor's own gain is off by less
        is_grave=bool(times) and abs(gain - 1.0) > 0.1,
        alternative=lambda: turned_and_moved(case, LEVER_ARM, np.eye(3), found.offset),
    )
