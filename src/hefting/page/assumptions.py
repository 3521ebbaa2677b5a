"""Assumptions: sign, frame, gravity, bias, clock and tool, and what was found."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.page.answer import Say
from hefting.page.html import Section, element, items, join, terms

ACTS = {
    "on-object": "the log holds what the sensor exerts on the object (on-object)",
    "on-sensor": "the log holds what the object exerts on the sensor (on-sensor)",
}


def assumptions(estimate: Estimate, say: Say) -> Section:
    """What was assumed or found of the recording, and settings of the method."""
    made = estimate.provenance
    pairs = [
        ("Log", made.get("log", "not known")),
        ("Samples", _samples(estimate)),
        ("Sign", _sign(made)),
        ("Frame", "all results in the sensor's axes, about its origin"),
        ("Gravity", _gravity(made)),
        ("Bias", _bias(estimate)),
        ("Clock", _clock(made)),
        ("Motion", made.get("motion", "not known")),
        ("Tool", _tool(made)),
        ("Method", f"{estimate.method}{_settings(made)}"),
    ]
    parts = [terms(pairs)]
    if notes := [say(str(note)) for note in made.get("notes", ())]:
        parts += [element("h3", "Found on the way"), items(notes)]
    return Section("assumptions", "Assumptions", join(*parts))


def _samples(estimate: Estimate) -> str:
    if estimate.duration is None:
        return f"{estimate.samples:,} static poses"
    return f"{estimate.samples:,} over {estimate.duration:.4g} s"


def _sign(made: Mapping[str, Any]) -> str:
    wrench = str(made.get("wrench", "not known"))
    found = "found from gravity" if made.get("wrench_found") else "as given"
    return f"{ACTS.get(wrench, wrench)}, {found}"


def _vector(values: Iterable[float], digits: int = 4) -> str:
    text = ", ".join(f"{value + 0.0:.{digits}g}" for value in values)
    return f"({text})".replace("-", "−")


def _gravity(made: Mapping[str, Any]) -> str:
    if "gravity" not in made:
        return "not known"
    found = ", direction found" if made.get("gravity_found") else ""
    std = made.get("gravity_std")
    known = f", its size to {std:.2g} m/s²" if std else ""
    return f"{_vector(made['gravity'])} m/s² in world axes{found}{known}"


def _bias(estimate: Estimate) -> str:
    """Of the wrench, as recorded."""
    made, bias = estimate.provenance, estimate.common_bias
    if estimate.bias is not None and bias is None:
        return "found with the object, one for each recording"
    given, how = made.get("bias_subtracted"), "given, and subtracted"
    if bias is not None:
        given = -bias if made.get("wrench") == "on-sensor" else bias
        how = "found with the object, as recorded"
    if given is not None:
        numbers = np.asarray(given, dtype=float)
        force, torque = _vector(numbers[:3], 3), _vector(numbers[3:], 3)
        return f"{how}: {force} N, {torque} N m"
    searched = made.get("bias_searched")
    return "none beyond three standard deviations" if searched else "none, as given"


def _clock(made: Mapping[str, Any]) -> str:
    offset = made.get("clock_offset")
    if made.get("recordings"):
        return "one for each recording, found"
    if offset is None:
        return "not known"
    if not offset:
        return "wrench and motion share one: no significant offset"
    side = "late" if offset > 0.0 else "early"
    return f"the wrench is {1e3 * abs(offset):.3g} ms {side}, corrected"


def _tool(made: Mapping[str, Any]) -> str:
    tool = made.get("tool")
    if not tool:
        return "none: what is shown is all that the sensor holds"
    return f"{tool[0]:.4g} kg were subtracted: what is shown is the object alone"


def _settings(made: Mapping[str, Any]) -> str:
    """Numbers that the method used."""
    from hefting.estimators import options

    said = [
        f"{name} = {made[name]:g}"
        for name in ("points", *options())
        if isinstance(made.get(name), int | float)
    ]
    return f", with {', '.join(said)}" if said else ""
