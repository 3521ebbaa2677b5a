"""Small mistakes: whether a first step of any of them improves a fit significantly, so
that a search for mistakes is worth while."""

import itertools

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE, tangents_of
from hefting.ingest.rivals.cable import pulling_columns
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.elastic_grip import yielding_columns
from hefting.ingest.rivals.evidence import Fitted, LinearPart, correlation


def score(case: Case, fitted: Fitted) -> float:
    """Largest decrease of the weighted squared residuals by a first step of any small
    mistake, over the autocorrelation time."""
    columns, groups = _small_mistakes(case, fitted)
    S, g = LinearPart.of(fitted).beside(columns)
    # as for columns of length one, so that none is divided by zero
    precision = fitted.weights[0][:, None] / np.repeat(np.square(fitted.scale[0]), 3)
    length = np.sqrt(np.einsum("kcq,kcq,kc->q", columns, columns, precision))
    length = np.maximum(length, 1e-300)
    S, g = S / length / length[:, None] + 1e-6 * np.eye(len(g)), g / length
    scores = [g[part] @ np.linalg.solve(S[part, part], g[part]) for part in groups]
    return max(scores) / correlation(fitted)


def _small_mistakes(case: Case, fitted: Fitted) -> tuple[Array, list[slice]]:
    """(K, 6, q) derivatives of the wrench by small mistakes: a turn of the sensor, a
    tilt of gravity, a lever, a missing weight, uneven gains, a clock's rate, a soft
    grip, a cable, a steady change of the object; and the columns of each."""
    rows = fitted.rows
    known, phi = rows.known[0, :, :12], fitted.solution[0, :10]
    by_feature = REGRESSOR_BY_FEATURE @ phi
    wrench = known @ by_feature
    motion = case.motion_as_found
    K = len(wrench)
    turn = -np.cross(wrench.reshape(K, 2, 1, 3), np.eye(3)).transpose(0, 1, 3, 2)
    found = [turn.reshape(K, 6, 3), wrench[:, :, None] * np.eye(6)]
    if not case.path.gravity_measured:
        down = -(motion.axes[0] @ case.gravity)
        along = -(motion.axes[0] @ tangents_of(case.gravity).T)
        found.append(np.einsum("kxt,xc->kct", along, by_feature[:3]))
        weight = np.einsum("kx,xcp->kcp", down, REGRESSOR_BY_FEATURE[:3, :, :4])
        found.append(weight)
    if case.path.moves:
        by_feature_of_change = REGRESSOR_BY_FEATURE[:, :, :4].reshape(12, 24)
        lever = (known @ REGRESSOR_BY_FEATURE[:, :, 1:4].reshape(12, 18)).reshape(
            K, 6, 3
        )
        lever[:, 3:] = 0.0
        rate = np.gradient(wrench, case.time, axis=0)
        since = case.time - case.time.mean()
        found += [
            yielding_columns(known),
            lever,
            (since[:, None] * rate)[:, :, None],
            rate[:, :, None],
        ]
        if case.recording.has("position"):
            found += pulling_columns(case)
        change = (since[:, None] * known) @ by_feature_of_change
        found.append(change.reshape(K, 6, 4))
    ends = np.cumsum([0] + [part.shape[2] for part in found])
    groups = [slice(a, b) for a, b in itertools.pairwise(ends)]
    return np.concatenate(found, axis=2), groups
