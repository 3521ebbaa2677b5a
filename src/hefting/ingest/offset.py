"""Coarse clock offset between wrench and motion: a scan of the Student t likelihood of
the linear model over a grid."""

import numpy as np

from hefting.core.spatial import Array, immutable
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import Start
from hefting.ingest.model import (
    FEATURES,
    REGRESSOR_BY_FEATURE,
    Problem,
    tangents_of,
    tilt_gravity,
)
from hefting.ingest.path import MOTION_COLUMNS, WORLD_AXES_COLUMNS
from hefting.ingest.robust_rows import RobustRows, fit_each

COARSE_OFFSET_STEP = 0.02
"""[s] Spacing of the clock offsets of the first grid."""
FINE_OFFSET_STEP = 0.002
"""[s] Spacing of the second grid, about the best of the first one, which is used for
accelerometers: they measure vibrations too fast for the first grid."""
FIRST_SCAN_RANGE = 0.2
"""[s] Half the width of the first grid, doubled while the best offset is at an edge."""
MOST_DOUBLINGS = 3
"""Largest number of doublings of the grid's range."""
UNEXPLAINED_CHANGE_SHARE = 0.5
"""Ratio of residual scale to the wrench's standard deviation above which the range of
the grid is doubled."""
NEIGHBOURHOOD_OF_OFFSET = 0.1
"""[s] Distance from the best offset within which others do not compete with it."""
CLEAR_LOG_LIKELIHOOD_RATIO = 25.0
"""Log likelihood ratio to all distant offsets at which the best is accepted; it allows
for coloured noise."""
ALIKE = 2.0
"""Log likelihood ratio below which a search starts from the next offset towards zero,
where most clocks are, so that it takes fewer steps."""
LARGEST_OFFSET_SHARE = 0.15
"""Largest clock offset that is tried, as a share of the recording's duration."""
SCANNED_BLOCKS = 200
"""Number of blocks in the scan for a constant bias; 50 more for each further knot."""
SCAN_ITERATIONS = 4
"""Number of iterations of reweighted least squares at each offset."""


def scan_offsets(problem: Problem, gravity: Array, knots: int) -> Start:
    """Rough parameters, bias, scales, offset and gravity: those of the most likely
    clock offset of a grid.

    Where the offset is not free the grid is zero alone. Where the direction of `gravity`
    (3,), in world axes [m/s²], is free, it is found about it; the bias has `knots`.
    """
    chosen = problem.every(SCANNED_BLOCKS + 50 * (knots - 1))
    start = _scan_widening_range(problem, chosen, gravity, knots)
    if not (problem.free_offset and problem.path.gravity_measured):
        return start
    half = round(2.0 * COARSE_OFFSET_STEP / FINE_OFFSET_STEP)
    near = start.offset + FINE_OFFSET_STEP * np.arange(-half, half + 1, dtype=float)
    return _fit_at_offsets(chosen, gravity, knots, near)[0]


def _scan_widening_range(
    problem: Problem, chosen: Problem, gravity: Array, knots: int
) -> Start:
    """Fits at the `chosen` blocks over a coarse grid, whose range is doubled while the
    best offset is doubtful."""
    duration = float(problem.time[-1] - problem.time[0])
    limit = LARGEST_OFFSET_SHARE * duration
    changes = np.std(chosen.wrench, axis=0).reshape(2, 3).max(axis=1)
    half_range = min(FIRST_SCAN_RANGE, limit) if problem.free_offset else 0.0
    for _ in range(MOST_DOUBLINGS + 1):
        steps = int(half_range / COARSE_OFFSET_STEP)
        offsets = COARSE_OFFSET_STEP * np.arange(-steps, steps + 1, dtype=float)
        start, fits = _fit_at_offsets(
            chosen, gravity, knots, offsets, gravity_only=problem.path.gravity_measured
        )
        explained = bool((start.scale < UNEXPLAINED_CHANGE_SHARE * changes).all())
        inside = 1 < fits.best < len(offsets) - 2
        if half_range >= limit or (
            inside and (explained or _stands_out(fits, offsets, len(chosen.time)))
        ):
            break
        half_range = min(2.0 * half_range, limit)
    return start


def _stands_out(fits: RobustRows, offsets: Array, samples: int) -> bool:
    """Whether the best of the offsets (O,) is far more likely, for a number of
    `samples`, than all distant ones, so that it is accepted even if the residuals are
    large."""
    best = fits.best
    distant = np.abs(offsets - offsets[best]) > NEIGHBOURHOOD_OF_OFFSET
    others = fits.likelihood[distant]
    if not len(others):
        return False
    ratio = samples * float(fits.likelihood[best] - others.max())
    return ratio > CLEAR_LOG_LIKELIHOOD_RATIO


