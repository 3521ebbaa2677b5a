"""Undone: a recording without one mistake, in which others are looked for."""

from collections.abc import Iterable
from dataclasses import replace
from weakref import WeakKeyDictionary

from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.ingest.path import Path, path_of, static_path
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

INERTIAL = "gyroscope", "accelerometer", "linear_accelerometer"
"""Streams on which the path of the poses does not depend."""
_PATHS: WeakKeyDictionary[Path, dict[str, Path | None]] = WeakKeyDictionary()
"""Motions that `with_poses` read, by that of the case and by what would be wrong: several
searches undo the same mistakes."""


@immutable
class Undone:
    """A mistake without unknowns, and the recording without it."""

    code: str
    """code of the message that names it"""
    what: str
    """what would be wrong, as a clause"""
    fix: str
    """what to do about it, as an imperative"""
    case: Case
    """the recording, with the mistake undone"""
    argument: str | None = None
    """argument of the library with which the user can act on it"""
    rarity: float = 0.0
    """as that of an `Explanation`"""
    is_grave: bool = False
    """as that of an `Explanation`"""
    log_scale: float = 0.0
    """log of the factor by which undoing it multiplies volumes of the wrench's space"""
    is_linear: bool = False
    """whether free channels explain the recording with it as well as without"""

    def explanation(self, fitted: Fitted | None = None) -> Explanation:
        """The mistake alone, by a fit to the recording without it; by default that at the
        likeliest clock offset."""
        if fitted is None:
            case = self.case
            fitted, _ = over_offsets(case, lambda motion: newton_euler(case, motion))
        return Explanation(
            self.code,
            self.what,
            self.fix,
            fitted,
            0,
            rarity=self.rarity,
            argument=self.argument,
            is_grave=self.is_grave,
        )


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
