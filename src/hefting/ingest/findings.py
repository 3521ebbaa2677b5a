"""What conditioning found, as messages."""

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Mask
from hefting.ingest.conditioned import SIGNIFICANT, Conditioned
from hefting.ingest.outliers import Outliers
from hefting.ingest.path import Path

LARGEST_OFFSET_STD = 0.05
"""[s] Standard deviation of the clock offset from which on the offset counts as undetermined."""
LARGEST_TILT_STD = 2.0
"""[deg] Standard deviation of gravity's direction from which on a warning is given."""
SMALLEST_EXPLAINED_SHARE = 0.8
"""Share of the wrench's variance that the fit should explain; a warning is given below it."""
LARGEST_REJECTED_SHARE = 0.4
"""Share of rejected samples above which a warning is given."""


def findings_of(
    found: Conditioned, recording: Recording, bad: Outliers, late: tuple[float, float] | None
) -> tuple[Message, ...]:
    """What was found and done; `late` is an offset that was not taken, and its deviation."""
    said = []
    if late is not None and late[1] < LARGEST_OFFSET_STD and not _contradictory(late):
        said.append(note("clock-no-offset", f"no clock offset: {_ms(late[0])} ± {_ms(late[1])} ms"))
    if found.offset:
        side, std = "late" if found.offset > 0.0 else "early", 1e3 * (found.offset_std or 0.0)
        size = f"{1e3 * abs(found.offset):.{1 if std >= 0.1 else 2}f} ± {std:.2g}"
        said.append(note("clock-offset", f"the wrench is {size} ms {side} against the motion; shifted"))
    if found.sign.t and found.sign.certain:
        said.append(note("wrench-sign", f"the wrench is {found.sign.name} (t = {_t(found.sign.t)})", "wrench"))
    if found.bias.kind != "constant":
        force, torque = (float(np.linalg.norm(r)) for r in (found.bias.range[:3], found.bias.range[3:]))
        how = "linearly" if found.bias.kind == "linear" else f"between {len(found.bias.knots)} knots"
        said.append(note("bias-drift", f"the bias drifts by {force:.2g} N and {torque:.2g} N m, {how}", "bias"))
    if found.tilt_std is not None and np.isfinite(found.tilt_std):
        x, y, z = found.gravity
        degrees = np.degrees(found.tilt_std)
        where = f"gravity points along ({x:.2f}, {y:.2f}, {z:.2f}) m/s², known to {degrees:.2g}°"
        said.append(note("gravity-direction", where, "gravity"))
    if bad.contact.any():
        seconds, stretches = _stretches(bad.contact, recording)
        several = "stretch" if stretches == 1 else "stretches"
        said.append(note("contact", f"contact: {seconds:.1f} s in {stretches} {several} left out"))
    odd = "odd pose" if recording.static else "spike"
    for code, name, mask in (("spikes", odd, bad.spike), ("saturation", "saturated sample", bad.saturation)):
        if mask.any():
            several = "" if mask.sum() == 1 else "s"
            said.append(note(code, f"{int(mask.sum())} {name}{several} ({100.0 * mask.mean():.2g} %) left out"))
    return tuple(said)


def warnings_of(
    found: Conditioned,
    path: Path,
    explained: float,
    late: tuple[float, float] | None,
    clock: bool,
    tilt: bool,
    few: bool,
) -> tuple[Message, ...]:
    """What could not be found, and what gives doubt; `late` is an offset that was not taken, and its deviation."""
    said = []
    unknown = warning(
        "clock-offset-unknown", "the motion does not tell a clock offset between wrench and motion: none assumed"
    )
    if few:
        what = "too few samples to look for clock offset, drift and outliers: none assumed"
        said.append(warning("too-few-samples", what))
    elif clock and path.moves and found.offset_std == np.inf:
        said.append(unknown)
    elif late is not None:
        if not late[1] < LARGEST_OFFSET_STD or not found.biased:
            said.append(unknown)
        elif _contradictory(late):
            found_ms = f"{1e3 * late[0]:.2g} ± {1e3 * late[1]:.2g} ms"
            what = f"a clock offset of {found_ms} would explain too little of the wrench: none assumed"
            said.append(warning("clock-offset-contradictory", what))
    if not found.biased:
        what = "the motion cannot tell a bias from the object's weight: none assumed"
        said.append(warning("bias-unknown", what, "bias"))
    if tilt and found.tilt_std is None:
        what = "the direction of gravity was not looked for: the accelerometer measures it"
        said.append(warning("gravity-measured", what, "gravity"))
    elif tilt and found.tilt_std == np.inf:
        what = "the direction of gravity was not looked for: the motion does not tell it"
        said.append(warning("gravity-unknown", what, "gravity"))
    elif tilt and not found.tilt_std < np.radians(LARGEST_TILT_STD):
        said.append(warning("gravity-uncertain", "the motion hardly tells the direction of gravity", "gravity"))
    if not few and found.biased and explained < SMALLEST_EXPLAINED_SHARE:
        share = f"{100.0 * max(explained, 0.0):.0f} %"
        what = f"the motion explains {share} of the wrench's changes: do clocks, units and axes fit?"
        said.append(warning("motion-explains-little", what))
    share = float(found.rejected.mean()) if len(found.rejected) else 0.0
    if share > LARGEST_REJECTED_SHARE:
        what = f"{100.0 * share:.0f} % of the samples were left out: doubt the rest"
        said.append(warning("many-outliers", what))
    return tuple(said)


def _contradictory(late: tuple[float, float]) -> bool:
    """Whether an offset that was not taken is far from zero, going by its deviation."""
    return abs(late[0]) > max(SIGNIFICANT * late[1], 1e-5)


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.2g}" if abs(seconds) > 1e-9 else "0"


def _t(t: float) -> str:
    return f"{t:.0f}" if abs(t) < 1e6 else f"{t:.0e}"


def _stretches(mask: Mask, recording: Recording) -> tuple[float, int]:
    time = recording["wrench"].time
    begins = np.flatnonzero(np.diff(mask.astype(int), prepend=0) == 1)
    apart = 1 + int(np.sum(time[begins[1:]] - time[begins[:-1]] > 0.0)) if len(begins) else 0
    interval = float(np.median(np.diff(time)))
    return float(mask.sum()) * interval, apart
