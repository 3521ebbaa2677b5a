"""Errors of several recordings taken together: those that each has of its own, and
those that all share."""

from collections.abc import Sequence

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Noise
from hefting.core.spatial import Array
from hefting.estimators.quadratic import Quadratic, ScaledSVD
from hefting.ingest.ingest import tool_covariance
from hefting.ingest.ingested import Ingested


def shares_of(parts: Sequence[Ingested], noise: Noise) -> list[Array]:
    """P (10, 10) of each recording: by how much an error of its own least squares moves
    that of all."""
    free_bias = parts[0].bias == "estimate"
    rows = [Quadratic.of(part.state, noise, free_bias).A for part in parts]
    svd = ScaledSVD.of(np.concatenate(rows))
    half = svd.V.T / svd.S / svd.scale[:, None]
    return [half @ half.T @ (A.T @ A) for A in rows]


def common_errors(
    parts: Sequence[Ingested], noise: Noise, tool: Estimate | None
) -> tuple[Array | None, Array | None]:
    """(10, 10) covariance of the errors that all samples of a recording share: those of
    a tool in all recordings, those of each one's clock and of gravity's direction in
    it; and the error (10,) by one standard deviation of gravity's size, in all."""
    shares = shares_of(parts, noise)
    of_tool = tool_covariance(tool)
    systematic = np.zeros((10, 10)) if of_tool is None else of_tool.copy()
    size = np.zeros(10)
    for part, P in zip(parts, shares, strict=True):
        own = np.zeros((10, 10)) if part.systematic is None else part.systematic
        own = own if of_tool is None else own - of_tool
        if part.clock_error is not None:
            own = own + np.outer(part.clock_error, part.clock_error)
        systematic += P @ own @ P.T
        if part.gravity_error is not None:
            size += P @ part.gravity_error
    systematic = 0.5 * (systematic + systematic.T)
    return (
        systematic if systematic.any() else None,
        size if parts[0].gravity_error is not None else None,
    )
