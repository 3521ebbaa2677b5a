"""Messages on what conditioning found."""

from dataclasses import dataclass

import numpy as np

from hefting.core.messages import Message, error, note, warning
from hefting.core.quantity import significant
from hefting.core.recording import Recording
from hefting.core.spatial import Mask, median, runs_of
from hefting.ingest.conditioned import SIGNIFICANT, Conditioned
from hefting.ingest.offset_profile import OffsetProfile
from hefting.ingest.outliers import Outliers
from hefting.ingest.robust_fit import COMMON_OFFSET
from hefting.ingest.samples import FEWEST_POSES, FEWEST_POSES_FOR_OUTLIERS

LARGEST_OFFSET_STD = 0.05
"""[s] Standard deviation of the clock offset above which it counts as undetermined."""
NOTICED_OFFSET = 5e-4
"""[s] Rejected clock offset below which a note is enough."""
LARGEST_TILT_STD = 2.0
"""[deg] Standard deviation of gravity's direction above which a warning is given."""
NOTICED_SATURATED_SHARE = 0.005
"""Share of saturated samples above which a warning is given."""
LARGEST_SATURATED_SHARE = 0.05
"""Share of saturated samples above which the answer is wrong: with a tenth of the
samples clipped a mass was found 15 % too small."""
MOST_NUMBERS = 5
"""Largest number of odd poses that are listed by number."""
LARGEST_REJECTED_SHARE = 0.4
"""Share of rejected samples above which a warning is given."""


@dataclass(frozen=True)
class RejectedOffset:
    """A clock offset that was found and not used: it is insignificant, or explains too
    little of the wrench."""

    value: float
    """[s]"""
    std: float
    """[s]"""
    profile: OffsetProfile | None = None
    """of a significant offset, which was rejected because of its profile"""

    @property
    def left(self) -> float:
        """[s] The part of it that may still be true; of an offset that its profile
        contradicts, at most what drivers commonly leave."""
        if self.profile is None:
            return self.value
        return min(abs(self.value), COMMON_OFFSET)

    @property
    def known(self) -> bool:
        """Whether its standard deviation is small enough to exclude a relevant offset."""
        return self.std < LARGEST_OFFSET_STD

    @property
    def contradictory(self) -> bool:
        """Whether it is significant, and so was rejected for explaining too little."""
        return abs(self.value) > max(SIGNIFICANT * self.std, 1e-5)


def findings_of(
    found: Conditioned,
    recording: Recording,
    outliers: Outliers,
    rejected: RejectedOffset | None,
) -> tuple[Message, ...]:
    """Notes on what was found and corrected, and on the `rejected` clock offset, if any."""
    said = _offset_notes(found, rejected)
    if found.sign.t and found.sign.certain:
        t = abs(found.sign.t)
        known = f"{t:.0f}" if t < 1e6 else f"{t:.0e}"
        what = f"the wrench is {found.sign.name} ({known} standard deviations)"
        said.append(note("wrench-sign", what, "wrench"))
    if found.bias.kind != "constant":
        force, torque = (
            float(np.linalg.norm(r))
            for r in (found.bias.range[:3], found.bias.range[3:])
        )
        how = "linearly" if found.bias.kind == "linear" else "slowly wandering"
        what = f"the bias drifts by {force:.2g} N and {torque:.2g} N m, {how}"
        said.append(note("bias-drift", what, "bias"))
    if found.tilt_std is not None and np.isfinite(found.tilt_std):
        x, y, z = found.gravity
        degrees = np.degrees(found.tilt_std)
        where = f"gravity points along ({x:.2f}, {y:.2f}, {z:.2f}) m/s², known to {degrees:.2g}°"
        said.append(note("gravity-direction", where, "gravity"))
    return (*said, *_outlier_notes(outliers, recording))


