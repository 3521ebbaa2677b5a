"""Explanations of a recording: with a mistake or without, each fitted to it; and `Undone`,
a recording from which one mistake is removed, in which others are searched for."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field, fields, replace
from functools import partial
from typing import Self
from weakref import WeakKeyDictionary

import numpy as np

from hefting.core.recording import Recording
from hefting.core.spatial import WRENCH, Array, immutable
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.path import Path, path_of, static_path
from hefting.ingest.rivals.case import FINE_OFFSETS, Case, Motion
from hefting.ingest.rivals.evidence import (
    ITERATIONS,
    Fitted,
    Rows,
    fit_free_channels,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.robust_rows import RobustRows

OFFSET_STEP = 2e-3
"""[s] Half of the step of the numerical derivative by the clock offset."""
HEAVIEST_HELD = 200.0
"""[kg] Largest mass that a wrist with a force-torque sensor holds."""
_FITS_AS_GIVEN: WeakKeyDictionary[Case, tuple[Fitted, float]] = WeakKeyDictionary()
Build = Callable[[Motion], Rows]
"""Rows of the model for the motion at O clock offsets."""

FINEST_OFFSETS = 0.2 * FINE_OFFSETS
"""[s] Clock offsets about the best of the fine ones."""
FIRST_ITERATIONS = 3
"""Number of reweightings after which clock offsets are compared."""
INERTIAL = "gyroscope", "accelerometer", "linear_accelerometer"
"""Streams of inertial sensors, which are not used for the path of the poses alone."""
_PATHS: WeakKeyDictionary[Path, dict[str, Path | None]] = WeakKeyDictionary()
"""Motions that `with_poses` made, by the case's motion and the mistake: several searches
undo the same mistakes."""


@immutable
class Mistake:
    """What may be wrong with a recording."""

    code: str
    """code of the message that names it; ``"as-given"`` for no mistake"""
    what: str
    """what would be wrong, as a clause: "the sensor's axes are turned by 30°" """
    fix: str
    """what to do about it, as an imperative"""
    argument: str | None = field(default=None, kw_only=True)
    """argument of the library with which the user can act on it"""
    rarity: float = field(default=0.0, kw_only=True)
    """negative log of how common the mistake is, over that of the most common ones"""
    is_grave: bool = field(default=False, kw_only=True)
    """whether it makes the answer wrong whatever it does to mass and COM"""


@immutable
class Explanation(Mistake):
    """One way to understand a recording: as it was given, or with a mistake in it."""

    fitted: Fitted
    unknowns: int
    """unknowns besides those of a recording as given"""
    cost: float | None = None
    """log-likelihood that the unknowns cost, where their usual size is known; None for
    Schwarz's criterion"""
    parameters: Array | None = None
    """(10,) of the object, with the sign of the recorded wrench, if the explanation is
    right; None where they are those of `fitted`"""
    effect: float | None = None
    """size of the mistake over its standard deviation, where that was found"""
    alternative: Callable[[], "Explanation | None"] | None = None
    """finds a larger or smaller mistake of the same kind, where this is the likeliest"""
    is_change: bool = False
    """whether the object changes with time"""
    of_many_laws: bool = False
    """whether the true law may differ from the fitted one, which then explains only a
    part"""

    @property
    def vector(self) -> Array:
        """(10,) parameters of the object, in the recorded wrench's sign."""
        if self.parameters is not None:
            return self.parameters
        return self.fitted.solution[self.fitted.best][:10]

    @property
    def is_too_heavy(self) -> bool:
        """Whether the object is heavier than a wrist holds."""
        return abs(self.vector[0]) > HEAVIEST_HELD

    @property
    def likelihood(self) -> float:
        """Log-likelihood of one sample on average, up to a constant."""
        return float(self.fitted.likelihood[self.fitted.best])


def as_columns(matrix: Array) -> str:
    """Entry of a column map for the wrench times a signed permutation (6, 6)."""
    names = [
        ("-" if row.sum() < 0.0 else "") + WRENCH[np.abs(row).argmax()]
        for row in matrix
    ]
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"


def over_offsets(
    case: Case, build: Build, iterations: int = FIRST_ITERATIONS
) -> tuple[Fitted, float]:
    """The fit at the likeliest clock offset, and that offset [s]; `iterations` is the
    number of reweightings after which the coarse offsets are compared."""
    if not case.path.moves:
        return fit_rows(case, build(case.motion)), 0.0
    coarse = fit_rows(case, build(case.motion), iterations)
    near = case.offsets[coarse.best] + FINE_OFFSETS
    fine = fit_rows(case, build(case.motion_late(near)))
    return fine, float(near[fine.best])


def newton_euler(case: Case, motion: Motion, wrench: Array | None = None) -> Rows:
    """Rows of the Newton-Euler model: ten parameters and a bias."""
    features = case.features(motion)
    return with_bias(case, features, REGRESSOR_BY_FEATURE, motion.known, wrench)


def fit_as_given(case: Case) -> tuple[Fitted, float]:
    """The fit of the recording without a mistake at its likeliest clock offset, and that
    offset [s]. It is kept, as many mistakes start from it."""
    if case not in _FITS_AS_GIVEN:
        build = partial(newton_euler, case)
        _FITS_AS_GIVEN[case] = over_offsets(case, build, ITERATIONS)
    return _FITS_AS_GIVEN[case]


