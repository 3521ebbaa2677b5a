"""Runs of a robot, loaded and empty: from samples to the payload's equations; and an
arm's calibration in a JSON file.

Runs without the payload separate a small mass from a large offset, as all runs share
offsets and frictions. These change slowly as the gears warm up; two nuisances of the
loaded samples are the changes since the empty runs, with priors of their size.

Friction by load depends on the torques of the rigid bodies, which are unknown. So the
fit is repeated: first with the torques of the published arm, then with those of the
fit before.
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
from hefting.core.spatial import Array, immutable
from hefting.core.torque_moments import PAYLOAD, TorqueMoments
from hefting.torques import equations
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import LEVELS, OWN, Load, Rows, TorqueScales
from hefting.torques.noise import TorqueFit, fit
from hefting.torques.samples import TorqueSamples

OFFSET_CHANGE = 0.2
"""Standard deviation of the change of an offset between two runs, over that of the
joint's noise: 0.02 N m at a shoulder, after a minute of warm-up."""
FRICTION_CHANGE = 1.0
"""The same for the Coulomb friction, and at 1 rad/s for the viscous one."""
LARGEST_CHANGE = 3.0
"""Largest fitted change over these standard deviations; above it they are multiplied by
that ratio. 35 of 123 right pairs of runs of nine simulated arms have larger ones."""
FRICTION_BY_LOAD = 0.03
"""Standard deviation of the friction by load over the torque that causes it: strain wave
gears have some percent."""
EXACT = 1e-6
"""Standard deviation of a gain without an error: a smaller one would be lost by rounding."""
NO_CHANGE = 1e-3
"""Factor of `OFFSET_CHANGE` and `FRICTION_CHANGE` where nothing changes."""
LOAD_PASSES = 3
"""Number of fits before the last, each for the rigid-body torques of the next."""
PUBLISHED_ERROR = 0.5
"""Standard deviation of the arm's base parameters from the published ones, over their
size, where the samples do not determine them."""
TYPICAL_PAYLOAD = np.repeat((5.0, 0.5, 0.1), (1, 3, 6))
"""(10,) standard deviations of a payload's parameters [kg, kg m, kg m²]."""


@immutable
class EmptyRuns:
    """Calibration of an arm: moments of its runs without a payload."""

    scales: TorqueScales
    load: Load
    """of the columns of friction by load"""
    digests: tuple[str, ...] = ()
    """of the runs, by `TorqueSamples.digest`"""

    @classmethod
    def of(cls, dynamics: JointDynamics, runs: Sequence[TorqueSamples]) -> EmptyRuns:
        """Calibration by one or more runs."""
        rows = _rows(dynamics, (), runs, False)
        load = Load.published(dynamics)
        for _ in range(LOAD_PASSES):
            fitted = fit(_folded(dynamics, rows, load, 0), drifting)
            load = Load(_arm_of(dynamics, fitted), np.zeros(PAYLOAD))
        digests = tuple(run.digest for run in runs)
        return cls(_folded(dynamics, rows, load), load, digests)

    @property
    def fit(self) -> TorqueFit:
        """Arm, frictions and noise by these runs alone."""
        return fit(self.scales, drifting)


