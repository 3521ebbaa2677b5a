"""Coarse clock offset between wrench and motion: a scan of the Student likelihood of the linear model."""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import REGRESSOR_BY_FEATURE, STUDENT_DEGREES_OF_FREEDOM, Problem, Start, tangents_of
from hefting.ingest.path import MOTION_COLUMNS, WORLD_AXES_COLUMNS

COARSE_OFFSET_STEP = 0.02
"""[s] Spacing of the clock offsets of the first grid."""
FINE_OFFSET_STEP = 0.002
"""[s] Spacing of the second grid, about the best of the first one. It is used for accelerometers, which measure
vibrations too fast for the first grid."""
FIRST_SCAN_RANGE = 0.2
"""[s] Half the width of the first grid. It is doubled while the best offset is at an edge."""
MOST_DOUBLINGS = 3
"""Largest number of times the range of the grid is doubled."""
UNEXPLAINED_CHANGE_SHARE = 0.5
"""Ratio of residual scale to the wrench's standard deviation from which on the range of the grid is doubled."""
NEIGHBOURHOOD_OF_OFFSET = 0.1
"""[s] Offsets closer to the best one than this do not compete with it."""
CLEAR_LOG_LIKELIHOOD_RATIO = 25.0
"""Logarithm of the likelihood ratio at which the best offset is taken over all distant ones. It is far larger than
for white noise, to allow for coloured noise."""
LARGEST_OFFSET_SHARE = 0.15
"""Largest clock offset looked for, as a share of the recording's duration."""
SCANNED_BLOCKS = 200
"""Number of blocks used in the scan for a constant bias; 50 more for each further knot."""
SCAN_ITERATIONS = 4
"""Number of iterations of reweighted least squares at each offset."""


@dataclass(frozen=True, eq=False)
class _Trials:
    offsets: Array
    likelihood: Array
    """(O,) a sample"""
    phi: Array
    """(O, 10)"""
    tilt: Array
    """(O, 2)"""
    scale: Array
    """(O, 2)"""
    bias: Array
    """(O, n, 6)"""


def scan(problem: Problem, gravity: Array, knots: int) -> Start:
    """Rough parameters, bias, scales, offset and gravity: the most likely of a grid of offsets.

    With one offset, zero, where the offset is not free.
    """
    chosen = problem.every(SCANNED_BLOCKS + 50 * (knots - 1))
    duration = float(problem.time[-1] - problem.time[0])
    limit = LARGEST_OFFSET_SHARE * duration
    changes = np.std(chosen.wrench, axis=0).reshape(2, 3).max(axis=1)
    measured = problem.path.gravity_measured
    reach = min(FIRST_SCAN_RANGE, limit) if problem.free_offset else 0.0
    for _ in range(MOST_DOUBLINGS + 1):
        steps = int(reach / COARSE_OFFSET_STEP)
        offsets = COARSE_OFFSET_STEP * np.arange(-steps, steps + 1, dtype=float)
        found = _trials(chosen, gravity, knots, offsets, by_orientation=measured)
        best = int(np.argmax(found.likelihood))
        explained = bool((found.scale[best] < UNEXPLAINED_CHANGE_SHARE * changes).all())
        inside = 1 < best < len(found.offsets) - 2
        if reach >= limit or (inside and (explained or _stands_out(found, len(chosen.time)))):
            break
        reach = min(2.0 * reach, limit)
    if problem.free_offset and measured:  # an accelerometer feels vibrations: look closely
        close = round(2.0 * COARSE_OFFSET_STEP / FINE_OFFSET_STEP)
        near = found.offsets[best] + FINE_OFFSET_STEP * np.arange(-close, close + 1)
        found = _trials(chosen, gravity, knots, near)
        best = int(np.argmax(found.likelihood))
    tilted = gravity + found.tilt[best] @ tangents_of(gravity)
    tilted = tilted * (np.linalg.norm(gravity) / np.linalg.norm(tilted))
    at = HatFunctions.over(chosen.time, knots).knots
    return Start(found.phi[best], float(found.offsets[best]), tilted, found.scale[best], at, found.bias[best])


def _stands_out(found: _Trials, samples: int) -> bool:
    """Whether the best offset is far more likely than all that are not near it, whatever noise leaves unexplained."""
    best = int(np.argmax(found.likelihood))
    others = found.likelihood[np.abs(found.offsets - found.offsets[best]) > NEIGHBOURHOOD_OF_OFFSET]
    return len(others) > 0 and samples * float(found.likelihood[best] - others.max()) > CLEAR_LOG_LIKELIHOOD_RATIO


