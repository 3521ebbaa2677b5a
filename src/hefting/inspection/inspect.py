"""Inspection before anything is identified. A poor recording does not raise."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from dataclasses import replace
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError, file_word
from hefting.core.estimate import Answered, Estimate
from hefting.core.gravity import ON_EARTH, Gravity, GravityLike
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.core.spatial import SPEED_LIMIT, Array, angle_between, check_gravity
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.identifiability import identifiability
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.mended_times import with_mended_times
from hefting.ingest.plausibility import (
    check_wrench,
    holds_nothing,
    mass_warnings,
    torque_sign_messages,
)
from hefting.ingest.rivals.base import SENSOR_ERROR
from hefting.ingest.tool import load_tool
from hefting.inspection.facts import Movement, movement, stream_facts, wrench_facts
from hefting.inspection.result import GravityHint, Inspection
from hefting.logs.given import as_recording
from hefting.motion import measure

EMPTY = "the wrench is zero throughout"


def inspect(
    recording: Recording | str | Path | Any,
    gravity: GravityLike = ON_EARTH,
    tool: Estimate | Answered | str | Path | None = None,
    *,
    start: float = 0.0,
    duration: float | None = None,
) -> Inspection:
    """Collect facts about a recording before an object is identified.

    Parameters
    ----------
    recording : Recording, path, or a table in memory
        Any that `hefting.as_recording` takes, also one that cannot be used for
        identification.
    gravity : Gravity, ArrayLike or "estimate"
        (3,) in world axes [m/s²], or ``"estimate"`` to find its direction.
    tool : Estimate, what `calibrate` or `identify` returns, or path, optional
        What the sensor holds in addition to the object, to subtract.
    start, duration : float, optional
        Part of the recording to inspect [s].

    Returns
    -------
    Inspection
        Missing findings are None; `Inspection.missing` states why.

    Raises
    ------
    InputError
        Only if `recording` is no recording, the part is empty, `gravity` is not a valid
        gravity, or `tool` no estimate.

    Examples
    --------
    >>> found = hefting.inspect("demo/log.csv")
    >>> found.verdict.level, round(found.facts.mass, 2)
    ('good', 0.67)
    """
    whole = as_recording(recording, wrench_needed=False)
    part: dict[str, Any] = {"start": start, "duration": duration}
    recording = whole.slice(**part) if start or duration is not None else whole
    g = check_gravity(Gravity.of(gravity).vector)
    held = None if tool is None else load_tool(tool)
    missing: dict[str, str] = {}
    ingested = motion = None
    obstacle = _obstacle(recording)
    try:
        if not obstacle:
            ingested = ingest(whole, gravity=gravity, hint=True, tool=held, **part)
            motion = movement(with_mended_times(recording), ingested)
        elif obstacle == EMPTY:
            missing["conditioning"] = obstacle
            motion = movement(recording, measure(recording, g))
        else:
            missing |= dict.fromkeys(("conditioning", "motion"), obstacle)
    except InputError as error:
        missing |= dict.fromkeys(("conditioning", "motion"), _reason(error))
    result = _inspection(recording, ingested, motion, g, missing)
    return replace(result, advice=advice(result, recording))


def _obstacle(recording: Recording) -> str:
    """Why the recording cannot be conditioned; empty if it can."""
    if not recording.has("wrench"):
        return "there is no wrench"
    if not recording.has("orientation"):
        if recording.has("joint_positions"):
            return "there are joint angles but no poses"
        return "there is no orientation"
    return "" if recording["wrench"].values.any() else EMPTY


def _inspection(
    recording: Recording,
    found: Ingested | None,
    moved: Movement | None,
    gravity: Array,
    missing: dict[str, str],
) -> Inspection:
    facts = identifiable = hint = None
    sign = None if found is None else found.sign
    warnings: list[Message] = [*recording.warnings]  # type: ignore[list-item]
    if found is None:
        missing["object"] = missing.get("motion", EMPTY)
    elif found.tool is not None and holds_nothing(found):
        missing["object"] = "nothing but the tool is held"
    else:
        fit = found.beside_bias
        if fit.mass_is_open:
            fit = found.fit if found.bias == "none" else found.alone
        if found.tool is not None and fit is not found.fit:
            fit = fit.less(found.tool.parameters.vector, found.tool.covariance)
        comparable = not fit.mass_is_open and found.source != "orientation"
        facts = wrench_facts(found, fit, comparable)
        identifiable = identifiability(found.excitation, fit, TYPICAL_SIZE, found.tool)
        hint = _hint(gravity, found.conditioned)
        warnings = list(found.warnings)
        try:
            check_wrench(found, None)
        except InputError as error:
            warnings.append(warning("wrong-unit", _reason(error)))
        else:
            warnings += [*mass_warnings(found), *torque_sign_messages(found, True)]
        if found.doubt is not None:
            warnings = [*found.doubt.without_consequences(warnings)]
            if any(m.code == "gravity-reversed" for m in found.doubt.messages):
                # both were found with gravity as given
                hint = sign = None
    if found is not None:
        gravity = found.conditioned.gravity
    return Inspection(
        log=recording.source,
        duration=recording.duration,
        static=recording.static,
        streams={
            name: stream_facts(stream, recording.static)
            for name, stream in recording.streams.items()
        },
        notes=recording.notes if found is None else found.read_notes,
        gravity=gravity,
        quick_mass=_quick_mass(recording, gravity),
        movement=moved,
        conditioned=None if found is None else found.conditioned,
        gravity_hint=hint,
        sign=sign,
        facts=facts,
        identifiability=identifiable,
        missing=missing,
        advice=(),
        warnings=tuple(dict.fromkeys(warnings)),
        changes=None if found is None else found.changes,
        ingested=found,
    )


def _hint(gravity: Array, found: Conditioned) -> GravityHint | None:
    """Gravity by the data, if it was to be found or is well determined; else None."""
    adopted = found.tilt_std is not None
    if adopted:
        std, hinted = found.tilt_std, found.gravity
    elif found.tilted is not None and found.sign.certain:
        hinted = found.tilted.gravity
        std = float(np.hypot(found.tilted.std, SENSOR_ERROR))
    else:
        return None
    if std is None or not np.isfinite(std):
        return None
    x, y, z = (hinted / np.linalg.norm(hinted)).tolist()
    return GravityHint(angle_between(gravity, hinted), std, (x, y, z), adopted)


def _quick_mass(recording: Recording, gravity: Array) -> float | None:
    if not recording.has("wrench"):
        return None
    force = recording["wrench"].values[:, :3]
    return float(np.linalg.norm(force, axis=1).mean() / np.linalg.norm(gravity))


def _reason(error: InputError) -> str:
    """An error and its remedy, without the file's name."""
    return f"{error.what}; {error.fix}" if error.fix else error.what