def explains_nothing(case: Case, build: Build) -> bool:
    """Whether a model, and so every mistake that is a special case of it, is hopeless at
    all coarse clock offsets (`is_hopeless`)."""
    quick = fit_rows(case, build(case.motion), FIRST_ITERATIONS)
    return is_hopeless(case, quick, fit_as_given(case)[0])


def as_given(case: Case) -> Explanation:
    """The recording without a mistake."""
    fitted, _ = fit_as_given(case)
    return Explanation(code="as-given", what="", fix="", fitted=fitted, unknowns=0)


def of_each_wrench(
    case: Case, rows: Rows, wrenches: Array, iterations: int = ITERATIONS
) -> Fitted:
    """Fits of M wrenches (M, K, 6) at the O clock offsets of `rows`: O fits of the first
    wrench, then O of the second."""
    M, O = len(wrenches), len(rows.known)
    known, used = np.tile(rows.known, (M, 1, 1)), np.tile(rows.used, (M, 1))
    repeated = np.repeat(wrenches, O, axis=0)
    return fit_rows(case, Rows(known, rows.maps, used, repeated), iterations)


@immutable
class Around:
    """A fit at a clock offset, and the models for a numerical derivative by the offset."""

    fitted: Fitted
    motion: Motion
    """at the offset, then `OFFSET_STEP` before and after it, unless nothing moves"""
    rows: Rows
    """of the model `OFFSET_STEP` before and after the offset, unless nothing moves"""

    @classmethod
    def of(
        cls, case: Case, build: Build, offset: float, start: Fitted | None = None
    ) -> Self:
        """At an offset [s]; `start` is the fit of a similar model."""
        steps = np.array((0.0, -1.0, 1.0) if case.path.moves else (0.0,)) * OFFSET_STEP
        motion = case.motion_late(offset + steps)
        rows = build(motion)
        fitted = fit_rows(case, rows.part(slice(1)), start=start)
        return cls(fitted, motion, rows.part(slice(1, None)))

    @property
    def offset_columns(self) -> Array:
        """(K, 6, 1) derivative of the wrench by the clock offset."""
        before, after = self.rows.predict(self.fitted.solution[0])
        return ((after - before) / (2.0 * OFFSET_STEP))[:, :, None]


def at_offset(case: Case, build: Build, offset: float) -> Fitted:
    """The fit at one clock offset [s]."""
    return fit_rows(case, build(case.motion_late(offset)))


def explained_by_motion(case: Case) -> Iterator[tuple[RobustRows, float]]:
    """Fits of free channels on three grids of clock offsets, each finer about the best of
    the one before, with the best offset [s] of each grid."""
    if not case.path.moves:
        yield _fit(case, case.motion, ITERATIONS), 0.0
        return
    near, iterations = case.offsets, FIRST_ITERATIONS
    for step in (FINE_OFFSETS, FINEST_OFFSETS, None):
        fitted = _fit(case, case.motion_late(near), iterations)
        offset = float(near[fitted.best])
        yield fitted, offset
        if step is not None:
            near, iterations = offset + step, ITERATIONS


def _fit(case: Case, motion: Motion, iterations: int) -> RobustRows:
    """Free channels as functions of features, orientation and the bias's functions."""
    shape = motion.known.shape
    functions = case.bias_functions
    known: list[Array] = [
        case.features(motion),
        motion.axes.reshape(*shape, 9),
        np.broadcast_to(functions, (len(motion.known), *functions.shape)),
    ]
    return fit_free_channels(
        case, np.concatenate(known, axis=2), motion.known, iterations
    )


@immutable
class Undone(Mistake):
    """A mistake without unknowns, and the recording from which it is removed."""

    case: Case
    """the recording, with the mistake undone"""
    log_scale: float = 0.0
    """log of the factor by which undoing it multiplies volumes of the wrench's space"""
    is_linear: bool = False
    """whether free channels fit the recording equally well with and without it"""

    def explanation(self, fitted: Fitted | None = None) -> Explanation:
        """The mistake as an explanation, by a fit to the recording without it, by default
        one at the likeliest clock offset."""
        if fitted is None:
            fitted, _ = over_offsets(self.case, partial(newton_euler, self.case))
        own = {each.name: getattr(self, each.name) for each in fields(Mistake)}
        return Explanation(**own, fitted=fitted, unknowns=0)


def likeliest(each: Iterable[Undone]) -> Explanation | None:
    """The likeliest of mistakes that exclude one another; None where there is none."""
    found = [undone.explanation() for undone in each]
    return max(found, key=lambda other: other.likelihood, default=None)


def with_poses(case: Case, what: str, recording: Recording) -> Case | None:
    """The case with the poses of `recording`, in which the mistake `what` is corrected;
    None where they have no motion, or the case's motion is not of poses."""
    if case.path.kind in ("columns", "accelerometer"):
        return None
    found = _PATHS.setdefault(case.path, {})
    if what not in found:
        found[what] = _path_of_poses(case, recording)
    path = found[what]
    return None if path is None else replace(case, recording=recording, path=path)


def _path_of_poses(case: Case, recording: Recording) -> Path | None:
    """The motion of the poses of a recording, without its inertial sensors."""
    if not case.path.moves:
        return static_path(recording)
    streams = recording.streams.items()
    others = {name: each for name, each in streams if name not in INERTIAL}
    return path_of(replace(recording, streams=others), "auto", case.gravity)