def _trials(problem: Problem, gravity: Array, knots: int, offsets: Array, by_orientation: bool = False) -> _Trials:
    """Robust least squares at each of the offsets (O,).

    Every column, like the wrench, is linear in what is known of a sample, z = [motion (12), gravity's tangents (6),
    bias functions (n), wrench (6)]: the normal equations of one offset follow from its Z'WZ, as in
    `hefting.ingest.fit`.
    """
    time, wrench = problem.time, problem.wrench
    K, O = len(time), len(offsets)
    seen = problem.path.at((time[None, :] - offsets[:, None]).ravel(), spread=False)
    world = seen.value[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3)
    x = seen.value[:, MOTION_COLUMNS].copy()
    if by_orientation:  # which changes slowly
        x = np.zeros_like(x)
        x[:, :3] = -(world @ gravity)
    elif not problem.path.gravity_measured:
        x[:, :3] -= world @ gravity
    used = seen.known.reshape(O, K).astype(float)
    hats = HatFunctions.over(time, knots)
    functions, n = hats.combine(np.eye(hats.n)), hats.n
    parts = [x.reshape(O, K, 12)]
    tilts = 2 if problem.free_gravity else 0
    if tilts:
        along = np.swapaxes(-(world @ tangents_of(gravity).T), 1, 2).reshape(O, K, 6)
        parts.append(along)
    parts += [np.broadcast_to(functions, (O, K, n)), np.broadcast_to(wrench, (O, K, 6))]
    z = np.concatenate(parts, axis=2)
    maps, at = _maps(z.shape[2], tilts, n)
    p = maps.shape[2]
    by_channel = maps.transpose(1, 0, 2)  # (6, z, p)
    spread = np.sqrt(np.mean((wrench - wrench.mean(axis=0)).reshape(K, 2, 3) ** 2, axis=(0, 2)))
    floor = np.maximum(problem.floor, 1e-12)
    scale = np.maximum(np.broadcast_to(spread, (O, 2)), floor)
    student, square = np.ones((O, K)), np.zeros((O, K, 2))
    count = np.maximum(used.sum(axis=1), 1.0)
    solution = np.zeros((O, p))
    for _ in range(SCAN_ITERATIONS):
        gram = np.swapaxes(z * (used * student)[:, :, None], 1, 2) @ z  # (O, z, z)
        weight = np.repeat(scale**-2.0, 3, axis=1)
        normal, b = np.zeros((O, p, p)), np.zeros((O, p))
        for channel, columns in enumerate(by_channel):
            rows = np.flatnonzero(columns.any(axis=1))
            inner = columns[rows]
            part = inner.T @ (gram[:, rows[:, None], rows] @ inner)
            normal += weight[:, channel, None, None] * part
            b += weight[:, channel, None] * (gram[:, rows, z.shape[2] - 6 + channel] @ inner)
        length = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 0.0))
        length = np.where(length > 1e-150, length, 1.0)
        scaled = normal / length[:, :, None] / length[:, None, :] + 1e-9 * np.eye(p)
        solution = np.linalg.solve(scaled, (b / length)[:, :, None])[:, :, 0] / length
        predicted = z[:, :, :-6] @ np.einsum("zcp,op->ozc", maps[:-6], solution)
        square = np.sum((wrench - predicted).reshape(O, K, 2, 3) ** 2, axis=3)
        for _ in range(2):
            u = np.einsum("okt,ot->ok", square, scale**-2.0)
            student = (STUDENT_DEGREES_OF_FREEDOM + 6.0) / (STUDENT_DEGREES_OF_FREEDOM + u)
            scale = np.sqrt(np.einsum("ok,okt->ot", used * student, square) / (3.0 * count[:, None]))
            scale = np.maximum(scale, floor)
    u = np.einsum("okt,ot->ok", square, scale**-2.0)
    tail = 0.5 * (STUDENT_DEGREES_OF_FREEDOM + 6.0) * np.log1p(u / STUDENT_DEGREES_OF_FREEDOM)
    likelihood = -np.sum(used * tail, axis=1) / count - 3.0 * np.log(scale).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    phi = solution[:, :10]
    tilt = np.zeros((O, 2))
    if tilts:
        heavy = phi[:, :4] / np.array((1.0, 0.1, 0.1, 0.1))
        size = np.maximum(np.sum(heavy[:, :1] ** 2, axis=1), 1e-300)
        tilt = np.stack([solution[:, 10 + 4 * i] * phi[:, 0] / size for i in range(2)], axis=1)
    return _Trials(offsets, likelihood, phi, tilt, scale, solution[:, at:].reshape(O, n, 6))


def _maps(size: int, tilts: int, n: int) -> tuple[Array, int]:
    """(z, 6, p): the columns of ten parameters, of the four that gravity shows along each tangent, and of the bias's
    `n` functions, linear in the `size` numbers known of a sample; and the first column of the bias."""
    at = 10 + 4 * tilts
    maps = np.zeros((size, 6, at + 6 * n))
    maps[:12, :, :10] = REGRESSOR_BY_FEATURE
    for i in range(tilts):
        maps[12 + 3 * i : 15 + 3 * i, :, 10 + 4 * i : 14 + 4 * i] = REGRESSOR_BY_FEATURE[:3, :, :4]
    first = 12 + 3 * tilts
    for j in range(n):
        maps[first + j, :, at + 6 * j : at + 6 * j + 6] = np.eye(6)
    return maps, at
