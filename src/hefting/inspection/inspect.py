"""Inspect a recording: look at everything that can be found before anything is identified, and never fail."""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import TYPICAL_SIZE, FreeFit, fit_freely, wrench_sign
from hefting.conditioning import Conditioned, condition
from hefting.errors import InputError
from hefting.identifiability import identifiability
from hefting.inspection.advice import advice
from hefting.inspection.movement import movement
from hefting.inspection.result import GravityHint, Inspection
from hefting.inspection.streams import stream_facts
from hefting.inspection.wrench import wrench_facts
from hefting.motion import Measured, measure
from hefting.plausibility import check_wrench, gravity_warnings
from hefting.recording import Recording
from hefting.spatial import STANDARD_GRAVITY, Array, frozen

ENOUGH = 5_000
"""Wrench samples that show gravity's direction."""
EMPTY = "the wrench is zero throughout"


def inspect(recording: Recording, gravity: ArrayLike | Literal["estimate"] = STANDARD_GRAVITY) -> Inspection:
    """Findings about `recording`, with `gravity` (3,) in world axes [m/s²], or its direction ``"estimate"``.

    What cannot be found is None, and `Inspection.missing` says why. Raises `InputError` only for a gravity that is
    none.
    """
    found = _Findings(recording, gravity)
    result = found.told()
    return replace(result, advice=advice(result, recording))


class _Findings:
    """What was found so far, and why not the rest."""

    def __init__(self, recording: Recording, gravity: ArrayLike | str):
        self.recording = recording
        self.given = not isinstance(gravity, str)
        if not self.given and gravity != "estimate":
            raise InputError(f"unknown gravity '{gravity}'", fix="use X,Y,Z [m/s²] or estimate")
        self.gravity = frozen(gravity if self.given else STANDARD_GRAVITY)  # type: ignore[arg-type]
        if self.gravity.shape != (3,) or not np.isfinite(self.gravity).all() or not self.gravity.any():
            raise InputError(f"gravity must be three numbers [m/s²], not all zero; got {self.gravity.tolist()}")
        self.missing: dict[str, str] = {}
        self.warnings = list(recording.warnings)
        self.hint: GravityHint | None = None
        self.conditioned = self._condition()
        self.measured = self._measure()

    def _condition(self) -> Conditioned | None:
        lacking = self._lacks()
        if not lacking and not np.any(self.recording["wrench"].values):
            lacking = EMPTY
        if lacking:
            self.missing["conditioning"] = lacking
            return None
        try:
            found = condition(self.recording, self.gravity, tilt=not self.given)
        except InputError as error:
            self.missing["conditioning"] = _said(error)
            return None
        tilted = found
        if self.given:
            tilted = condition(_thinned(self.recording), self.gravity, tilt=True)
        self.hint = _hint(self.gravity, tilted, not self.given)
        self.gravity = found.gravity
        self.warnings += found.warnings
        return found

    def _lacks(self) -> str:
        """What the log does not hold without which nothing can be found; empty where it does."""
        if not self.recording.has("wrench"):
            return "there is no wrench"
        if self.recording.has("orientation"):
            return ""
        joints = self.recording.has("joint_positions")
        return "there are joint angles but no poses" if joints else "there is no orientation"

    def _measure(self) -> Measured | None:
        if self._lacks():
            self.missing["motion"] = self._lacks()
            return None
        try:
            recording, curves = self.recording, None
            if self.conditioned is not None:
                recording, curves = self.conditioned.corrected(recording), self.conditioned.curves
            measured = measure(recording, self.gravity, curves=curves)
        except InputError as error:
            self.missing |= dict.fromkeys(("conditioning", "motion"), _said(error))
            self.conditioned = self.hint = None
            return None
        self.warnings += measured.warnings
        return measured

    def told(self) -> Inspection:
        """The findings, without advice."""
        recording, measured = self.recording, self.measured
        facts = identifiable = None
        sign = self.conditioned.sign if self.conditioned is not None else None
        if measured is None:
            self.missing["object"] = self.missing["motion"]
        elif not np.any(measured.measurements.wrench):
            self.missing["object"] = EMPTY
        else:
            z = measured.measurements
            fit, weighed = _fit(measured)
            if sign is None:
                sign = wrench_sign(z, True)
            facts = wrench_facts(z, fit, measured.motion, weighed and measured.source != "orientation")
            identifiable = identifiability(z, fit, TYPICAL_SIZE)
            self._doubts(measured, fit)
        return Inspection(
            log=recording.source,
            duration=recording.duration,
            static=recording.static,
            streams={name: stream_facts(stream, recording.static) for name, stream in recording.streams.items()},
            notes=(*recording.notes, *(measured.notes if measured is not None else ())),
            gravity=self.gravity,
            quick_mass=_quick_mass(recording, self.gravity),
            movement=None if measured is None else movement(recording, measured),
            conditioned=self.conditioned,
            gravity_hint=self.hint,
            sign=sign,
            facts=facts,
            identifiability=identifiable,
            missing=self.missing,
            advice=(),
            warnings=tuple(dict.fromkeys(self.warnings)),
        )

    def _doubts(self, measured: Measured, fit: FreeFit) -> None:
        """Warnings of units and gravity that no object explains."""
        try:
            check_wrench(measured.measurements, fit, None, self.recording.source)
        except InputError as error:
            self.warnings.append(_said(error))
        self.warnings += gravity_warnings(measured.measurements, fit)


def _fit(measured: Measured) -> tuple[FreeFit, bool]:
    """Least squares beside a bias where that leaves a mass, else without; and whether there is a mass."""
    fit = fit_freely(measured.measurements, True)
    if not fit.mass_is_open:
        return fit, True
    fit = fit_freely(measured.measurements, False)
    return fit, not fit.mass_is_open


def _thinned(recording: Recording) -> Recording:
    """With fewer wrench samples, where there are more than gravity's direction needs."""
    step = -(-len(recording["wrench"]) // ENOUGH)
    if recording.static or step == 1:
        return recording
    return replace(recording, streams={**recording.streams, "wrench": recording["wrench"][::step]})


def _hint(gravity: Array, found: Conditioned, adopted: bool) -> GravityHint | None:
    if found.tilt_std is None or not np.isfinite(found.tilt_std) or not (adopted or found.sign.certain):
        return None
    there = found.gravity / np.linalg.norm(found.gravity)
    here = gravity / np.linalg.norm(gravity)
    angle = float(np.arctan2(np.linalg.norm(np.cross(here, there)), here @ there))
    return GravityHint(angle, found.tilt_std, (float(there[0]), float(there[1]), float(there[2])), adopted)


def _quick_mass(recording: Recording, gravity: Array) -> float | None:
    if not recording.has("wrench"):
        return None
    force = recording["wrench"].values[:, :3]
    return float(np.linalg.norm(force, axis=1).mean() / np.linalg.norm(gravity))


def _said(error: InputError) -> str:
    return error.what if error.fix is None else f"{error.what}; {error.fix}"
