"""Runs of a robot, loaded and empty: from samples to the payload's equations; and an
arm's calibration in a JSON file.

Offsets and frictions that a run without the payload shares with one that has it tell
the small mass from the large offset. They change slowly as the gears warm up: by how
much between the runs is said by the standard deviations of two nuisances that the
loaded samples alone have.

How friction grows with the load depends on the torques of the rigid bodies, which are
sought. So the rows are folded several times: first with the published arm's, then with those
that were found.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import read_json, write_atomically
from hefting.core.immutable import immutable
from hefting.core.spatial import Array
from hefting.core.torque_moments import PAYLOAD, TorqueMoments
from hefting.torques import equations
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import LEVELS, OWN, Load, Rows, TorqueScales
from hefting.torques.noise import TorqueFit, fit
from hefting.torques.samples import TorqueSamples

OFFSET_CHANGE = 0.2
"""Standard deviation of an offset's change between two runs, over that of the joint's
noise: 0.02 N m of a shoulder, by a minute of warm-up."""
FRICTION_CHANGE = 1.0
"""The same of the Coulomb friction."""
LARGEST_CHANGE = 3.0
"""Change over those, from which on they are as much wider: of right runs it was at most
1.7, of offsets that changed by the noise 2.5 to 12."""
FRICTION_BY_LOAD = 0.03
"""Standard deviation of the friction over the torque that causes it: of strain wave
gears some percent."""
NO_CHANGE = 1e-3
"""The same where there is none."""
LOAD_PASSES = 3
"""Times the torques of the rigid bodies, by which friction grows, are sought."""
PUBLISHED_ERROR = 0.5
"""Standard deviation of the arm's base parameters from the published ones, over their
size: where the samples do not tell them better."""
TYPICAL_PAYLOAD = np.repeat((5.0, 0.5, 0.1), (1, 3, 6))
"""(10,) standard deviations of a payload's parameters [kg, kg m, kg m²]."""


@immutable
class EmptyRuns:
    """What an arm's runs without a payload tell of it: its calibration."""

    scales: TorqueScales
    load: Load
    """by which the friction's columns were made"""
    digests: tuple[str, ...] = ()
    """of the runs, as of `TorqueSamples.digest`"""

    @classmethod
    def of(cls, dynamics: JointDynamics, runs: Sequence[TorqueSamples]) -> EmptyRuns:
        """Of one or more runs."""
        rows = _rows(dynamics, (), runs, False)
        load = Load.published(dynamics)
        for _ in range(LOAD_PASSES):
            found = fit(_folded(dynamics, rows, load), drifting)
            load = Load(_arm_of(dynamics, found), np.zeros(PAYLOAD))
        digests = tuple(run.digest for run in runs)
        return cls(_folded(dynamics, rows, load), load, digests)

    @property
    def fit(self) -> TorqueFit:
        """Arm, frictions and noise by these runs alone."""
        return fit(self.scales, drifting)


@immutable
class LoadedRuns:
    """Runs with the payload, beside what is known of the arm; or empty ones alone."""

    dynamics: JointDynamics
    loaded: tuple[TorqueSamples, ...]
    empty: tuple[TorqueSamples, ...] = ()
    calibration: EmptyRuns | None = None
    """of other runs than `empty`"""
    drift: bool = True
    """whether offsets and frictions may differ between empty and loaded runs, which
    they do not in parts of one recording"""

    def __post_init__(self):
        if not (self.loaded or self.empty):
            raise InputError("there is no run with the payload")

    @property
    def arm_known(self) -> bool:
        """Whether the URDF's inertias must serve for the arm's."""
        return not self.empty and self.calibration is None

    def fit(self) -> TorqueFit:
        """Least squares of everything; its `state` holds the payload's equations."""
        known = self.calibration
        load = Load.published(self.dynamics) if known is None else known.load
        prior = drifting if self.drift else steady
        rows = _rows(self.dynamics, self.loaded, self.empty, self.arm_known)
        for _ in range(LOAD_PASSES):
            load = loads_of(self, fit(self._scales(rows, load), prior))
        scales = self._scales(rows, load)
        found = fit(scales, prior)
        if self.drift and found.changes > LARGEST_CHANGE:
            wider = found.changes * np.array((OFFSET_CHANGE, FRICTION_CHANGE))
            found = fit(scales, partial(_prior, offset=wider[0], friction=wider[1]))
        return found

    def delayed(self, by: float, loaded: bool) -> Self:
        """With torques `by` seconds late, in the `loaded` runs alone or in all."""
        empty = self.empty if loaded else tuple(r.delayed(by) for r in self.empty)
        return replace(
            self, loaded=tuple(r.delayed(by) for r in self.loaded), empty=empty
        )

    def alone(self) -> list[TorqueFit]:
        """Fits of the loaded runs, with the payload as part of the last link, of the
        empty ones, and of the calibration, each by itself."""
        runs = [EmptyRuns.of(self.dynamics, self.loaded)]
        if self.empty:
            runs.append(EmptyRuns.of(self.dynamics, self.empty))
        if self.calibration is not None:
            runs.append(self.calibration)
        return [each.fit for each in runs]

    def _scales(self, rows: Sequence[Rows], load: Load) -> TorqueScales:
        own = _folded(self.dynamics, rows, load)
        return own if self.calibration is None else own.merge(self.calibration.scales)


