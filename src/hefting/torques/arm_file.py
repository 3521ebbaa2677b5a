"""An arm's calibration in a JSON file: the moments of its empty runs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import read_json, write_atomically
from hefting.core.spatial import Array
from hefting.core.torque_moments import PAYLOAD, TorqueMoments
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OWN, Load
from hefting.torques.runs import EmptyRuns
from hefting.torques.scales import LEVELS, TorqueScales

SCHEMA = "hefting-arm-1"
SAME_ARM = 1e-6
"""Relative difference of published parameters that is rounding."""


def save_arm(path: str | Path, dynamics: JointDynamics, runs: EmptyRuns) -> None:
    """Write an arm's calibration, whole or not at all."""
    scales = runs.scales
    last = scales.levels[-1]
    data = {
        "schema": SCHEMA,
        "joints": list(dynamics.names),
        "sensor_frame": dynamics.robot.sensor_frame,
        "published": dynamics.arm.tolist(),
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
    other joints or another order of them, or of another frame.
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
        raise InputError(
            f"is a damaged calibration ({str(error)[:80]})", path, "make it again"
        ) from None


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
    try:
        published = np.array(data.get("published"), dtype=float)
    except (TypeError, ValueError):
        published = np.zeros(0)
    scale = SAME_ARM * np.abs(dynamics.arm).max(initial=1e-9)
    same = published.shape == dynamics.arm.shape
    if not (same and np.abs(published - dynamics.arm).max() <= scale):
        raise InputError(
            "is of another robot: its URDF had other inertias",
            path,
            "calibrate this one",
        )


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
    samples = int(data["samples"])
    last = TorqueMoments(
        levels[-1].factors,
        len(OWN),
        levels[-1].counts,
        samples,
        float(data["start"]),
        float(data["end"]),
    )
    return EmptyRuns(TorqueScales((*levels[:-1], last)), Load(load, np.zeros(PAYLOAD)))


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
