"""Explanation: one way to understand a recording, fitted to it; and `Undone`, a recording
without one mistake, in which others are looked for."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field, fields, replace
from functools import partial
from typing import Self
from weakref import WeakKeyDictionary

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.core.spatial import WRENCH, Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.path import Path, path_of, static_path
from hefting.ingest.rivals.case import FINE_OFFSETS, Case, Motion
from hefting.ingest.rivals.evidence import (
    ITERATIONS,
    Fitted,
    Rows,
    fit_freely,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.robust_rows import RobustRows

OFFSET_STEP = 2e-3
"""[s] Half of the step of the numerical derivative by the clock offset."""
HEAVIEST_HELD = 200.0
"""[kg] Mass above which an explanation is none, as no wrist with such a sensor holds
it."""
_FITS_AS_GIVEN: WeakKeyDictionary[Case, tuple[Fitted, float]] = WeakKeyDictionary()
Build = Callable[[Motion], Rows]
"""Rows of the model for the motion at O clock offsets."""

FINEST_OFFSETS = 0.2 * FINE_OFFSETS
"""[s] Clock offsets about the best of the fine ones: mistakes are refined beside it."""
FIRST_ITERATIONS = 3
"""Reweightings by which offsets are compared."""
INERTIAL = "gyroscope", "accelerometer", "linear_accelerometer"
"""Streams on which the path of the poses does not depend."""
_PATHS: WeakKeyDictionary[Path, dict[str, Path | None]] = WeakKeyDictionary()
"""Motions that `with_poses` read, by that of the case and by what would be wrong: several
searches undo the same mistakes."""


@immutable
class Mistake:
    """What may be wrong of a recording."""

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
    """(10,) of the object in the recorded wrench's sign, if it is so; None where they
    are those of `fitted`"""
    effect: float | None = None
    """size of the mistake over its standard deviation, where that was found"""
    alternative: Callable[[], "Explanation | None"] | None = None
    """a larger or smaller mistake of the same kind, tried where this one is the
    likeliest"""
    is_change: bool = False
    """whether it is a change of the object with time, as one at an instant may be"""
    of_many_laws: bool = False
    """whether another law may hold than was fitted, which then explains a part only"""

    @property
    def vector(self) -> Array:
        """(10,) parameters of the object, in the recorded wrench's sign."""
        if self.parameters is not None:
            return self.parameters
        return self.fitted.solution[self.fitted.best][:10]

    @property
    def likelihood(self) -> float:
        """Log-likelihood of one sample on average, up to a constant."""
        return float(self.fitted.likelihood[self.fitted.best])


def as_columns(matrix: Array) -> str:
    """Columns of the wrench in a column map that a signed permutation (6, 6) makes."""
    names = [
        ("-" if row.sum() < 0.0 else "") + WRENCH[np.abs(row).argmax()]
        for row in matrix
    ]
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"


def over_offsets(
    case: Case, build: Build, iterations: int = FIRST_ITERATIONS
) -> tuple[Fitted, float]:
    """The fit at the likeliest clock offset near the coarse ones, which so many
    reweightings compare, and that offset [s]."""
    if not case.path.moves:
        return fit_rows(case, build(case.motion)), 0.0
    coarse = fit_rows(case, build(case.motion), iterations)
    near = case.offsets[coarse.best] + FINE_OFFSETS
    fine = fit_rows(case, build(case.motion_late(near)))
    return fine, float(near[fine.best])


def newton_euler(case: Case, motion: Motion, wrench: Array | None = None) -> Rows:
    """Rows of the model of a body as given: ten parameters and a bias."""
    features = case.features(motion)
    return with_bias(case, features, REGRESSOR_BY_FEATURE, motion.known, wrench)


def fit_as_given(case: Case) -> tuple[Fitted, float]:
    """The fit of the recording without a mistake at its likeliest clock offset, and that
    offset [s]: many mistakes start from it, so it is made once a case."""
    if case not in _FITS_AS_GIVEN:
        build = partial(newton_euler, case)
        _FITS_AS_GIVEN[case] = over_offsets(case, build, ITERATIONS)
    return _FITS_AS_GIVEN[case]