OFFSET = 0.005
"""[s] Clock offset above which it is mentioned."""
FEW_HERTZ = 50.0
"""[Hz] Rate of poses below which accelerations of a hand's motion are lost."""
SHORT = 5.0
"""[s] Duration below which a longer recording is advised."""
SHARE = 0.02
"""Share of samples missing, or left out, above which it is mentioned."""
BRISK = 0.2
"""[rad/s] Mean angular speed above which a slow stream is mentioned."""
LITTLE = 0.5
"""[rad] Turn of gravity in sensor axes below which more is advised."""
WEAK = 1.0
"""Signal-to-noise ratio below which a channel is mentioned."""


def advice(found: Inspection, recording: Recording) -> tuple[str, ...]:
    """Advice in sentences, the most pressing first."""
    if "object" in found.missing:
        return _what_is_missing(found, recording)
    doubt = None if found.ingested is None else found.ingested.doubt
    mend = "correct what the verdict names, and inspect again"
    if doubt is not None and doubt.makes_wrong:
        return (mend,)
    care = "" if found.verdict.level == "good" else ", with care"
    ready = f"ready{care}: {_with_shape(found)}" if found.verdict.usable else mend
    return (*(list(_obstacles(found)) or [ready]), *_improvements(found))


def _what_is_missing(found: Inspection, recording: Recording) -> tuple[str, ...]:
    reason = found.missing["object"]
    if not recording.has("orientation"):
        if recording.has("joint_positions"):
            return ("joint angles: give `urdf` robot.urdf `sensor_frame` NAME",)
        return ("record the orientation of the sensor (qx qy qz qw), or joint angles",)
    if not recording.has("wrench"):
        return ("record the wrench (fx fy fz tx ty tz)",)
    if not recording["wrench"].values.any():
        return (f"{reason}: check which columns hold it",)
    return (f"nothing can be identified: {reason}",)