@immutable
class LoadedRuns:
    """Runs with the payload, and what is known about the arm; or empty runs only."""

    dynamics: JointDynamics
    loaded: tuple[TorqueSamples, ...]
    empty: tuple[TorqueSamples, ...] = ()
    calibration: EmptyRuns | None = None
    """from runs other than `empty`"""
    drift: bool = True
    """whether offsets and frictions may differ between empty and loaded runs; in parts
    of one recording they do not"""

    def __post_init__(self):
        if not (self.loaded or self.empty):
            raise InputError("there is no run with the payload")

    @property
    def arm_known(self) -> bool:
        """Whether the arm's parameters are taken from the URDF, without empty runs."""
        return not self.empty and self.calibration is None

    def fit(self) -> TorqueFit:
        """Least squares of all unknowns; its `state` holds the payload's equations."""
        calibration = self.calibration
        load = (
            Load.published(self.dynamics) if calibration is None else calibration.load
        )
        prior = partial(drifting, times=1.0 if self.drift else NO_CHANGE)
        rows = _rows(self.dynamics, self.loaded, self.empty, self.arm_known)
        for _ in range(LOAD_PASSES):
            load = loads_of(self, fit(self._scales(rows, load, 0), prior))
        scales = self._scales(rows, load)
        fitted = fit(scales, prior)
        # errors of gains and friction by load imitate changes
        changes = min(fitted.changes, fitted.of_usual_gains.changes)
        if self.drift and changes > LARGEST_CHANGE:
            fitted = fit(scales, partial(drifting, times=changes))
        return fitted

    def delayed(self, by: float, loaded: bool) -> Self:
        """The runs with a delay of the torques `by` [s] removed, in the `loaded` runs only
        or in all."""
        empty = self.empty if loaded else tuple(r.delayed(by) for r in self.empty)
        return replace(
            self, loaded=tuple(r.delayed(by) for r in self.loaded), empty=empty
        )

    def alone(self) -> list[TorqueFit]:
        """Separate fits of the loaded runs, with the payload as part of the last link, of
        the empty runs, and of the calibration."""
        runs = [EmptyRuns.of(self.dynamics, self.loaded)]
        if self.empty:
            runs.append(EmptyRuns.of(self.dynamics, self.empty))
        if self.calibration is not None:
            runs.append(self.calibration)
        return [each.fit for each in runs]

    def _scales(
        self, rows: Sequence[Rows], load: Load, differences: int = LEVELS
    ) -> TorqueScales:
        """Moments of the rows of all runs and of the calibration."""
        own = _folded(self.dynamics, rows, load, differences)
        if self.calibration is None:
            return own
        other = self.calibration.scales
        return own.merge(other if differences else TorqueScales((other.whole,)))


def drifting(std: Array, times: float = 1.0) -> Array:
    """Prior standard deviations (own, n) of the nuisances, for those of the noise (n,)
    [N m], of runs between which gears warm up; `times` multiplies those of the changes."""
    prior = np.full((len(OWN), len(std)), np.inf)
    prior[equations.FRICTION_BY_LOAD] = FRICTION_BY_LOAD
    prior[equations.GAIN] = EXACT
    changes = OFFSET_CHANGE, FRICTION_CHANGE, FRICTION_CHANGE
    prior[equations.CHANGES] = times * np.outer(changes, std)
    return prior


def no_samples(dynamics: JointDynamics, arm_known: bool = False) -> TorqueScales:
    """Moments of no samples."""
    arm = 0 if arm_known else len(dynamics.base)
    return TorqueScales.empty(dynamics.joints, len(OWN), arm)


def _rows(
    dynamics: JointDynamics,
    loaded: Sequence[TorqueSamples],
    empty: Sequence[TorqueSamples],
    arm_known: bool,
) -> tuple[Rows, ...]:
    """Rows of the empty runs, then of the loaded ones."""
    runs = *((run, False) for run in empty), *((run, True) for run in loaded)
    return tuple(Rows.of(dynamics, run, carries, arm_known) for run, carries in runs)


def _folded(
    dynamics: JointDynamics,
    rows: Sequence[Rows],
    load: Load,
    differences: int = LEVELS,
) -> TorqueScales:
    """Moments of the rows of all runs, with friction by `load`; of no `differences`
    where only what is fitted matters."""
    arm_known = any(own.published is not None for own in rows)
    scales = TorqueScales(no_samples(dynamics, arm_known).levels[: differences + 1])
    for own in rows:
        scales = scales.fold(own.under(dynamics, load))
    return scales


def loads_of(runs: LoadedRuns, fitted: TorqueFit) -> Load:
    """Arm and payload by a fit; without empty runs the calibration's or published
    arm."""
    calibration = runs.calibration
    arm = runs.dynamics.arm if calibration is None else calibration.load.arm
    if runs.empty:
        arm = _arm_of(runs.dynamics, fitted)
    return Load(arm, _payload_of(fitted))


def _arm_of(dynamics: JointDynamics, fitted: TorqueFit) -> Array:
    """(10 n,) parameters of the arm by a fit, zero outside the base parameters, with
    the published ones as a prior."""
    size = len(dynamics.base)
    published = dynamics.links @ dynamics.arm
    sizes = np.abs(published)
    if not sizes.any():  # a URDF without inertias
        sizes = np.tile(TYPICAL_PAYLOAD, dynamics.joints)[dynamics.base]
    scale = PUBLISHED_ERROR * (sizes + sizes.mean())
    prior_rows = np.zeros((size, size + PAYLOAD + 1))
    prior_rows[:, :size], prior_rows[:, -1] = np.diag(1.0 / scale), published / scale
    R = np.vstack((fitted.shared, prior_rows, _payload_rows(size)))
    arm = np.zeros(10 * dynamics.joints)
    arm[dynamics.base] = np.linalg.lstsq(R[:, :-1], R[:, -1], rcond=None)[0][:size]
    return arm


