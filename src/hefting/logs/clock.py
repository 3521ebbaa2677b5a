"""Time of a recording: seconds from the start, and what looks wrong with it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hefting.errors import InputError
from hefting.logs.units import SECOND, Unit
from hefting.recording import Recording, Stream

EPOCHS = (("nanoseconds", "1e9", 1e17), ("microseconds", "1e6", 1e14), ("milliseconds", "1e3", 1e11))
"""Unit, divisor and least value of times since 1970 that are not in seconds."""
STATIC_STREAMS = ("position", "orientation", "joint_positions", "wrench", "accelerometer")


def in_seconds(
    streams: Mapping[str, Stream], source: str, unit: Unit = SECOND
) -> tuple[dict[str, Stream], tuple[str, ...]]:
    """The streams with their times in seconds, those since 1970 shifted to start at 0, and warnings.

    `InputError` for times that cannot be in `unit`.
    """
    where = f"{source}, column time"
    start = min(float(stream.time[0]) for stream in streams.values())
    began = abs(float(unit.to_si(np.array(start))))
    if began > 1e11:  # seconds since 1970 reach 1e11 in the year 5138
        if unit != SECOND:
            raise InputError(f"{start:.6g} cannot be {unit.name}", where, "give the unit of time")
        meant, factor = next((meant, factor) for meant, factor, least in EPOCHS if began > least)
        fix = f"divide by {factor}, or give the unit of time in a column map (--map FILE)"
        raise InputError(f"{start:.6g} cannot be seconds; it looks like {meant} since 1970", where, fix)
    warnings = []
    if began > 1e8:
        streams = {name: replace(stream, time=stream.time - start) for name, stream in streams.items()}
        shift, resolution = (float(unit.to_si(np.array(value))) for value in (start, np.spacing(abs(start))))
        warnings.append(f"time was shifted by {shift:.6f} s to start at 0; it resolves {resolution:.1g} s")
    if unit != SECOND:
        streams = {name: replace(stream, time=unit.to_si(stream.time)) for name, stream in streams.items()}
    for name, stream in streams.items():
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with the recording
            steps = np.diff(stream.time)
        step = float(np.median(steps)) if len(steps) else 0.0
        if step > 1000:
            raise InputError(f"the median step of {name} is {step:.4g}, not seconds", where, "give time in seconds")
        whole = unit == SECOND and step >= 1 and len(steps) > 20 and not (stream.time % 1).any()
        if step > 5 or whole:
            warnings.append(f"the median step of {name} is {step:.4g} s: is time in milliseconds, not seconds?")
        elif 0 < step < 2e-5:
            warnings.append(f"the median step of {name} is {step:.4g} s: is time in seconds?")
    return dict(streams), tuple(warnings)


def checked_static(recording: Recording) -> Recording:
    """The recording, with a warning when its rows hardly are static poses."""
    moving = [name for name in recording.streams if name not in STATIC_STREAMS]
    count = max(len(stream) for stream in recording.streams.values())
    if not moving and count <= 1000:
        return recording
    also = f", although there is {', '.join(moving)}" if moving else ""
    warning = f"there is no column time: each of {count} rows is taken as a static pose{also}"
    return replace(recording, warnings=(*recording.warnings, warning))
