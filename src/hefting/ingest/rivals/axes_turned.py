"""The sensor's axes are turned against the logged ones, as where it is mounted at an
angle to the flange whose pose is logged.

With w the wrench as recorded and R the rotation from sensor to logged axes, R w is
linear in R, and least squares of the parameters leaves

    |w|² - vec(R)' Q vec(R),    Q = B' N^-1 B,

with N the normal matrix, which no rotation changes as force and torque are weighted the
same along all axes, and B vec(R) the right-hand side. Q is positive semidefinite, so R
<- (the rotation nearest to Q vec(R)) never decreases vec(R)' Q vec(R).
"""

import itertools

import numpy as np

from hefting.core.spatial import (
    Array,
    quaternion_of,
    rotation_by,
    rotation_vector,
    skew,
    tensor_to_vector,
    vector_to_tensor,
)
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted, Rows, linear_step
from hefting.ingest.rivals.explanation import (
    Build,
    Explanation,
    at_offset,
    newton_euler,
    offset_columns,
)
from hefting.ingest.robust_rows import normal_equations, scaled_to_ones

CODE = "axes-turned"
STEPS = 25
"""Steps of the ascent from the best starts."""
FIRST_STEPS = 5
"""Steps from each start, after which the best ones are known."""
KEPT_STARTS = 6
"""Starts from which the ascent goes on. Of 330 recordings with mistakes of all kinds the
rotation is that from all starts in 327; in the others another mistake explains more."""
REFINEMENTS = 4
"""Gauss-Newton steps of rotation and clock offset."""
LARGEST_STEP = 0.3
"""[rad] Largest turn about each axis in one of them."""
CROSS_TALK = 0.005
"""Standard deviation of a sensor's cross-talk, as on data sheets. Its antisymmetric
part is a rotation, of so many radians over the root of two about each axis."""
ROUND_ANGLE = np.radians(0.5)
"""[rad] Standard deviation up to which an angle is known well enough to be rounded to a
whole number of degrees."""
QUARTER_TURNS = np.array(
    [
        axes
        for order in itertools.permutations(np.eye(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
        if np.linalg.det(axes := np.array(signs)[:, None] * np.array(order)) > 0.0
    ]
)
"""The 24 rotations of a cube, from which the best one is looked for."""


def explain(case: Case) -> Explanation | None:
    """The best rotation, with its standard deviation."""
    R, fitted, covariance = rotation_of(case)
    std = covariance + 0.5 * CROSS_TALK**2 * np.eye(3)
    angle, axis = _angle_axis(R)
    known = float(np.sqrt(axis @ std @ axis))
    x, y, z = np.round(axis, 2) + 0.0  # no -0.00
    what = (
        f"the sensor's axes seem turned by {np.degrees(angle):.1f}° ± "
        f"{np.degrees(known):.1g}° about ({x:.2f}, {y:.2f}, {z:.2f}) of the logged ones"
    )
    return Explanation(
        CODE,
        what,
        _fix(R, angle, axis, std),
        fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=_in_sensor_axes(fitted.solution[fitted.best][:10], R),
        effect=angle / max(known, 1e-12),
    )


def _in_sensor_axes(vector: Array, R: Array) -> Array:
    """Parameters (10,) in logged axes as the sensor's axes see them."""
    J = R.T @ vector_to_tensor(vector[4:]) @ R
    return np.concatenate((vector[:1], R.T @ vector[1:4], tensor_to_vector(J)))


def rotation_of(case: Case) -> tuple[Array, Fitted, Array]:
    """Rotation (3, 3) from sensor to logged axes, its fit, and the covariance (3, 3) of
    the rotation vector."""
    rows = newton_euler(case, case.motion)
    scale = np.maximum(np.std(case.wrench, axis=0).reshape(2, 3).mean(axis=1), 1e-9)
    scales = np.broadcast_to(scale, (len(case.offsets), 2))
    R, value = _ascend(case, rows, rows.used, scales, QUARTER_TURNS)
    index = int(np.argmax(value))
    return _refine(case, R[index], float(case.offsets[index]))


def _ascend(
    case: Case, rows: Rows, weights: Array, scale: Array, starts: Array
) -> tuple[Array, Array]:
    """For each of the O alternatives the best rotation (O, 3, 3) from any of the starts
    (S, 3, 3), and vec(R)' Q vec(R) less the wrench's square (O,)."""
    Q, square = _quadratic(case, rows, weights, scale)
    v = np.broadcast_to(starts.reshape(-1, 9), (len(Q), len(starts), 9))
    for _ in range(FIRST_STEPS):
        v = _nearest_rotations(v @ Q)
    worst_first = np.argsort(np.sum(v @ Q * v, axis=2), axis=1)
    v = np.take_along_axis(v, worst_first[:, -KEPT_STARTS:, None], axis=1)
    for _ in range(STEPS - FIRST_STEPS):
        v = _nearest_rotations(v @ Q)
    value = np.sum(v @ Q * v, axis=2)
    best = np.argmax(value, axis=1)
    each = np.arange(len(Q))
    # per sample, so that offsets with fewer known samples do not win by that
    count = np.maximum(weights.sum(axis=1), 1.0)
    return v[each, best].reshape(-1, 3, 3), (value[each, best] - square) / count


def _nearest_rotations(vectors: Array) -> Array:
    """The rotations nearest to matrices, both (..., 9) by rows."""
    U, _, V = np.linalg.svd(vectors.reshape(*vectors.shape[:-1], 3, 3))
    U[..., 2] *= np.linalg.det(U @ V)[..., None]
    return (U @ V).reshape(vectors.shape)


def _quadratic(
    case: Case, rows: Rows, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Q (O, 9, 9) for the rotation's rows one after the other, and the weighted square
    of the wrench (O,)."""
    known, maps = rows.known, rows.maps
    O, K, _ = known.shape
    p = maps.shape[2]
    wrench = np.broadcast_to(case.wrench, (O, K, 6))
    both = np.concatenate((known, wrench), axis=2)
    normal, _ = normal_equations(both, maps, weights, scale)
    # sums of known rows times each channel of the wrench: (O, z, 6)
    cross = np.swapaxes(known * weights[:, :, None], 1, 2) @ wrench
    inverse_variance = np.repeat(scale**-2.0, 3, axis=1)
    B = np.zeros((O, p, 3, 3))  # of the rotation's entry (i, j)
    for i in range(3):
        for part in (0, 3):
            along = maps[:, part + i, :]  # (z, p)
            sums = np.einsum("zp,ozj->opj", along, cross[:, :, part : part + 3])
            B[:, :, i, :] += inverse_variance[:, part, None, None] * sums
    B = B.reshape(O, p, 9)
    scaled, length = scaled_to_ones(normal)
    B = B / length[:, :, None]
    Q = np.swapaxes(B, 1, 2) @ np.linalg.solve(scaled, B)
    square = np.einsum("ok,okc,oc->o", weights, wrench**2, inverse_variance)
    return 0.5 * (Q + np.swapaxes(Q, 1, 2)), square


def _refine(case: Case, R: Array, offset: float) -> tuple[Array, Fitted, Array]:
    """Rotation (3, 3), fit, and covariance of the rotation vector (3, 3) [rad²] in
    logged axes, by Gauss-Newton steps of rotation and clock offset together."""
    fitted, covariance = _fit_at(case, R, offset), np.zeros((3, 3))
    for _ in range(REFINEMENTS):
        turned = _turned(case, R)[0]
        predicted = turned - fitted.residual[0]
        # a turn by d changes the turned wrench by d x w, which the fit is to follow
        blocks = skew(predicted.reshape(-1, 3))
        columns = blocks.reshape(len(turned), 6, 3)
        if case.path.moves:
            build = _builder(case, R)
            late = offset_columns(case, build, offset, fitted.solution[0])
            columns = np.concatenate((columns, late), axis=2)
        step = linear_step(fitted, 0, columns)
        covariance = step.covariance[:3, :3]
        turn = np.clip(step.change[:3], -LARGEST_STEP, LARGEST_STEP)
        R = rotation_by(turn) @ R
        if case.path.moves:
            offset += float(np.clip(step.change[3], -0.02, 0.02))
        fitted = _fit_at(case, R, offset)
    return R, fitted, covariance


def _turned(case: Case, R: Array) -> Array:
    """(1, K, 6) wrench in logged axes."""
    return (case.wrench.reshape(-1, 2, 3) @ R.T).reshape(1, -1, 6)


def _builder(case: Case, R: Array) -> Build:
    turned = _turned(case, R)
    return lambda motion: newton_euler(case, motion, turned)


def _fit_at(case: Case, R: Array, offset: float) -> Fitted:
    return at_offset(case, _builder(case, R), offset)


def _angle_axis(R: Array) -> tuple[float, Array]:
    vector = rotation_vector(R)
    angle = float(np.linalg.norm(vector))
    return angle, vector / angle if angle > 0.0 else np.array((0.0, 0.0, 1.0))


def _fix(R: Array, angle: float, axis: Array, covariance: Array) -> str:
    """What to type: a whole number of degrees about an axis where that is within the
    deviation, else the pose."""
    degrees = round(float(np.degrees(angle)))
    main = int(np.argmax(np.abs(axis)))
    sign = 1.0 if axis[main] > 0.0 else -1.0
    rounded = np.zeros(3)
    rounded[main] = sign * np.radians(degrees)
    off = rotation_vector(rotation_by(rounded).T @ R)
    known = np.sqrt(np.trace(covariance) / 3.0)
    if known < ROUND_ANGLE and off @ np.linalg.solve(covariance, off) < 9.0:
        turn = 180 if degrees == 180 else round(sign * degrees)
        return f"give `sensor_turned`='{'xyz'[main]}:{turn}'"
    numbers = ",".join(f"{q:.5f}" for q in quaternion_of(R))
    return f"give `sensor_pose_in_log`='0,0,0,{numbers}'"