def _fit_at_offsets(
    problem: Problem,
    gravity: Array,
    knots: int,
    offsets: Array,
    *,
    gravity_only: bool = False,
) -> tuple[Start, RobustRows]:
    """Robust least squares at each of the offsets (O,) [s], by iterative reweighting
    with Student t weights; and the most likely of them.

    With `gravity_only` the motion is gravity, from the orientation, alone: it changes
    slowly enough for a coarse grid.
    """
    design = Design.of(problem, gravity, knots, offsets, gravity_only=gravity_only)
    floor = np.maximum(problem.floor, 1e-12)
    fits = fit_each(design.known, design.maps, design.used, floor, SCAN_ITERATIONS)
    # vibrations have a maximum each some milliseconds
    measured, samples = problem.path.gravity_measured, len(problem.time)
    best = fits.best if measured else _to_start_from(fits, offsets, samples)
    solution = fits.solution[best]
    start = Start(
        phi=solution[:10],
        offset=float(offsets[best]),
        gravity=tilt_gravity(gravity, design.tilt_of(solution)),
        scale=fits.scale[best],
        knots=HatFunctions.over(problem.time, knots).knots,
        bias=solution[design.first_bias_column :].reshape(-1, 6),
    )
    return start, fits


def _to_start_from(fits: RobustRows, offsets: Array, samples: int) -> int:
    """Index of the most likely of the offsets (O,) of a grid about zero, or of the next
    towards zero where that is about as likely."""
    best = fits.best
    nearer = best - int(np.sign(offsets[best]))
    enough = fits.likelihood[best] - ALIKE / samples
    return nearer if fits.likelihood[nearer] > enough else best


@immutable
class Design:
    """The linear model at each of O offsets.

    The known row of a sample is z = [motion features (12), gravity's tangents (6, if
    free), bias functions (n)]; see `hefting.ingest.robust_rows`.
    """

    known: Array
    """(O, K, z + 6) rows, followed by the wrench"""
    used: Array
    """(O, K) 1 where the motion is known, else 0"""
    maps: Array
    """(z, 6, p) columns per unit of `known`: ten parameters, four for each tangent of
    gravity, 6 n of the bias"""
    first_bias_column: int

    @classmethod
    def of(
        cls,
        problem: Problem,
        gravity: Array,
        knots: int,
        offsets: Array,
        *,
        gravity_only: bool,
    ) -> "Design":
        """For the arguments of `_fit_at_offsets`."""
        time, wrench = problem.time, problem.wrench
        K, O = len(time), len(offsets)
        motion = problem.path.at(
            (time[None, :] - offsets[:, None]).ravel(), spread=False
        )
        into_sensor = motion.value[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3)
        features = motion.value[:, MOTION_COLUMNS].copy()
        if gravity_only:
            features = np.zeros_like(features)
            features[:, :3] = -(into_sensor @ gravity)
        elif not problem.path.gravity_measured:
            features[:, :3] -= into_sensor @ gravity
        parts = [features.reshape(O, K, FEATURES)]
        tangents = 2 if problem.free_gravity else 0
        if tangents:
            along = -(into_sensor @ tangents_of(gravity).T)
            parts.append(np.swapaxes(along, 1, 2).reshape(O, K, 6))
        hats = HatFunctions.over(time, knots)
        parts += [
            np.broadcast_to(hats.values, (O, K, hats.n)),
            np.broadcast_to(wrench, (O, K, 6)),
        ]
        known = np.concatenate(parts, axis=2)
        maps = _column_maps(known.shape[2] - 6, tangents, hats.n)
        return cls(
            known, motion.known.reshape(O, K).astype(float), maps, 10 + 4 * tangents
        )

    def tilt_of(self, solution: Array) -> Array:
        """(2,) change of gravity along its tangents [m/s²] from a solution (p,); zero
        if it is not free. The first of a tangent's four unknowns is the mass times that
        change."""
        if self.first_bias_column == 10:
            return np.zeros(2)
        mass = solution[0]
        return solution[[10, 14]] * mass / np.maximum(mass**2, 1e-300)


def _column_maps(width: int, tangents: int, functions: int) -> Array:
    """`Design.maps`: ten parameters, then for each tangent of gravity its products with
    mass and first moment, then the bias at the knots."""
    first_bias_column = 10 + 4 * tangents
    maps = np.zeros((width, 6, first_bias_column + 6 * functions))
    maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
    for i in range(tangents):
        rows = slice(FEATURES + 3 * i, FEATURES + 3 * i + 3)
        maps[rows, :, 10 + 4 * i : 14 + 4 * i] = REGRESSOR_BY_FEATURE[:3, :, :4]
    first_function = FEATURES + 3 * tangents
    for j in range(functions):
        column = first_bias_column + 6 * j
        maps[first_function + j, :, column : column + 6] = np.eye(6)
    return maps
