"""Coarse clock offset between wrench and motion: a scan of the Student likelihood of the linear model."""

from dataclasses import dataclass

import numpy as np

from hefting.conditioning.drift import Hats
from hefting.conditioning.fit import FREEDOM, Problem, Start
from hefting.conditioning.system import features_at, tangents_of
from hefting.regressor import FULL_MAP
from hefting.spatial import Array

STEP = 0.02
"""s between the offsets tried."""
FINE_STEP = 0.002
"""s between the offsets then tried about the best, where an accelerometer feels what is faster"""
REACH = 0.2
"""s to either side, doubled while the best is at the edge."""
DOUBLINGS = 3
UNEXPLAINED = 0.5
"""Part of the wrench's changes: with residuals as large, one looks further."""
MOST = 0.15
"""of the recording's duration"""
SAMPLES = 200
"""Samples the scan looks at; more where the bias has more knots."""
PASSES = 4


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
    chosen = problem.every(SAMPLES + 50 * (knots - 1))
    duration = float(problem.time[-1] - problem.time[0])
    limit = MOST * duration
    changes = np.std(chosen.wrench, axis=0).reshape(2, 3).max(axis=1)
    reach = min(REACH, limit) if problem.free_offset else 0.0
    for _ in range(DOUBLINGS + 1):
        steps = int(reach / STEP)
        offsets = STEP * np.arange(-steps, steps + 1, dtype=float)
        found = _trials(chosen, gravity, knots, offsets, slow=True)
        best = int(np.argmax(found.likelihood))
        explained = bool((found.scale[best] < UNEXPLAINED * changes).all())
        if (explained and 1 < best < len(found.offsets) - 2) or reach >= limit:
            break
        reach = min(2.0 * reach, limit)
    if problem.free_offset and problem.signal.gravity_measured:  # an accelerometer feels vibrations: look closely
        near = found.offsets[best] + FINE_STEP * np.arange(
            -round(STEP / FINE_STEP) * 2, round(STEP / FINE_STEP) * 2 + 1
        )
        found = _trials(chosen, gravity, knots, near)
        best = int(np.argmax(found.likelihood))
    tilted = gravity + found.tilt[best] @ tangents_of(gravity)
    tilted = tilted * (np.linalg.norm(gravity) / np.linalg.norm(tilted))
    at = Hats.over(chosen.time, knots).knots
    return Start(found.phi[best], float(found.offsets[best]), tilted, found.scale[best], at, found.bias[best])


def _trials(problem: Problem, gravity: Array, knots: int, offsets: Array, slow: bool = False) -> _Trials:
    time, wrench = problem.time, problem.wrench
    K, O = len(time), len(offsets)
    seen = problem.signal.at((time[None, :] - offsets[:, None]).ravel())
    if slow and problem.signal.gravity_measured:  # by orientation, which changes slowly
        x = np.zeros_like(seen.features)
        x[:, :3] = -(seen.world @ gravity)
    else:
        x = features_at(seen, None if problem.signal.gravity_measured else gravity)
    used = seen.known.reshape(O, K).astype(float)
    columns = [(x @ FULL_MAP).reshape(O, K, 6, 10)]
    if problem.free_gravity:
        along = -(seen.world @ tangents_of(gravity).T)
        for i in range(2):
            columns.append((along[:, :, i] @ FULL_MAP[:3]).reshape(O, K, 6, 10)[:, :, :, :4])
    hats = Hats.over(time, knots)
    functions = hats.combine(np.eye(hats.n))  # (K, n)
    bias = np.einsum("kn,cd->kcnd", functions, np.eye(6)).reshape(K, 6, -1)
    columns.append(np.broadcast_to(bias, (O, *bias.shape)))
    A = np.concatenate(columns, axis=3)
    p = A.shape[3]
    scale = np.broadcast_to(np.sqrt(np.mean((wrench - wrench.mean(axis=0)).reshape(K, 2, 3) ** 2, axis=(0, 2))), (O, 2))
    floor = np.maximum(problem.floor, 1e-12)
    scale = np.maximum(scale, floor)
    student = np.ones((O, K))
    count = np.maximum(used.sum(axis=1), 1.0)
    solution = np.zeros((O, p))
    square = u = np.zeros((O, K, 2))
    for _ in range(PASSES):
        root = np.sqrt(used * student)[:, :, None] / np.repeat(scale, 3, axis=1)[:, None, :]
        rows = (A * root[:, :, :, None]).reshape(O, 6 * K, p)
        turned = np.swapaxes(rows, 1, 2)
        N = turned @ rows
        b = (turned @ (wrench * root).reshape(O, 6 * K, 1))[:, :, 0]
        length = np.sqrt(np.maximum(np.diagonal(N, axis1=1, axis2=2), 0.0))
        length = np.where(length > 1e-150, length, 1.0)
        scaled = N / length[:, :, None] / length[:, None, :] + 1e-9 * np.eye(p)
        solution = np.linalg.solve(scaled, (b / length)[:, :, None])[:, :, 0] / length
        residual = wrench - (A.reshape(O, 6 * K, p) @ solution[:, :, None]).reshape(O, K, 6)
        square = np.sum(residual.reshape(O, K, 2, 3) ** 2, axis=3)
        for _ in range(2):
            u = np.einsum("okt,ot->ok", square, scale**-2.0)
            student = (FREEDOM + 6.0) / (FREEDOM + u)
            scale = np.sqrt(np.einsum("ok,okt->ot", used * student, square) / (3.0 * count[:, None]))
            scale = np.maximum(scale, floor)
    u = np.einsum("okt,ot->ok", square, scale**-2.0)
    tail = 0.5 * (FREEDOM + 6.0) * np.log1p(u / FREEDOM)
    likelihood = -np.sum(used * tail, axis=1) / count - 3.0 * np.log(scale).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    phi = solution[:, :10]
    tilt = np.zeros((O, 2))
    if problem.free_gravity:
        heavy = phi[:, :4] / np.array((1.0, 0.1, 0.1, 0.1))
        size = np.maximum(np.sum(heavy[:, :1] ** 2, axis=1), 1e-300)
        tilt = np.stack([solution[:, 10 + 4 * i] * phi[:, 0] / size for i in range(2)], axis=1)
    at = 10 + (8 if problem.free_gravity else 0)
    return _Trials(offsets, likelihood, phi, tilt, scale, solution[:, at:].reshape(O, hats.n, 6))
