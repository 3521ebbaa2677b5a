"""Samples that were not measured, which are left out first.

Of the poses: those that no body can have passed, and a position that stands still while
the sensor turns. Of the wrench: those of a stream that stalled, had not begun, had
ended, or repeated its last message, and numbers such as -9999 that stand for no value."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask, changed_rows, distinct, median, runs_of
from hefting.ingest.channels import SAMPLES_FOR_NOISE, has_noise, noise_of_channel
from hefting.motion.continuity import Discontinuities, find_discontinuities
from hefting.motion.measure import POSE_STREAMS, Source, reads_columns
from hefting.motion.pose_steps import ORIENTATION_LIMITS, POSITION_LIMITS

LIMITS = {"position": POSITION_LIMITS, "orientation": ORIENTATION_LIMITS}
"""Bounds on the motion of each stream of poses."""
MANY_LEFT_OUT = 0.05
"""Share of poses, or of samples of the wrench, left out above which a warning is given."""
MOST_LEFT_OUT = 0.5
"""Share of glitches above which no pose is left out, as the limits do not suit it."""
TURNED = 0.1
"""[rad] Turn by which any arm moves a sensor."""
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
    recording = _without_constant_position(recording)
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


def _without_constant_position(recording: Recording) -> Recording:
    """Without a position that never changes while the sensor turns, as no arm turns it
    about its very origin; with a warning."""
    streams = dict(recording.streams)
    p = streams.pop("position", None)
    if p is None or "orientation" not in streams or (p.values != p.values[0]).any():
        return recording
    q = streams["orientation"].values
    turned = 2.0 * np.arccos(min(float(np.abs(q @ q[0]).min()), 1.0))
    if turned < TURNED:
        return recording
    what = f"the position never changes while the sensor turns by {np.degrees(turned):.0f}°: left out; log it"
    said = warning("position-constant", what)
    return replace(recording, streams=streams, warnings=(*recording.warnings, said))


def _masks(
    streams: dict[str, Stream], found: dict[str, Discontinuities]
) -> dict[str, Mask]:
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


FEWEST_REPEATED = 20
"""Number of successive equal samples that are no chance: with noise of one step two
channels repeat for so long once in 1e20."""
TIMES_HELD = 10.0
"""The same over the usual number of equal samples, as a slow stream that is logged
faster repeats each value."""
FEWEST_CHANNELS = 2
"""Least number of channels with noise for stalls to be found: a wrench without noise
rests with the body."""
FAR = 10.0
"""Size of a number that stands for no value, over that of all others."""


def without_stalled_wrench(recording: Recording) -> Recording:
    """The recording without the samples that a stalled stream of the wrench repeated,
    and a note or warning. It is unchanged for static poses, a wrench without noise or
    with larger steps, or if there are no such samples."""
    wrench = recording["wrench"]
    if recording.static or len(wrench) < FEWEST_REPEATED:
        return recording
    repeats = stalled(wrench.values)
    if not repeats.any() or repeats.all():
        return recording
    samples, where = _places(wrench, repeats)
    what = f"{samples} of a stream that stood still left out, {where}"
    many = repeats.mean() > MANY_LEFT_OUT
    said = (
        warning("wrench-stalled", f"{what}: did its driver run?")
        if many
        else note("wrench-stalled", what)
    )
    return _without(recording, repeats, said)


def without_blank_wrench(recording: Recording) -> Recording:
    """The recording without the samples of the wrench in which the same number, far
    from all others, is in several channels, and a note. It is unchanged for static
    poses or without such samples."""
    wrench = recording["wrench"]
    values = wrench.values
    if recording.static or not values.size:
        return recording
    size = np.abs(values)
    at = size == size.max()
    if np.count_nonzero(at.any(axis=0)) < FEWEST_CHANNELS:
        return recording
    blank = at.any(axis=1)
    if blank.all() or not FAR * size[~blank].max() < size.max():
        return recording
    samples, where = _places(wrench, blank)
    what = f"{samples} of {values[at][0]:g} in several channels left out, {where}"
    return _without(recording, blank, note("wrench-blank", what))


def _places(wrench: Stream, mask: Mask) -> tuple[str, str]:
    """How many samples (K,) are left out, and where, in words."""
    samples = f"{int(mask.sum())} samples of the wrench ({100.0 * mask.mean():.2g} %)"
    return samples, where_in_time(wrench.time - wrench.time[0], mask)


def _without(recording: Recording, mask: Mask, said: Message) -> Recording:
    kept = {**recording.streams, "wrench": recording["wrench"][~mask]}
    recording = replace(recording, streams=kept)
    if said.severity == "note":
        return replace(recording, notes=(*recording.notes, said))
    return replace(recording, warnings=(*recording.warnings, said))


def stalled(values: Array) -> Mask:
    """Mask (K,) of values (K, 6) that are repeated too long to be chance."""
    first = np.flatnonzero(changed_rows(values))
    lengths = np.diff(np.append(first, len(values)))
    usual = median(lengths)
    long = lengths >= max(FEWEST_REPEATED, TIMES_HELD * usual)
    if not long.any() or len(first) < FEWEST_REPEATED:
        return np.zeros(len(values), dtype=bool)
    never_rests = _always_changes(values[first])
    return np.repeat(long & (never_rests.sum() >= FEWEST_CHANNELS), lengths)


def _always_changes(values: Array) -> Mask:
    """Channels (6,) of values (K, 6) that change at rest by more than a step."""
    steps = [
        np.diff(distinct(channel[:SAMPLES_FOR_NOISE])).min(initial=np.inf)
        for channel in values.T
    ]
    noise = [noise_of_channel(channel) for channel in values.T]
    return has_noise(values) & (np.array(noise) > np.array(steps))
