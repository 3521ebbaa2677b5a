"""Ingest: all that estimators need to know of a recording, found once before any
method."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, Gravity, GravityLike
from hefting.core.measurements import Noise
from hefting.core.messages import Message, error, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest.bias import (
    BiasOfEstimate,
    FreeFits,
    bias_of,
    choose_bias,
    nothing_held,
)
from hefting.ingest.blocks import measured_blocks, residual_size
from hefting.ingest.changes.stretches import change_warnings
from hefting.ingest.channels import (
    dead_channel_message,
    quantisation_message,
    require_changing_wrench,
    still_pose_message,
)
from hefting.ingest.condition import condition
from hefting.ingest.conditioned import Conditioned, WrenchSign
from hefting.ingest.faulty_wrench import (
    without_blank_wrench,
    without_stalled_wrench,
)
from hefting.ingest.free_fit import residuals, wrench_sign
from hefting.ingest.ingested import Ingested
from hefting.ingest.left_out import choose_part, left_out_of
from hefting.ingest.mended_times import with_mended_times
from hefting.ingest.poses import without_faulty_poses
from hefting.ingest.response import response_of
from hefting.ingest.rivals.consequence import Doubt
from hefting.ingest.systematic import (
    errors_of_clock_offset,
    errors_of_drift,
    errors_of_estimated_gravity,
    errors_of_gravity_size,
)
from hefting.ingest.tool import tool_covariance, tool_warnings, without_tool
from hefting.ingest.weights import (
    acceleration_message,
    motion_noise_of,
    weights_of,
)
from hefting.logs.given import as_recording
from hefting.motion import Measured
from hefting.motion.measure import Source

__all__ = ["Ingested", "ingest"]


def ingest(
    recording: Recording | str | Path,
    *,
    gravity: GravityLike = ON_EARTH,
    wrench: Literal["auto", "on-object", "on-sensor"] = "auto",
    bias: str | Path | ArrayLike | BiasOfEstimate = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    tool: Estimate | None = None,
    hint: bool = False,
) -> Ingested:
    """Find clock offset, sign, bias, gravity, outliers, weights and noise of a
    recording, and subtract the tool.

    Parameters
    ----------
    recording : a recording or the path of a log.
    gravity, wrench, bias, motion, start, duration, tool : as for `hefting.identify`.
    hint : whether to estimate, for information, gravity's direction even where it is
        given.

    Where the object changes, the longest stretch of one free body is used, with an
    object in the hand if there is one; where `start` or `duration` is given the part is
    used as it is, with a warning. Whether the recording determines an object is checked by
    `hefting.ingest.plausibility.require_object`. Raises `InputError` for what cannot be
    read or understood.
    """
    check_convention(wrench)
    bias = bias_of(bias)
    again = partial(
        ingest,
        recording,
        gravity=gravity,
        motion=motion,
        start=start,
        duration=duration,
        tool=tool,
        hint=hint,
    )
    recording, first = _read(recording, start, duration)
    whole = with_mended_times(recording, motion)
    recording = without_blank_wrench(without_faulty_poses(whole, motion))
    recording, given_bias = _subtract_given_bias(
        without_stalled_wrench(recording),
        bias.recorded(wrench) if isinstance(bias, BiasOfEstimate) else bias,
    )
    require_changing_wrench(recording)
    may_be_biased = given_bias is None and bias != "none"
    assumed = Gravity.of(gravity)
    tilt = assumed.direction == "estimate"
    asked = bool(start) or duration is not None
    conditioned = partial(
        condition, gravity=assumed.vector, source=motion, tilt=tilt, hint=hint
    )
    chosen = choose_part(
        recording,
        conditioned(recording),
        partial(conditioned, changes=False),
        may_be_biased=may_be_biased,
        tool=tool,
        as_given=asked,
    )
    recording, found, changes = chosen.recording, chosen.found, chosen.changes
    left_out = left_out_of(
        whole, recording, found, changes if not asked else None, later=first
    )
    changes = None if changes is None else changes.later(first)
    measured, counts, within = measured_blocks(
        recording, found, motion, drift=may_be_biased
    )
    z = measured.measurements
    if not np.any(z.wrench):
        raise InputError(
            "the wrench is zero throughout",
            where=recording.source,
            fix="check its columns",
        )
    z = replace(
        z,
        weights=weights_of(found, measured, counts),
        motion_noise=motion_noise_of(measured),
    )
    state = SampleState.of(z)
    fits = FreeFits.of(state, found.inflation)
    sign = _choose_sign(wrench, found, fits, may_be_biased=may_be_biased)
    if wrench == "auto" and isinstance(bias, BiasOfEstimate):
        own = _choose_sign(wrench, found, fits, may_be_biased=True)
        if own.certain and own.name != bias.wrench:
            return again(bias=bias.recorded(own.name))
    bias_is_auto = isinstance(bias, str) and bias == "auto"
    free_bias, bias_warnings = choose_bias(
        found,
        fits,
        may_be_biased=may_be_biased,
        is_auto=bias_is_auto,
    )
    empty = nothing_held(z, fits.chosen(free_bias=may_be_biased))
    if empty is not None:
        free_bias, bias_warnings = may_be_biased, [empty]
    response = response_of(found, z, fits.chosen(free_bias=free_bias))
    if response is not None:
        z = response.corrected(z)
        state = SampleState.of(z)
        fits = FreeFits.of(state, found.inflation)
    fit = fits.chosen(free_bias=free_bias)
    doubt, pose_warnings = _doubt_and_pose_warnings(whole, recording, chosen.doubt)
    warnings = [
        *(() if doubt is None else doubt.messages),
        *pose_warnings,
        *_conditioning_warnings(
            recording, measured, found, may_be_biased=may_be_biased
        ),
        *(_sign_warnings(sign) if wrench == "auto" and empty is None else []),
        *bias_warnings,
        *change_warnings(changes, chosen=not asked),
    ]
    steps = quantisation_message(whole)
    notes = [*recording.notes, *measured.notes]
    notes += [] if response is None else response.messages()
    if steps is not None:
        (notes if steps.severity == "note" else warnings).append(steps)
    shared_errors = [
        errors_of_estimated_gravity(
            recording, motion, found, measured, z, fit, drift=may_be_biased
        ),
        None if response is None else response.errors,
        errors_of_drift(found, z, fit) if may_be_biased else None,
    ]
    clock_error = errors_of_clock_offset(found, z, fit)
    unmodelled = acceleration_message(found, z, measured.motion)
    if unmodelled is not None and chosen.doubt is None:
        warnings.append(unmodelled)
    gravity_error = errors_of_gravity_size(assumed, measured.source, state, fit)
    if not sign.on_object:
        z = replace(z, force=-z.force, torque=-z.torque)
        fit, fits = fit.flipped(), fits.flipped()
    level = residual_size(residuals(z, fit.vector, fit.bias), counts, within)
    if tool is not None:
        z = without_tool(z, tool)
        fit = fit.less(tool.parameters.vector, tool.covariance)
        warnings += tool_warnings(tool)
    return Ingested(
        log=recording.source,
        static=recording.static,
        measurements=z,
        counts=counts,
        motion=measured.motion,
        source=measured.source,
        sign=sign,
        sign_found=wrench == "auto",
        bias="estimate" if free_bias else "none",
        bias_found=bias_is_auto,
        given_bias=given_bias,
        conditioned=found,
        tool=tool,
        fit=fit,
        beside_bias=fits.beside_bias,
        alone=fits.alone,
        noise=Noise(float(level[0]), float(level[1])),
        within=within,
        systematic=_systematic_covariance(shared_errors, tool),
        clock_error=clock_error,
        doubt=doubt,
        gravity_std=assumed.std,
        gravity_error=gravity_error,
        warnings=tuple(warnings),
        read_notes=tuple(notes),  # type: ignore[arg-type]
        changes=changes,
        left_out=left_out,
        log_start=whole.start - first,
    )


def _read(
    recording: Recording | str | Path, start: float, duration: float | None
) -> tuple[Recording, float]:
    """The part of a recording or log from `start` [s] on, `duration` [s] long, and the
    time [s] from the recording's first sample to the part's."""
    recording = as_recording(recording)
    whole = recording.start
    if start or duration is not None:
        recording = recording.slice(start, duration)
    return recording, recording.start - whole


def check_convention(wrench: str) -> None:
    """`InputError` for a word that is no sign convention of a wrench."""
    if wrench not in ("auto", "on-object", "on-sensor"):
        raise InputError(
            f"unknown wrench convention '{wrench}'",
            fix="use auto, on-object or on-sensor",
        )


def _subtract_given_bias(
    recording: Recording, given: str | Array
) -> tuple[Recording, Array | None]:
    """The recording without the given bias (6,), and that bias; for a bias model's name
    as it is, and None."""
    if isinstance(given, str):
        return recording, None
    wrench = recording["wrench"]
    unbiased = replace(wrench, values=wrench.values - given)
    return replace(recording, streams={**recording.streams, "wrench": unbiased}), given


def _conditioning_warnings(
    recording: Recording, measured: Measured, found: Conditioned, *, may_be_biased: bool
) -> list[Message]:
    """Warnings of reader, smoother and conditioning, except of an unknown bias, which
    `choose_bias` gives."""
    warnings: list[Message] = [*recording.warnings, *measured.warnings]  # type: ignore[list-item]
    warnings = [m for m in warnings if getattr(m, "code", "") != "time-unit"]  # a doubt
    warnings += [
        message for message in found.warnings if message.code != "bias-unknown"
    ]
    if not may_be_biased and found.bias.kind != "constant":
        what = (
            "a bias given, or none, leaves its drift in: `bias`='estimate' removes it"
        )
        warnings.append(warning("drift-left-in", what, "bias"))
    return warnings


def _doubt_and_pose_warnings(
    whole: Recording, recording: Recording, doubt: Doubt | None
) -> tuple[Doubt | None, list[Message]]:
    """The doubt about a recording, which dead channels, constant poses or times in
    milliseconds may cause, and a warning of constant poses beside another doubt."""
    pose_warnings: list[Message] = []
    still = still_pose_message(whole)
    if still is not None and doubt is not None and doubt.message.code == "unexplained":
        # without motion all noise counts as an unexplained change
        say = error if doubt.is_fatal else warning
        doubt = Doubt(say("pose-constant", str(still)), names_mistake=False)
    elif still is not None:
        pose_warnings = [still]
    dead = dead_channel_message(recording)
    two = doubt is not None and doubt.second is not None
    if dead is not None and not two:  # a dead channel imitates other mistakes
        doubt = Doubt(dead, names_mistake=True)
    for message in whole.warnings:
        if isinstance(message, Message) and message.code == "time-unit":
            doubt = Doubt(message, names_mistake=True)  # sure, and imitates others too
    return doubt, pose_warnings


def _choose_sign(
    wrench: str, found: Conditioned, fits: FreeFits, *, may_be_biased: bool
) -> WrenchSign:
    """The sign convention as given, by the robust fit, or else by the free fits."""
    if may_be_biased and found.sign.t:
        sign = found.sign
    else:
        sign = wrench_sign(fits.beside_bias if may_be_biased else None, fits.alone)
    return sign if wrench == "auto" else WrenchSign(wrench == "on-object", sign.t)


def _sign_warnings(sign: WrenchSign) -> list[Message]:
    """A warning if the sign convention that was found is uncertain."""
    if sign.certain:
        return []
    what = f"the wrench's sign is uncertain ({sign.doubt}); assumed {sign.name}"
    return [
        warning("sign-uncertain", f"{what}: give `sign` on-object or on-sensor", "sign")
    ]


def _systematic_covariance(
    errors: list[Array | None], tool: Estimate | None
) -> Array | None:
    """(10, 10) covariance of the errors that all samples share, None if there are none:
    of `errors` (10, n), each by one standard deviation of n causes, and of a tool."""
    parts = [E @ E.T for E in errors if E is not None]
    of_tool = tool_covariance(tool)
    parts += [] if of_tool is None else [of_tool]
    C = np.sum(parts, axis=0) if parts else np.zeros((10, 10))
    return C if C.any() else None