def _offset_notes(found: Conditioned, rejected: RejectedOffset | None) -> list[Message]:
    said: list[Message] = []
    if rejected is not None and rejected.known and not rejected.contradictory:
        offset = f"{_milliseconds(rejected.value)} ± {_milliseconds(rejected.std)} ms"
        said.append(note("clock-no-offset", f"no clock offset: {offset}"))
    if found.offset:
        side = "late" if found.offset > 0.0 else "early"
        std = 1e3 * (found.offset_std or 0.0)
        digits = 1 if std >= 0.1 else 2
        size = f"{1e3 * abs(found.offset):.{digits}f} ± {std:.2g}"
        what = f"the wrench is {size} ms {side} against the motion; shifted"
        if found.offset_left and rejected is None:
            later = f"{2e3 * found.offset_left:.0f} ms later"
            what += f". It may be up to {later}, for which intervals allow"
        said.append(note("clock-offset", what))
    return said


def _outlier_notes(outliers: Outliers, recording: Recording) -> list[Message]:
    """Notes on contacts, spikes or odd poses, and saturated samples left out."""
    said: list[Message] = []
    if outliers.contact.any():
        interval = median(np.diff(recording["wrench"].time))
        seconds = float(outliers.contact.sum()) * interval
        number = len(runs_of(outliers.contact))
        stretches = "stretch" if number == 1 else "stretches"
        what = f"contact: {seconds:.1f} s in {number} {stretches} left out"
        said.append(note("contact", what))
    few = recording.static and len(outliers.spike) < FEWEST_POSES_FOR_OUTLIERS
    odd = "odd pose" if recording.static else "spike"
    which = f": {_numbers(outliers.spike)}" if recording.static else ""
    for code, name, mask, where in (
        ("spikes", odd, outliers.spike, which),
        ("saturation", "saturated sample", outliers.saturation, ""),
    ):
        # `_few_poses_warnings` has a warning for one of a few poses
        if mask.any() and not (few and code == "spikes"):
            several = "" if mask.sum() == 1 else "s"
            share = f"{100.0 * mask.mean():.2g} %"
            what = f"{int(mask.sum())} {name}{several} ({share}) left out{where}"
            said.append(note(code, what))
    return said


def _numbers(mask: Mask) -> str:
    """The first numbers of the samples in a mask, counted from one, as a list in words."""
    numbers = 1 + np.flatnonzero(mask)
    more = ", ..." if len(numbers) > MOST_NUMBERS else ""
    return ", ".join(str(number) for number in numbers[:MOST_NUMBERS]) + more


def warnings_of(
    found: Conditioned, rejected: RejectedOffset | None, *, tilt: bool, enough: bool
) -> tuple[Message, ...]:
    """Warnings of what was not found, and of doubtful results.

    `rejected` is a clock offset that was not used, `tilt` whether gravity's direction was
    to be found, and `enough` whether there were enough samples to condition.
    """
    if enough:
        said = _clock_warnings(found, rejected)
    elif found.path is not None and found.path.kind == "static":
        said = _few_poses_warnings(found.rejected)
    else:
        what = (
            "too few samples to look for clock offset, drift and outliers: none assumed"
        )
        said = [warning("too-few-samples", what)]
    if not found.biased:
        what = "the motion cannot tell a bias from the object's weight: none assumed"
        said.append(warning("bias-unknown", what, "bias"))
    if tilt:
        said += _gravity_warnings(found)
    said += _saturation_warnings(found)
    share = float(found.rejected.mean()) if len(found.rejected) else 0.0
    if share > LARGEST_REJECTED_SHARE:
        what = f"{100.0 * share:.0f} % of the samples were left out: doubt the rest"
        said.append(warning("many-outliers", what))
    return tuple(said)


