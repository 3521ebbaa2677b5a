"""Ingest: all that estimators need of a recording, found once before any method."""

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
from hefting.core.sensor_accuracy import TYPICAL, SensorAccuracy
from hefting.core.spatial import Array, immutable
from hefting.ingest.blocks import measured_blocks, residual_size
from hefting.ingest.changes.stretches import change_warnings
from hefting.ingest.channels import (
    dead_channel_message,
    quantisation_message,
    require_changing_wrench,
    still_pose_message,
)
from hefting.ingest.chosen_part import ChosenPart, choose_part
from hefting.ingest.condition import condition
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import residuals
from hefting.ingest.ingested import Ingested
from hefting.ingest.left_out import left_out_of
from hefting.ingest.mended_times import with_mended_times
from hefting.ingest.rivals.consequence import Doubt
from hefting.ingest.sign_and_bias import (
    BiasOfEstimate,
    Fitted,
    bias_of,
    choose_sign,
    fit_samples,
    is_chosen,
    sign_warnings,
    subtract_bias,
    tared,
)
from hefting.ingest.systematic import (
    errors_of_clock_offset,
    errors_of_drift,
    errors_of_estimated_gravity,
    errors_of_gravity_size,
)
from hefting.ingest.tool import tool_covariance, tool_warnings, without_tool
from hefting.ingest.unmeasured import (
    without_blank_wrench,
    without_faulty_poses,
    without_stalled_wrench,
)
from hefting.ingest.weights import acceleration_message, motion_noise_of, weights_of
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
    accuracy: SensorAccuracy | str | None = None,
) -> Ingested:
    """Find clock offset, sign, bias, gravity, outliers, weights and noise of a
    recording, and subtract the tool.

    Parameters
    ----------
    recording : a recording or the path of a log.
    gravity, wrench, bias, motion, start, duration, tool : as for `hefting.identify`.
    hint : whether to estimate, for information, gravity's direction even where it is
        given.
    accuracy : of the sensor, whose errors within it are no mistake; or the typical one.

    Where the object changes, the longest stretch of one free body is used, with an
    object in the hand if there is one, and those that only contacts divide from it;
    where `start` or `duration` is given the part is used as it is, with a warning.
    Whether the recording determines an object is checked by
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
        accuracy=accuracy,
    )
    given = bias.recorded(wrench) if isinstance(bias, BiasOfEstimate) else bias
    usable = _usable_samples(recording, start, duration, motion, given)
    may_be_biased = usable.given_bias is None and bias != "none"
    assumed = Gravity.of(gravity)
    conditioned = partial(
        condition,
        gravity=assumed.vector,
        source=motion,
        tilt=assumed.direction == "estimate",
        hint=hint,
    )
    chosen = choose_part(
        usable.recording,
        conditioned(usable.recording),
        partial(conditioned, changes=False),
        may_be_biased=may_be_biased,
        tool=tool,
        as_given=usable.is_part,
        sensor_errors=max(
            (SensorAccuracy.of(accuracy) or TYPICAL).share, TYPICAL.share
        ),
    )
    found = chosen.found
    measured, counts, within = _averages_of(chosen, motion, may_be_biased=may_be_biased)
    fitted = fit_samples(
        measured.measurements, found, wrench, bias, may_be_biased=may_be_biased
    )
    if wrench == "auto" and isinstance(bias, BiasOfEstimate):
        own = choose_sign(wrench, found, fitted.fits, may_be_biased=True)
        if own.certain and own.name != bias.wrench:
            return again(bias=bias.recorded(own.name))
    z, fits, fit = fitted.measurements, fitted.fits, fitted.fit
    shared_errors = [
        errors_of_estimated_gravity(
            chosen.recording, motion, found, measured, z, fit, drift=may_be_biased
        ),
        None if fitted.response is None else fitted.response.errors,
        errors_of_drift(found, z, fit) if may_be_biased else None,
    ]
    clock_error = errors_of_clock_offset(found, z, fit)
    gravity_error = errors_of_gravity_size(assumed, measured.source, fitted.state, fit)
    changes = None if chosen.changes is None else chosen.changes.later(usable.first)
    doubt, warnings, notes = _messages(
        usable,
        replace(chosen, changes=changes),
        measured,
        fitted,
        sign_found=wrench == "auto",
        may_be_biased=may_be_biased,
    )
    if not fitted.sign.on_object:
        z = replace(z, force=-z.force, torque=-z.torque)
        fit, fits = fit.flipped(), fits.flipped()
    unexplained = residuals(z, fit.vector, fit.bias)
    level = residual_size(unexplained, counts, within)
    if tool is not None:
        z = without_tool(z, tool)
        fit = fit.less(tool.parameters.vector, tool.covariance)
        warnings += tool_warnings(tool)
    return Ingested(
        log=chosen.recording.source,
        static=chosen.recording.static,
        measurements=z,
        counts=counts,
        motion=measured.motion,
        source=measured.source,
        sign=fitted.sign,
        sign_found=wrench == "auto",
        bias="estimate" if fitted.free_bias else "none",
        bias_found=is_chosen(bias),
        given_bias=usable.given_bias,
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
        read_notes=tuple(notes),
        changes=changes,
        left_out=left_out_of(
            usable.whole,
            chosen.recording,
            found,
            None if usable.is_part else chosen.changes,
            later=usable.first,
        ),
        log_start=usable.whole.start - usable.first,
    )


@immutable
class _UsableSamples:
    """The part of a recording that was asked for."""

    whole: Recording
    """with corrected times"""
    recording: Recording
    """without the samples that were not measured, and without a given bias"""
    given_bias: Array | None
    """(6,) bias that was subtracted"""
    first: float
    """[s] from the recording's first sample to the part's"""
    is_part: bool
    """whether a part was asked for"""


def _usable_samples(
    recording: Recording | str | Path,
    start: float,
    duration: float | None,
    motion: Source,
    bias: str | Array,
) -> _UsableSamples:
    """Samples from `start` [s] on, `duration` [s] long, of a recording or log."""
    recording = as_recording(recording)
    is_part = bool(start) or duration is not None
    part = recording.slice(start, duration) if is_part else recording
    whole = with_mended_times(part, motion)
    usable = without_blank_wrench(without_faulty_poses(whole, motion))
    usable = without_stalled_wrench(usable)
    usable, given_bias = subtract_bias(usable, tared(bias, recording))
    require_changing_wrench(usable)
    first = part.start - recording.start
    return _UsableSamples(whole, usable, given_bias, first, is_part)


def _averages_of(
    chosen: ChosenPart, motion: Source, *, may_be_biased: bool
) -> tuple[Measured, Array, Array]:
    """Averages of the chosen part of a recording, weighted, with the motion's noise; the
    numbers of samples (K,) in each; and the covariance (6, 6) of the wrench about them."""
    recording, found = chosen.recording, chosen.found
    measured, counts, within = measured_blocks(
        recording, found, motion, drift=may_be_biased
    )
    if not np.any(measured.measurements.wrench):
        what = "the wrench is zero throughout"
        raise InputError(what, where=recording.source, fix="check its columns")
    z = replace(
        measured.measurements,
        weights=weights_of(found, measured, counts),
        motion_noise=motion_noise_of(measured),
    )
    return replace(measured, measurements=z), counts, within


def _messages(
    usable: _UsableSamples,
    chosen: ChosenPart,
    measured: Measured,
    fitted: Fitted,
    *,
    sign_found: bool,
    may_be_biased: bool,
) -> tuple[Doubt | None, list[Message], list[Message]]:
    """The doubt about a recording, warnings, of which it is the first, and notes of
    reader and smoother."""
    recording, found = chosen.recording, chosen.found
    doubt, of_poses = _doubt_and_pose_warnings(usable.whole, recording, chosen.doubt)
    warnings = [
        *(() if doubt is None else doubt.messages),
        *of_poses,
        *_conditioning_warnings(
            recording, measured, found, may_be_biased=may_be_biased
        ),
        *(sign_warnings(fitted.sign) if sign_found and not fitted.is_empty else []),
        *fitted.bias_messages,
        *change_warnings(chosen.changes, chosen=not usable.is_part),
    ]
    notes: list[Message] = [*recording.notes, *measured.notes]  # type: ignore[list-item]
    if fitted.response is not None:
        notes += fitted.response.messages()
    steps = quantisation_message(usable.whole)
    if steps is not None:
        (notes if steps.severity == "note" else warnings).append(steps)
    unmodelled = acceleration_message(found, fitted.measurements, measured.motion)
    if unmodelled is not None and chosen.doubt is None:
        warnings.append(unmodelled)
    return doubt, warnings, notes


def check_convention(wrench: str) -> None:
    """`InputError` for a word that is no sign convention of a wrench."""
    if wrench not in ("auto", "on-object", "on-sensor"):
        what = f"unknown wrench convention '{wrench}'"
        raise InputError(what, fix="use auto, on-object or on-sensor")


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