def _obstacles(found: Inspection) -> Iterator[str]:
    m, sign = found.movement, found.sign
    assert m is not None
    assert found.facts is not None
    assert found.identifiability is not None
    open_ = found.identifiability.open
    if found.facts.bias is None:
        if m.turn > LITTLE:
            yield "no mass is found beside a bias: is anything held, or does the controller subtract its payload?"
        else:
            yield "record other orientations: a bias cannot be told from the object's weight in this one"
    if sign is not None and not sign.certain:
        yield "the wrench's sign is not certain: give `sign` on-object or on-sensor"
    yield from found.identifiability.summary
    if m.turn < LITTLE and {"m", "mcx", "mcy", "mcz"} & set(open_):
        yield (
            f"gravity turned by {_degrees(m.turn)} at most in sensor axes: tilt the sensor by 60° or more, then about "
            "another axis"
        )
    if any(name.startswith("J") for name in open_):
        yield (
            "give `shape`: it says of the inertia what the motion does not "
            f"({_with_shape(found)})"
        )


def _with_shape(found: Inspection) -> str:
    read = found.ingested
    tool = ["--tool", "TOOL"] if read is not None and read.tool is not None else []
    words = ["hefting", "identify", file_word(found.log), *tool, "--shape", "MESH"]
    return shlex.join(words)


def _improvements(found: Inspection) -> Iterator[str]:
    yield from _wrench_advice(found)
    hint, m = found.gravity_hint, found.movement
    assert m is not None
    known = (
        m.turn > LITTLE
        and (found.static or found.duration > SHORT)
        and "m" not in found.undetermined
    )
    # otherwise the verdict's reasons come first
    no_doubt = found.verdict.level == "good"
    if hint is not None and hint.serious and known and no_doubt:
        yield (
            f"the data suggest gravity {_degrees(hint.angle)} from where it is given: is the base tilted? "
            "give `gravity` estimate"
        )
    if m.above_limit and m.linear_speed is not None:
        yield f"slow down near people: {m.linear_speed[1]:.2g} m/s is above the {SPEED_LIMIT:g} m/s of ISO 10218"
    if m.dynamism is None:
        yield "record positions (px py pz) or an accelerometer: without them only mass and COM are found"
    if found.undetermined:
        if (
            found.static
            and found.streams["wrench"].samples < 10
            and {"m", "mcx", "mcy", "mcz"} & {*found.undetermined}
        ):
            yield "record ten static poses or more"
        elif not found.static and found.duration < SHORT:
            yield f"record ten seconds or more: {found.duration:.2g} s is short"
    yield from _stream_advice(found)


def _wrench_advice(found: Inspection) -> Iterator[str]:
    c = found.conditioned
    if c is not None:
        if abs(c.offset) > OFFSET:
            late = "late" if c.offset > 0.0 else "early"
            yield f"the wrench is {1e3 * abs(c.offset):.3g} ms {late}: identify corrects that"
        if c.bias.kind != "constant":
            yield "the bias drifts: identify removes it; better, let the sensor warm up before recording"
        if c.reasons.get("saturation"):
            yield "the sensor reached its limit: move slower, zero it first, or use one of a larger range"
        n = max(len(c.rejected), 1)
        if c.reasons.get("contact", 0) > SHARE * n:
            share = _percent(c.reasons["contact"] / n)
            yield f"{share} of the samples do not fit one free body: does the object touch something, or swing?"
        if c.reasons.get("spike", 0) > SHARE * n:
            share = _percent(c.reasons["spike"] / n)
            yield f"{share} of the samples are spikes, left out: check the sensor's cable, filter and clock"
    assert found.facts is not None
    for name in ("force", "torque"):
        channels = found.facts.channels[name]
        ratio = float(
            (channels.signal**2).sum() / max((channels.noise**2).sum(), 1e-300)
        )
        if ratio < WEAK:
            yield f"the {name} shows more noise than object (SNR {ratio:.2g}): record longer"


def _stream_advice(found: Inspection) -> Iterator[str]:
    if found.static:
        return
    m = found.movement
    for name in ("orientation", "wrench"):
        facts = found.streams[name]
        what = "poses" if name == "orientation" else "wrenches"
        if (
            0.0 < facts.rate < FEW_HERTZ
            and m is not None
            and m.angular_speed[0] > BRISK
        ):
            yield f"{what} come at {facts.rate:.3g} Hz: record 100 Hz or more, or move slower"
        if facts.missing > SHARE:
            longest = f", for {facts.longest_gap:.2g} s at the longest"
            yield (
                f"{_percent(facts.missing)} of the {what} are missing"
                f"{longest if facts.gaps else ''}: check the network and the recorder's load"
            )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share > 0.1 else f"{100.0 * share:.1f} %"


def _degrees(angle: float) -> str:
    return f"{degrees(angle):.{0 if degrees(angle) >= 10.0 else 1}f}°"