def _few_poses_warnings(rejected: Mask) -> list[Message]:
    """A warning that one of a few static poses was left out, or that they are too few to
    find it."""
    if len(rejected) < FEWEST_POSES:
        what = "too few poses to tell whether one of them is odd: none left out"
        return [warning("too-few-samples", what)]
    if not rejected.any():
        return []
    what = (
        f"pose {_numbers(rejected)} of {len(rejected)} contradicts the others: left out; was "
        "the object touched there, or is its orientation that of another pose?"
    )
    return [warning("odd-pose", what)]


def _saturation_warnings(found: Conditioned) -> list[Message]:
    """A message where many samples are at the end of the sensor's range: more samples near
    it are clipped and not recognised."""
    share = found.reasons.get("saturation", 0) / max(len(found.rejected), 1)
    if share < NOTICED_SATURATED_SHARE:
        return []
    what = (
        f"{100.0 * share:.0f} % of the samples are at the end of the sensor's range: zero "
        "it first, move slower, or use one of a larger range"
    )
    say = error if share > LARGEST_SATURATED_SHARE else warning
    return [say("saturated", what)]


def _clock_warnings(
    found: Conditioned, rejected: RejectedOffset | None
) -> list[Message]:
    unknown = warning(
        "clock-offset-unknown",
        "the motion does not determine a clock offset between wrench and motion: none assumed",
    )
    if found.offset_std == np.inf:
        return [unknown]
    if rejected is None:
        return []
    if rejected.profile is not None:
        return [_profile_warning(rejected, rejected.profile)]
    if not rejected.known or not found.biased:
        return [unknown]
    if rejected.contradictory and found.path is not None:
        if found.path.kind == "orientation":  # its neglected accelerations imitate one
            return [unknown]
        offset = f"{_milliseconds(rejected.value)} ± {_milliseconds(rejected.std)} ms"
        what = f"a clock offset of {offset} would explain too little of the wrench: none assumed"
        if abs(rejected.value) < NOTICED_OFFSET:
            return [note("clock-no-offset", what)]
        return [warning("clock-offset-contradictory", what)]
    return []


def _profile_warning(rejected: RejectedOffset, profile: OffsetProfile) -> Message:
    """A warning with the reason why the profile contradicts the clock offset."""
    offset = f"{1e3 * rejected.value:.3g} ms"
    doubt = profile.doubt()
    if doubt == "edge":
        what = f"the wrench fits best at a clock offset of {offset}, at the edge of those looked for: none assumed"
        return warning("clock-offset-at-edge", what)
    if doubt == "several":
        other, apart = profile.rival
        offsets = f"{offset} and {1e3 * other:.3g} ms"
        gains = f"{profile.gain:.3g} and {profile.gain - apart:.3g}"
        what = f"clock offsets of {offsets} explain the wrench equally well (they gain {gains}): none assumed"
        return warning("clock-several-offsets", what)
    what = f"a clock offset of {offset} would explain too little of the wrench"
    figures = (
        f"it leaves {100.0 * profile.share_left:.0f} % of the squared residual"
        if doubt == "share"
        else f"gain {profile.gain:.3g}, and {profile.required_gain:.3g} are asked for"
    )
    return warning("clock-offset-contradictory", f"{what} ({figures}): none assumed")


def _gravity_warnings(found: Conditioned) -> list[Message]:
    if found.tilt_std is None:
        what = (
            "the direction of gravity was not looked for: the accelerometer measures it"
        )
        return [warning("gravity-measured", what, "gravity")]
    if found.tilt_std == np.inf:
        what = "the direction of gravity was not looked for: the motion does not determine it"
        return [warning("gravity-unknown", what, "gravity")]
    if not found.tilt_std < np.radians(LARGEST_TILT_STD):
        return [
            warning(
                "gravity-uncertain",
                "the motion hardly determines the direction of gravity",
                "gravity",
            )
        ]
    return []


def _milliseconds(seconds: float) -> str:
    """A time [s] in milliseconds, to two digits."""
    return significant(1e3 * seconds) if abs(seconds) > 1e-9 else "0"