def _payload_of(fitted: TorqueFit) -> Array:
    """(10,) parameters of the payload by a fit and a prior of `TYPICAL_PAYLOAD`."""
    R = np.vstack((fitted.payload, _payload_rows(0)))
    payload = np.linalg.lstsq(R[:, :-1], R[:, -1], rcond=None)[0]
    return np.asarray(payload, dtype=float)


def _payload_rows(arm: int) -> Array:
    """(10, arm + 11) rows [arm | payload | torque] of the payload's prior."""
    rows = np.zeros((PAYLOAD, arm + PAYLOAD + 1))
    rows[:, arm : arm + PAYLOAD] = np.diag(1.0 / TYPICAL_PAYLOAD)
    return rows


SCHEMA = "hefting-arm-2"
SAME_ARM = 1e-6
"""Largest relative difference between numbers of the same arm, by rounding."""


def save_arm(path: str | Path, dynamics: JointDynamics, runs: EmptyRuns) -> None:
    """Write an arm's calibration to a JSON file, atomically."""
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
    """Read the calibration of an arm from a file.

    Raises `InputError` for a file that holds no calibration, or that of another robot,
    of other joints or another order of them, of another frame or gravity.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        fix = "make one: hefting calibrate EMPTY --torques --output arm.json"
        raise InputError("is no calibration of an arm", path, fix)
    _require_same(data, dynamics, path)
    try:
        return _runs(data, dynamics)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise _damaged(str(error), path) from None


def _damaged(what: str, path: Any) -> InputError:
    return InputError(f"is a damaged calibration ({what[:80]})", path, "make it again")


def _require_same(data: dict[str, Any], dynamics: JointDynamics, path: Any) -> None:
    """`InputError` unless a file is of this arm, frame and gravity."""
    names = data.get("joints")
    if names != list(dynamics.names):
        listed = ", ".join(map(str, names)) if isinstance(names, list) else "none"
        what = f"is of the joints {listed[:200]}, not {', '.join(dynamics.names)}"
        raise InputError(what, path, "calibrate this robot")
    frame, own = data.get("sensor_frame"), dynamics.robot.sensor_frame
    if frame != own:
        raise InputError(f"is for the frame '{str(frame)[:80]}', not '{own}'", path)
    for key, what, expected in (
        ("published", "its URDF had other inertias", dynamics.arm),
        ("mechanics", "it had other joints or another gravity", _mechanics(dynamics)),
    ):
        try:
            values = np.array(data.get(key), dtype=float)
        except (TypeError, ValueError, OverflowError):
            values = np.array(np.nan)
        if not np.isfinite(values).all():
            raise _damaged(key, path)
        scale = SAME_ARM * np.abs(expected).max(initial=1e-9)
        same = values.shape == expected.shape
        if not (same and np.abs(values - expected).max() <= scale):
            fix = "calibrate this one"
            raise InputError(f"is of another robot: {what}", path, fix)


def _mechanics(dynamics: JointDynamics) -> Array:
    """(10 n,) torques by unit parameters of a payload at one fixed state: they depend on
    positions and axes of all joints, the frame and gravity."""
    state = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 1, dynamics.joints))
    return (dynamics.regressor(*state)[0, :, -PAYLOAD:] @ dynamics.payload).ravel()


def _runs(data: dict[str, Any], dynamics: JointDynamics) -> EmptyRuns:
    """The calibration by a file's entries; `ValueError`, or another for damage."""
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
    digests = data.get("runs", [])
    if not isinstance(digests, list) or {*map(type, digests)} - {str}:
        raise ValueError("runs")
    return EmptyRuns(
        TorqueScales(tuple(levels)), Load(load, np.zeros(PAYLOAD)), tuple(digests)
    )


def _packed(factors: Array) -> list[list[float]]:
    """Upper triangles of factors (n, c, c), row by row."""
    rows, columns = np.triu_indices(factors.shape[1])
    return factors[:, rows, columns].tolist()


def _unpacked(packed: Any, joints: int, size: int) -> Array:
    """(joints, size, size) factors of `_packed` triangles; `ValueError` for others."""
    values = np.array(packed, dtype=float)
    rows, columns = np.triu_indices(size)
    if values.shape != (joints, len(rows)) or not np.isfinite(values).all():
        raise ValueError("factors")
    factors = np.zeros((joints, size, size))
    factors[:, rows, columns] = values
    return factors
