"""Poses of a recording that no body can have passed, which are left out first."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask, runs_of
from hefting.motion.continuity import Discontinuities, find_discontinuities
from hefting.motion.measure import POSE_STREAMS, Source, reads_columns
from hefting.motion.pose_steps import ORIENTATION_LIMITS, POSITION_LIMITS

LIMITS = {"position": POSITION_LIMITS, "orientation": ORIENTATION_LIMITS}
"""Bounds on the motion of each stream of poses."""
MANY_LEFT_OUT = 0.05
"""Share of poses left out above which a warning is given."""
MOST_LEFT_OUT = 0.5
"""Share of glitches above which no pose is left out, as the limits do not suit the
recording."""
MOST_TIMES_SHOWN = 3
"""Largest number of times in a message."""


def without_faulty_poses(recording: Recording, source: Source = "auto") -> Recording:
    """The recording without the poses that its body cannot have passed, with notes and
    warnings of them.

    Position and orientation that share their times lose the same samples. A recording
    without such poses, of static poses, or whose motion is logged beside its poses, is
    returned as it is.

    The motion's `source` is as for `hefting.motion.measure.measure`.
    """
    if recording.static or reads_columns(recording, source):
        return recording
    streams = {name: recording[name] for name in POSE_STREAMS if recording.has(name)}
    found = {}
    for name, stream in streams.items():
        faults = find_discontinuities(stream.time, stream.values, LIMITS[name])
        if faults is not None:
            found[name] = faults
    if not found:
        return recording
    masks = _masks(streams, found)
    time = {name: streams[name].time for name in masks}
    share = max(float(mask.mean()) for mask in masks.values())
    warnings = _jump_warnings(time, found)
    glitches = max(float(faults.glitch.mean()) for faults in found.values())
    if glitches > MOST_LEFT_OUT:
        most = _percent(glitches)
        what = f"{most} of the poses are out of reach of the others: none left out; do units and times fit?"
        warnings.append(warning("poses-implausible", what))
        return replace(recording, warnings=(*recording.warnings, *warnings))
    if share > MANY_LEFT_OUT:
        what = f"{_percent(share)} of the poses were left out: doubt the motion"
        warnings.append(warning("many-poses-left-out", what))
    kept = {
        name: streams[name] if not mask.any() else streams[name][~mask]
        for name, mask in masks.items()
    }
    return replace(
        recording,
        streams={**recording.streams, **kept},
        notes=(*recording.notes, *_notes(time, found)),
        warnings=(*recording.warnings, *warnings),
    )


def _masks(
    streams: dict[str, Stream], found: dict[str, Discontinuities]
) -> dict[str, Mask]:
    """Mask (K,) of the samples that each stream loses."""
    masks = {
        name: found[name].left_out
        if name in found
        else np.zeros(len(stream), dtype=bool)
        for name, stream in streams.items()
    }
    if len(streams) == 2:
        one, other = POSE_STREAMS
        if np.array_equal(streams[one].time, streams[other].time):
            masks[one] = masks[other] = masks[one] | masks[other]
    return masks


def _notes(time: dict[str, Array], found: dict[str, Discontinuities]) -> list[Message]:
    """Notes on how many poses were left out of which stream, why and where."""
    said = []
    for name, faults in found.items():
        if faults.glitch.any():
            poses, where = _counted(name, time[name], faults.glitch)
            what = f"{poses} out of reach of their neighbours left out, {where}"
            said.append(note("pose-glitches", what))
        if faults.frozen.any():
            poses, where = _counted(name, time[name], faults.frozen)
            what = f"{poses} of a stream that stalled while the body moved left out, {where}"
            said.append(note("poses-frozen", what))
        if faults.ends.any():
            poses, where = _counted(name, time[name], faults.ends)
            what = f"{poses} held before or after the motion left out, {where}"
            said.append(note("poses-held-at-ends", what))
    return said


def _counted(name: str, time: Array, mask: Mask) -> tuple[str, str]:
    """How many samples of a stream are in a mask (K,), and where, in words."""
    several = "" if mask.sum() == 1 else "s"
    share = _percent(float(mask.mean()))
    return f"{int(mask.sum())} {name}{several} ({share})", where_in_time(time, mask)


def _jump_warnings(
    time: dict[str, Array], found: dict[str, Discontinuities]
) -> list[Message]:
    """Warnings of parts of the recording between which a stream jumps."""
    said = []
    for name, faults in found.items():
        if len(faults.jumps):
            shown = ", ".join(
                f"{t:.2f}" for t in time[name][faults.jumps[:MOST_TIMES_SHOWN]]
            )
            what = f"the {name} jumps by more than a body can move, at {shown} s: identify the parts by themselves"
            said.append(warning("poses-jump", what, "start"))
    return said


def where_in_time(time: Array, mask: Mask) -> str:
    """Where the samples of a mask (K,) are, in words: "at 1.20 s, 3.00 to 3.40 s, and 4
    more places"."""
    runs = runs_of(mask)
    shown = [
        f"{time[b]:.2f}" if b + 1 == e else f"{time[b]:.2f} to {time[e - 1]:.2f}"
        for b, e in runs[:MOST_TIMES_SHOWN]
    ]
    more = len(runs) - len(shown)
    rest = f" s and at {more} more place{'s' if more > 1 else ''}" if more else " s"
    return f"at {', '.join(shown)}{rest}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
