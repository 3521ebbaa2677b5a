"""Inspection of a recording before anything is identified. A poor recording does not
raise."""

from dataclasses import replace

import numpy as np

from hefting.core.errors import InputError
from hefting.core.gravity import ON_EARTH, Gravity, GravityLike
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array, check_gravity
from hefting.identification.identifiability import identifiability
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import TYPICAL_SIZE, FreeFit
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.plausibility import check_wrench
from hefting.inspection.advice import advice
from hefting.inspection.facts import Movement, movement, stream_facts, wrench_facts
from hefting.inspection.result import GravityHint, Inspection
from hefting.motion import measure

EMPTY = "the wrench is zero throughout"


def inspect(recording: Recording, gravity: GravityLike = ON_EARTH) -> Inspection:
    """Collect all that can be said of a recording before an object is identified.

    Parameters
    ----------
    recording : Recording
        Any recording, also one that cannot be used for identification.
    gravity : Gravity, ArrayLike or "estimate"
        (3,) in world axes [m/s²], or ``"estimate"`` to find its direction.

    Returns
    -------
    Inspection
        Findings that could not be made are None; `Inspection.missing` states why.

    Raises
    ------
    InputError
        Only if `gravity` is not a valid gravity.
    """
    g = check_gravity(Gravity.of(gravity).vector)
    missing: dict[str, str] = {}
    ingested = motion = None
    obstacle = _obstacle(recording)
    try:
        if not obstacle:
            ingested = ingest(recording, gravity=gravity, hint=True)
            motion = movement(recording, ingested)
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
    """Why it cannot be conditioned; empty if it has all that is needed."""
    if not recording.has("wrench"):
        return "there is no wrench"
    if not recording.has("orientation"):
        joints = recording.has("joint_positions")
        return (
            "there are joint angles but no poses"
            if joints
            else "there is no orientation"
        )
    return "" if recording["wrench"].values.any() else EMPTY


def _inspection(
    recording: Recording,
    found: Ingested | None,
    moved: Movement | None,
    gravity: Array,
    missing: dict[str, str],
) -> Inspection:
    facts = identifiable = hint = None
    warnings: list[Message] = [*recording.warnings]  # type: ignore[list-item]
    if found is None:
        missing["object"] = missing.get("motion", EMPTY)
    else:
        fit = (
            found.beside_bias
            if not found.beside_bias.mass_is_open
            else _without_bias(found)
        )
        comparable = not fit.mass_is_open and found.source != "orientation"
        facts = wrench_facts(found, fit, comparable)
        identifiable = identifiability(found.excitation, fit, TYPICAL_SIZE)
        hint = _hint(gravity, found.conditioned)
        warnings = [
            line
            for line in found.warnings
            if getattr(line, "code", "") not in ("sign-uncertain", "base-tilted")
        ]
        try:
            check_wrench(found, None)
        except InputError as error:
            warnings.append(warning("wrong-unit", _reason(error)))
    return Inspection(
        log=recording.source,
        duration=recording.duration,
        static=recording.static,
        streams={
            name: stream_facts(stream, recording.static)
            for name, stream in recording.streams.items()
        },
        notes=recording.notes if found is None else found.read_notes,
        gravity=gravity if found is None else found.conditioned.gravity,
        quick_mass=_quick_mass(
            recording, gravity if found is None else found.conditioned.gravity
        ),
        movement=moved,
        conditioned=None if found is None else found.conditioned,
        gravity_hint=hint,
        sign=None if found is None else found.sign,
        facts=facts,
        identifiability=identifiable,
        missing=missing,
        advice=(),
        warnings=tuple(dict.fromkeys(warnings)),
        changes=None if found is None else found.changes,
        ingested=found,
    )


def _without_bias(found: Ingested) -> FreeFit:
    return found.fit if found.bias == "none" else found.alone


def _hint(gravity: Array, found: Conditioned) -> GravityHint | None:
    """Where the data would have gravity, or, if its direction was to be found, where it
    is."""
    adopted = found.tilt_std is not None
    if adopted:
        std, there = found.tilt_std, found.gravity
    elif found.tilted is not None and found.sign.certain:
        std, there = found.tilted.std, found.tilted.gravity
    else:
        return None
    if std is None or not np.isfinite(std):
        return None
    there, here = there / np.linalg.norm(there), gravity / np.linalg.norm(gravity)
    angle = float(np.arctan2(np.linalg.norm(np.cross(here, there)), here @ there))
    return GravityHint(
        angle, std, (float(there[0]), float(there[1]), float(there[2])), adopted
    )


def _quick_mass(recording: Recording, gravity: Array) -> float | None:
    if not recording.has("wrench"):
        return None
    force = recording["wrench"].values[:, :3]
    return float(np.linalg.norm(force, axis=1).mean() / np.linalg.norm(gravity))


def _reason(error: InputError) -> str:
    """And what to do about it, without the file's name."""
    return f"{error.what}; {error.fix}" if error.fix else error.what
