"""Small mistakes: whether a first step of any of them improves a fit significantly, so
that a search for mistakes is worth while."""

import itertools

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE, tangents_of
from hefting.ingest.rivals.cable import pulling_columns
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.elastic import yielding_columns
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
    """(K, 6, q) derivatives of the wrench by small mistakes, and the columns of each."""
    known = fitted.rows.known[0, :, :12]
    by_feature = REGRESSOR_BY_FEATURE @ fitted.solution[0, :10]
    wrench, axes = known @ by_feature, case.motion_as_found.axes[0]
    K = len(wrench)
    turn = -np.cross(wrench.reshape(K, 2, 1, 3), np.eye(3)).transpose(0, 1, 3, 2)
    gains = wrench[:, :, None] * np.eye(6)
    found = [turn.reshape(K, 6, 3), gains]
    if not case.path.gravity_measured:
        along, down = -(axes @ tangents_of(case.gravity).T), -(axes @ case.gravity)
        tilt = np.einsum("kxt,xc->kct", along, by_feature[:3])
        missing = np.einsum("kx,xcp->kcp", down, REGRESSOR_BY_FEATURE[:3, :, :4])
        found += [tilt, missing]
    if case.path.moves:
        # of mass and first moment alone
        by_place = (known @ REGRESSOR_BY_FEATURE[:, :, :4].reshape(12, 24)).reshape(
            K, 6, 4
        )
        lever = by_place[:, :, 1:].copy()
        lever[:, 3:] = 0.0
        late = np.gradient(wrench, case.time, axis=0)[:, :, None]
        since = (case.time - case.time.mean())[:, None, None]
        found += [yielding_columns(known), lever, since * late, late]
        if case.recording.has("position"):
            found += pulling_columns(case)
        found.append(since * by_place)  # a steady change of the object
    ends = np.cumsum([0] + [part.shape[2] for part in found])
    groups = [slice(a, b) for a, b in itertools.pairwise(ends)]
    return np.concatenate(found, axis=2), groups