def drifting(std: Array) -> Array:
    """(own, n) standard deviations of the nuisances for those of the noise (n,), of
    runs between which gears warm up."""
    return _prior(std, OFFSET_CHANGE, FRICTION_CHANGE)


def steady(std: Array) -> Array:
    """The same of parts of one recording, between which nothing changes."""
    return _prior(std, NO_CHANGE, NO_CHANGE)


def _prior(std: Array, offset: float, friction: float) -> Array:
    found = np.full((len(OWN), len(std)), np.inf)
    found[equations.FRICTION_BY_LOAD] = FRICTION_BY_LOAD
    found[equations.OFFSET_CHANGE] = offset * std
    found[equations.FRICTION_CHANGE] = friction * std
    return found


def no_samples(dynamics: JointDynamics, arm_known: bool = False) -> TorqueScales:
    """Moments before any sample."""
    arm = 0 if arm_known else len(dynamics.base)
    return TorqueScales.empty(dynamics.joints, len(OWN), arm)


def _rows(
    dynamics: JointDynamics,
    loaded: Sequence[TorqueSamples],
    empty: Sequence[TorqueSamples],
    arm_known: bool,
) -> tuple[Rows, ...]:
    """Of the empty runs, then of the loaded ones."""
    runs = *((own, False) for own in empty), *((own, True) for own in loaded)
    return tuple(Rows.of(dynamics, own, carries, arm_known) for own, carries in runs)


def _folded(dynamics: JointDynamics, rows: Sequence[Rows], load: Load) -> TorqueScales:
    """Moments of the rows of runs, with friction by a load."""
    arm_known = any(own.published is not None for own in rows)
    scales = no_samples(dynamics, arm_known)
    for own in rows:
        scales = scales.fold(own.under(dynamics, load))
    return scales


def loads_of(runs: LoadedRuns, found: TorqueFit) -> Load:
    """Arm and payload by a fit."""
    known = runs.calibration
    arm = runs.dynamics.arm if known is None else known.load.arm
    if runs.empty:
        arm = _arm_of(runs.dynamics, found)
    return Load(arm, _payload_of(found))


def _arm_of(dynamics: JointDynamics, found: TorqueFit) -> Array:
    """(10 n,) the arm by a fit, near the published one where that leaves it open."""
    size = len(dynamics.base)
    published = dynamics.links @ dynamics.arm
    scale = PUBLISHED_ERROR * (np.abs(published) + np.abs(published).mean() + 1e-6)
    prior_rows = np.zeros((size, size + PAYLOAD + 1))
    prior_rows[:, :size], prior_rows[:, -1] = np.diag(1.0 / scale), published / scale
    R = np.vstack((found.shared, prior_rows, _payload_rows(size)))
    arm = np.zeros(10 * dynamics.joints)
    arm[dynamics.base] = np.linalg.lstsq(R[:, :-1], R[:, -1], rcond=None)[0][:size]
    return arm


def _payload_of(found: TorqueFit) -> Array:
    """(10,) the payload by a fit, small where that leaves it open."""
    R = np.vstack((found.payload, _payload_rows(0)))
    body = np.linalg.lstsq(R[:, :-1], R[:, -1], rcond=None)[0]
    return np.asarray(body, dtype=float)


def _payload_rows(arm: int) -> Array:
    rows = np.zeros((PAYLOAD, arm + PAYLOAD + 1))
    rows[:, arm : arm + PAYLOAD] = np.diag(1.0 / TYPICAL_PAYLOAD)
    return rows


SCHEMA = "hefting-arm-1"
SAME_ARM = 1e-6
"""Relative difference of an arm's numbers that is rounding."""