def explains_nothing(case: Case, build: Build) -> bool:
    """Whether a model is hopeless at all of the coarse clock offsets, and with it every
    mistake that is a special case of it."""
    quick = fit_rows(case, build(case.motion), FIRST_ITERATIONS)
    return is_hopeless(case, quick, fit_as_given(case)[0])


def as_given(case: Case) -> Explanation:
    """The recording without a mistake."""
    fitted, _ = fit_as_given(case)
    return Explanation(code="as-given", what="", fix="", fitted=fitted, unknowns=0)


def of_each_wrench(
    case: Case, rows: Rows, wrenches: Array, iterations: int = ITERATIONS
) -> Fitted:
    """Fits of each of the wrenches (M, K, 6) at each of the O offsets of rows: the
    offsets of the first wrench, then those of the next."""
    M, O = len(wrenches), len(rows.known)
    known, used = np.tile(rows.known, (M, 1, 1)), np.tile(rows.used, (M, 1))
    repeated = np.repeat(wrenches, O, axis=0)
    return fit_rows(case, Rows(known, rows.maps, used, repeated), iterations)


@immutable
class Around:
    """A fit at a clock offset, and the model a little before and after it."""

    fitted: Fitted
    motion: Motion
    """at the offset first"""
    rows: Rows
    """`OFFSET_STEP` before and after it; none where nothing moves"""

    @classmethod
    def of(
        cls, case: Case, build: Build, offset: float, start: Fitted | None = None
    ) -> Self:
        """At an offset [s]; `start` is a fit of nearly the same."""
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
    """The fits of free channels at clock offsets closer and closer to the likeliest one,
    each better than the one before, and that offset [s]."""
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
    shape = motion.known.shape
    functions = case.bias_functions
    known: list[Array] = [
        case.features(motion),
        motion.axes.reshape(*shape, 9),
        np.broadcast_to(functions, (len(motion.known), *functions.shape)),
    ]
    return fit_freely(case, np.concatenate(known, axis=2), motion.known, iterations)


@immutable
class Undone(Mistake):
    """A mistake without unknowns, and the recording without it."""

    case: Case
    """the recording, with the mistake undone"""
    log_scale: float = 0.0
    """log of the factor by which undoing it multiplies volumes of the wrench's space"""
    is_linear: bool = False
    """whether free channels explain the recording with it as well as without"""

    def explanation(self, fitted: Fitted | None = None) -> Explanation:
        """The mistake alone, by a fit to the recording without it; by default that at the
        likeliest clock offset."""
        if fitted is None:
            fitted, _ = over_offsets(self.case, partial(newton_euler, self.case))
        own = {each.name: getattr(self, each.name) for each in fields(Mistake)}
        return Explanation(**own, fitted=fitted, unknowns=0)


def likeliest(each: Iterable[Undone]) -> Explanation | None:
    """The likeliest of mistakes that exclude one another; None where there is none."""
    found = [undone.explanation() for undone in each]
    return max(found, key=lambda other: other.likelihood, default=None)


def with_poses(case: Case, what: str, recording: Recording) -> Case | None:
    """The case with the poses of another recording, in which `what` would be wrong is put
    right; None where there is no motion in them."""
    if case.path.kind in ("columns", "accelerometer"):
        return None
    found = _PATHS.setdefault(case.path, {})
    if what not in found:
        found[what] = _path_of_poses(case, recording)
    path = found[what]
    return None if path is None else replace(case, recording=recording, path=path)


def _path_of_poses(case: Case, recording: Recording) -> Path | None:
    """The motion by the poses alone."""
    if not case.path.moves:
        return static_path(recording)
    streams = recording.streams.items()
    others = {name: each for name, each in streams if name not in INERTIAL}
    return path_of(replace(recording, streams=others), "auto", case.gravity)
