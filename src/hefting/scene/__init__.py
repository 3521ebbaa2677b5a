"""Scene: the drawn parts of an object, as plain data for any renderer.

    scene = scene_of(estimates={"estimate": found.estimate}, shape=shape)
    headline_of(found.estimate).lines

All lengths are in metres, in sensor axes about the sensor origin.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Indices, frozen, immutable
from hefting.scene.headline import (
    Headline,
    depth_of,
    headline_of,
    inertia_doubt,
    place_of,
    plus_minus,
    power_of_thousand,
    vector_text,
)
from hefting.scene.surface import (
    Ellipsoid,
    Surface,
    com_reach,
    com_region,
    reach,
    surface_of,
    uniform_ellipsoid,
)
from hefting.shapes import Shape

__all__ = [
    "Body",
    "Ellipsoid",
    "Headline",
    "PointSet",
    "Scene",
    "Surface",
    "WrenchCurves",
    "com_reach",
    "com_region",
    "depth_of",
    "gaps_between",
    "headline_of",
    "place_of",
    "plus_minus",
    "power_of_thousand",
    "reach",
    "scene_of",
    "surface_of",
    "thinned",
    "uniform_ellipsoid",
    "vector_text",
    "wrench_curves",
]

LARGEST_DOUBT = 0.75
"""`inertia_doubt` from which on no ellipsoid is drawn: its axes may be half as long, or a
third longer."""
BOTH = np.array(((-1.0,), (1.0,)))
"""Signs of the two ends of an extent about a center."""
LEAST_SIZE = 0.2
"""[m] Distance from the COM up to which its region is always shown."""
MOST_POINTS = 3_000
"""Most points of a cloud that are drawn."""
MOST_DIRECTIONS = 40
"""Most directions of gravity that are drawn."""


@immutable
class PointSet:
    """Points of a shape, and their masses as found by a method."""

    positions: Array
    """(n, 3) [m]"""
    masses: Array | None = None
    """(n,) [kg]; not unique for given ten parameters"""


@immutable
class Body:
    """The drawn parts of one rigid body."""

    name: str
    """Such as ``"estimate"`` or ``"truth"``"""
    center: Array
    """(3,) COM [m]; NaN along an axis on which it is open"""
    region: Ellipsoid | None = None
    """Holds the COM with 95 % probability; None if unknown"""
    ellipsoid: Ellipsoid | None = None
    """Has uniform density and equal inertia; None if the inertia is not determined, or no
    body has it"""
    inertia_doubt: float | None = None
    """Half the width of the widest 95 % interval of the moments over the largest moment;
    None if unknown, infinite if open"""
    missing: str = ""
    """Reason why there is no ellipsoid"""
    reach: Array | None = None
    """(3,) half-widths of the COM's 95 % intervals [m], not finite along an axis on which
    it is open; None if unknown"""

    @property
    def open_axes(self) -> str:
        """Names of the axes along which the COM is open: ``"x and z"``."""
        return " and ".join("xyz"[k] for k in np.flatnonzero(np.isnan(self.center)))


@immutable
class Scene:
    """All drawn parts, in sensor axes about the sensor origin; the axes are drawn too."""

    bodies: tuple[Body, ...] = ()
    surface: Surface | None = None
    points: PointSet | None = None
    gravity: Array | None = None
    """(K, 3) unit vectors along gravity in sensor axes; None without a log"""

    def with_centers_only(self) -> Self:
        """The same scene without ellipsoids of inertia and reasons for missing ones."""
        bodies = tuple(
            replace(body, ellipsoid=None, inertia_doubt=None, missing="")
            for body in self.bodies
        )
        return replace(self, bodies=bodies)

    @property
    def corners(self) -> Array:
        """Points (n, 3) [m] whose bounding box holds all parts, but a COM region larger
        than all others only in part."""
        parts = [np.zeros((1, 3))]
        parts += [] if self.surface is None else [self.surface.vertices]
        parts += [] if self.points is None else [self.points.positions]
        for body in self.bodies:
            parts.append(np.nan_to_num(body.center)[None])
            if body.ellipsoid is not None:
                reach = body.ellipsoid.reach
                parts.append(body.ellipsoid.center + BOTH * reach)
        size = np.ptp(np.vstack(parts), axis=0).max()
        for body in self.bodies:
            if body.region is not None:
                reach = np.minimum(body.region.reach, max(size, LEAST_SIZE))
                parts.append(body.region.center + BOTH * reach)
            elif body.reach is not None:
                known = np.where(np.isfinite(body.reach), body.reach, 0.0)
                reach = np.minimum(known, max(size, LEAST_SIZE))
                parts.append(np.nan_to_num(body.center) + BOTH * reach)
        return np.vstack(parts)


def scene_of(
    estimates: Mapping[str, Estimate | None] | None = None,
    shape: Shape | None = None,
    known: Mapping[str, InertialParameters | None] | None = None,
    gravity: ArrayLike | None = None,
    masses: bool = False,
) -> Scene:
    """The scene of an object: `estimates` and exactly `known` bodies, such as the truth,
    by name; None is ignored.

    An unknown shape is not drawn. `gravity` (K, 3) is in sensor axes, of any length. With
    `masses` the point masses of the first estimate that has some are drawn at the points
    of the shape: `InputError` unless there is one for each point.
    """
    bodies = [
        Body(name, body.center_of_mass, ellipsoid=uniform_ellipsoid(body))
        for name, body in (known or {}).items()
        if body is not None
    ]
    found = {name: each for name, each in (estimates or {}).items() if each is not None}
    bodies += [_estimated_body(name, estimate) for name, estimate in found.items()]
    surface = None if shape is None else surface_of(shape)
    points = None
    if shape is not None and masses:
        points = PointSet(shape.positions, _masses(shape, found))
    elif shape is not None and surface is None and shape.known == "object":
        step = -(-len(shape.hull) // MOST_POINTS)
        points = PointSet(shape.hull[::step])
    directions = None if gravity is None else _directions(gravity)
    return Scene(tuple(bodies), surface, points, directions)


def _estimated_body(name: str, estimate: Estimate) -> Body:
    """The body of an estimate, without its open parts."""
    half = com_reach(estimate)
    center = np.array(estimate.parameters.center_of_mass)
    if half is not None:
        center[np.isinf(half)] = np.nan
    ellipsoid = uniform_ellipsoid(estimate.parameters)
    missing = "" if ellipsoid is not None else "no body has this inertia"
    doubt = inertia_doubt(estimate)
    if doubt is not None and not doubt < LARGEST_DOUBT:
        ellipsoid, missing = None, "inertia open"
        if np.isfinite(doubt):
            missing = f"inertia known to ± {100 * doubt:.0f} % only"
    return Body(name, center, com_region(estimate), ellipsoid, doubt, missing, half)


def _masses(shape: Shape, estimates: Mapping[str, Estimate]) -> Array | None:
    """(n,) [kg] of the first estimate that has point masses; see `scene_of`."""
    for estimate in estimates.values():
        if estimate.point_masses is not None:
            if len(estimate.point_masses) != shape.n:
                raise InputError(
                    f"the estimate has {len(estimate.point_masses)} point masses, the "
                    f"shape {shape.n} points",
                    fix="give the shape that the estimate was made with",
                )
            return estimate.point_masses
    return None


def _directions(gravity: ArrayLike) -> Array | None:
    """Unit vectors along at most `MOST_DIRECTIONS` rows of gravity, evenly chosen."""
    rows = np.asarray(gravity, dtype=float).reshape(-1, 3)
    rows = rows[np.linalg.norm(rows, axis=1) > 0.0]
    if not len(rows):
        return None
    shown = np.linspace(0, len(rows) - 1, min(len(rows), MOST_DIRECTIONS))
    chosen = rows[np.unique(shown.astype(np.intp))]
    return frozen(chosen / np.linalg.norm(chosen, axis=1)[:, None])


PARTS = (("Force", "N", 0), ("Torque", "N m", 3))
"""Name, unit and first column of the two parts of a wrench."""
MOST = 2_000
"""Most drawn samples of a curve: two for each pixel column of a wide screen."""
GAP = 5.0
"""Time step over the median one above which a curve is interrupted."""


@immutable
class WrenchCurves:
    """Wrenches at K instants, exerted by the sensor on the object, in sensor axes."""

    time: Array
    """(K,) [s]; of static poses their number, counted from 1"""
    measured: Array
    """(K, 6) force [N] and torque [N m]"""
    predicted: Array
    """(K, 6) by the estimate, with its bias"""
    static: bool
    """Whether the instants are static poses."""

    @property
    def residual(self) -> Array:
        """(K, 6) measured minus predicted."""
        return self.measured - self.predicted

    def rms(self, first: int) -> float:
        """Root mean square of the residual of the force (0) or of the torque (3)."""
        return float(np.sqrt(np.mean(self.residual[:, first : first + 3] ** 2)))


def wrench_curves(
    measurements: Measurements, estimate: Estimate, start: float | None = None
) -> WrenchCurves:
    """The measured wrench, and the one predicted by an estimate from these measurements,
    which are static poses if it has no duration. `start` is the time [s] that counts as
    zero, by default that of the first measurement."""
    static = estimate.duration is None
    predicted = predict_wrench(measurements, estimate.parameters.vector)
    predicted = predicted + _bias_of_each(estimate, len(measurements))
    begin = measurements.time[0] if start is None else start
    time = measurements.time - begin
    if static:
        time = np.arange(1.0, len(measurements) + 1.0)
    return WrenchCurves(time, measurements.wrench, predicted, static)


def _bias_of_each(estimate: Estimate, samples: int) -> Array:
    """(K, 6) or (6,) bias of K samples; zero if unknown."""
    bias = estimate.bias
    if bias is None or bias.ndim == 1:
        return np.zeros(6) if bias is None else bias
    try:  # provenance from a file may be anything
        rows = [int(each["rows"]) for each in estimate.provenance["recordings"]]
    except (KeyError, TypeError, ValueError, OverflowError):
        return np.zeros(6)
    if len(rows) != len(bias) or min(rows) < 0 or sum(rows) != samples:
        return np.zeros(6)
    return np.repeat(bias, rows, axis=0)


def gaps_between(time: Array, shown: Indices) -> Indices:
    """Positions in `shown`, indices of times (K,) [s], before which there is a gap."""
    steps = np.diff(time)
    if not len(steps):
        return np.zeros(0, dtype=np.intp)
    before = np.append(0, np.cumsum(steps > GAP * np.median(steps)))
    return 1 + np.flatnonzero(np.diff(before[shown]))


def thinned(values: ArrayLike, most: int = MOST) -> Indices:
    """Indices of at most `most` (2 c + 2 or more) samples of c curves (K, c), or one
    (K,), with common times; NaN is ignored.

    They are all samples of short curves; otherwise the first and the last, and in each of
    several parts of equal length the lowest and the highest of each curve, which keeps
    the peaks.
    """
    columns = np.asarray(values, dtype=float)
    columns = columns.reshape(len(columns), -1)
    if len(columns) <= most:
        return np.arange(len(columns))
    parts = (most - 2) // (2 * columns.shape[1])
    length = -(-len(columns) // parts)
    padded = np.full((parts * length, columns.shape[1]), np.nan)
    padded[: len(columns)] = columns
    blocks = padded.reshape(parts, length, -1)
    begin = length * np.arange(parts)[:, None]
    lowest = begin + np.where(np.isnan(blocks), np.inf, blocks).argmin(axis=1)
    highest = begin + np.where(np.isnan(blocks), -np.inf, blocks).argmax(axis=1)
    chosen = np.unique((lowest, highest))
    chosen = np.append(chosen[chosen < len(columns)], (0, len(columns) - 1))
    return np.unique(chosen)