def save_arm(path: str | Path, dynamics: JointDynamics, runs: EmptyRuns) -> None:
    """Write an arm's calibration, whole or not at all."""
    scales = runs.scales
    last = scales.levels[-1]
    data = {
        "schema": SCHEMA,
        "joints": list(dynamics.names),
        "sensor_frame": dynamics.robot.sensor_frame,
        "published": dynamics.arm.tolist(),
        "mechanics": _mechanics(dynamics).tolist(),
        "runs": list(runs.digests),
        "load": runs.load.arm.tolist(),
        "samples": last.samples,
        "start": last.start,
        "end": last.end,
        "levels": [
            {"counts": m.counts.tolist(), "factors": _packed(m.factors)}
            for m in scales.levels
        ],
    }
    write_atomically(path, json.dumps(data) + "\n")


def load_arm(path: str | Path, dynamics: JointDynamics) -> EmptyRuns:
    """The calibration in a file, of the same arm.

    Raises `InputError` for a file that is not one, and for that of another robot, of
    other joints or another order of them, of another frame or gravity.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError(
            "is no calibration of an arm",
            path,
            "make one: hefting calibrate EMPTY --torques --output arm.json",
        )
    _require_same(data, dynamics, path)
    try:
        return _runs(data, dynamics)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise _damaged(str(error), path) from None


def _damaged(what: str, path: Any) -> InputError:
    return InputError(f"is a damaged calibration ({what[:80]})", path, "make it again")


def _require_same(data: dict[str, Any], dynamics: JointDynamics, path: Any) -> None:
    names = data.get("joints")
    if names != list(dynamics.names):
        said = ", ".join(map(str, names)) if isinstance(names, list) else "none"
        raise InputError(
            f"is of the joints {said[:200]}, not {', '.join(dynamics.names)}",
            path,
            "calibrate this robot",
        )
    frame, own = data.get("sensor_frame"), dynamics.robot.sensor_frame
    if frame != own:
        raise InputError(f"is for the frame '{str(frame)[:80]}', not '{own}'", path)
    for key, what, expected in (
        ("published", "its URDF had other inertias", dynamics.arm),
        ("mechanics", "it had other joints or another gravity", _mechanics(dynamics)),
    ):
        # files of before have no mechanics
        given = data.get(key, expected if key == "mechanics" else None)
        try:
            found = np.array(given, dtype=float)
        except (TypeError, ValueError, OverflowError):
            found = np.array(np.nan)
        if not np.isfinite(found).all():
            raise _damaged(key, path)
        scale = SAME_ARM * np.abs(expected).max(initial=1e-9)
        same = found.shape == expected.shape
        if not (same and np.abs(found - expected).max() <= scale):
            fix = "calibrate this one"
            raise InputError(f"is of another robot: {what}", path, fix)


def _mechanics(dynamics: JointDynamics) -> Array:
    """(10 n,) torques by each of a payload's parameters in one motion, which the places
    and axes of all joints, the frame and gravity decide."""
    state = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 1, dynamics.joints))
    return (dynamics.regressor(*state)[0, :, -PAYLOAD:] @ dynamics.payload).ravel()


def _runs(data: dict[str, Any], dynamics: JointDynamics) -> EmptyRuns:
    n, arm = dynamics.joints, len(dynamics.base)
    size = len(OWN) + arm + PAYLOAD + 1
    if len(data["levels"]) != LEVELS + 1:
        raise ValueError("number of time scales")
    load = np.array(data["load"], dtype=float)
    if load.shape != (10 * n,) or not np.isfinite(load).all():
        raise ValueError("load")
    levels = []
    for level in data["levels"]:
        factors = _unpacked(level["factors"], n, size)
        counts = np.array(level["counts"], dtype=float)
        if counts.shape != (n,) or not (counts >= 0.0).all():
            raise ValueError("counts")
        levels.append(TorqueMoments(factors, len(OWN), counts))
    levels[-1] = replace(
        levels[-1],
        samples=int(data["samples"]),
        start=float(data["start"]),
        end=float(data["end"]),
    )
    known = Load(load, np.zeros(PAYLOAD))
    digests = data.get("runs", [])
    if not isinstance(digests, list) or {*map(type, digests)} - {str}:
        raise ValueError("runs")
    return EmptyRuns(TorqueScales(tuple(levels)), known, tuple(digests))


def _packed(factors: Array) -> list[list[float]]:
    rows, columns = np.triu_indices(factors.shape[1])
    return factors[:, rows, columns].tolist()


def _unpacked(packed: Any, joints: int, size: int) -> Array:
    values = np.array(packed, dtype=float)
    rows, columns = np.triu_indices(size)
    if values.shape != (joints, len(rows)) or not np.isfinite(values).all():
        raise ValueError("factors")
    factors = np.zeros((joints, size, size))
    factors[:, rows, columns] = values
    return factors
