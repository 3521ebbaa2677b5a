"""Cases of the parts of `hefting.ingest`, one by one and before any of them has settled:
paths, fits, clock offsets, uncertainty, and drifts."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any
from unittest import mock

import numpy as np

from disturbances import body
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest import uncertainty
from hefting.ingest.condition import _numbers_of_knots
from hefting.ingest.drift import Drift, HatFunctions, candidates
from hefting.ingest.fit import gauss_newton
from hefting.ingest.model import Model, Problem
from hefting.ingest.offset import Design, _fit_at_offsets, _stands_out, scan_offsets
from hefting.ingest.offset_profile import OffsetProfile, profile_of
from hefting.ingest.path import path_of, static_path
from hefting.ingest.robust_fit import (
    RobustFit,
    choose_bias_and_refine_offset,
    fastest_frequency,
    fit_from_scratch,
    offset_is_significant,
    remove_offset,
)
from hefting.ingest.samples import Samples
from hefting.ingest.uncertainty import (
    estimate_uncertainty,
)
from reference.recorded import (
    FAULTS,
    accelerated,
    changing,
    fast,
    medium,
    motion,
    only,
    recorded,
    static_poses,
    stopping,
    with_columns,
)

GRAVITY = np.array(STANDARD_GRAVITY)
LATE = replace(FAULTS, wrench_delay=0.03, spikes=0.02, drift=(0.4,) * 3 + (0.02,) * 3)
RECORDINGS: dict[str, Callable[[], Recording]] = {
    "late": partial(recorded, medium, LATE),
    "fast": partial(recorded, fast, LATE),
    "orientation": lambda: only(recorded(stopping), "orientation", "wrench"),
    "accelerometer": accelerated,
    "columns": with_columns,
    "static": static_poses,
}
"""Of each kind of path."""


def problem_of(
    recording: Recording, *, free: bool = True, tilted: bool = False, knots: int = 2
) -> tuple[Samples, Problem]:
    """A fit of all samples."""
    path = static_path(recording) if recording.static else path_of(recording)
    assert path is not None
    wrench = recording["wrench"]
    samples = Samples(wrench.time, wrench.values, recording.static, path.smooth)
    numbers = (1,) if recording.static else tuple(range(1, knots + 1))
    free = free and path.moves
    return samples, Problem(path, samples.blocks(), free, tilted, numbers)


@cache
def robust(kind: str) -> tuple[Samples, RobustFit]:
    """The fit of the inliers with its uncertainty."""
    recording = changing(kind) if kind in CHANGES else RECORDINGS[kind]()
    samples, problem = problem_of(recording)
    first = fit_from_scratch(samples, problem, GRAVITY)
    return samples, choose_bias_and_refine_offset(samples, GRAVITY, first)


CHANGES = ("swapped", "put-down", "slipped", "touched")


def of_path(kind: str) -> Any:
    """Motion within, at the ends and beyond, with rates; and the model's columns."""
    _, problem = problem_of(RECORDINGS[kind]())
    path = problem.path
    ends = np.array((path.first, path.last))
    inner = np.linspace(problem.time[0], problem.time[-1], 40)
    times = np.concatenate((ends, ends + 1e-3, inner - 0.3))
    found = {"path": path.known_at(times), "kind": (path.smooth, path.moves)}
    if path.moves:
        found["reading"] = path.at(times, rates=True)
    for tilted in (False, True):
        model = Model.at(replace(problem, free_gravity=tilted), 0.004, GRAVITY)
        phi = body(1.1).vector
        found |= {
            f"columns {tilted}": model.columns(phi),
            f"predicted {tilted}": model.predict(phi),
            f"features {tilted}": model.features,
        }
    return found


def of_steps(kind: str, tilted: bool = False) -> Any:
    """Fits before they settle, from a rough start."""
    samples, problem = problem_of(RECORDINGS[kind](), tilted=tilted)
    start = scan_offsets(problem, GRAVITY, 2)
    start = replace(start, offset=start.offset + 0.004)
    found: dict[str, Any] = {"start": replace(start, reading=None)}
    for name, options in {
        "robust": {"robust": True, "steps": 1},
        "plain": {"steps": 2},
        "held": {"steps": 2, "hold_offset": True},
        "rough": {"robust": True, "steps": 2, "final": False},
    }.items():
        fit = gauss_newton(problem, start, 1 if samples.static else 2, **options)
        found[name] = {
            **{key: value for key, value in vars(fit).items() if key in OF_FIT},
            "offset": fit.offset,
            "gravity": fit.gravity,
        }
    return found


OF_FIT = {"phi", "bias", "scale", "weights", "spread", "residual", "solution"}


def of_offsets() -> Any:
    """Coarse fits at every offset."""
    _, problem = problem_of(RECORDINGS["late"](), tilted=True)
    grid = 0.02 * np.arange(-6.0, 7.0)
    measured = problem_of(accelerated())[1].every(150)
    found = {}
    for name, chosen, knots, alone in (
        ("found", problem.every(150), 2, False),
        ("alone", measured, 1, True),
    ):
        each = chosen, GRAVITY, knots, grid
        _, fits = _fit_at_offsets(*each, gravity_only=alone)
        design = Design.of(*each, gravity_only=alone)
        if name == "found":
            found["stands"] = _stands_out(fits, grid, 150)
        found[name] = {
            "offsets": grid,
            "likelihood": fits.likelihood,
            "phi": fits.solution[:, :10],
            "tilt": np.array([design.tilt_of(own) for own in fits.solution]),
            "scale": fits.scale,
            "bias": fits.solution[:, design.first_bias_column :].reshape(
                len(grid), -1, 6
            ),
        }
    return found


def of_uncertainty(kind: str) -> Any:
    """All of it, of a fit that is taken as it is."""
    _, found = robust(kind)
    each = estimate_uncertainty(found.fit, 0.2)
    length = max(len(found.fit.weights) // 3, 9)
    with mock.patch.object(uncertainty, "SEGMENT_LENGTH", length):
        parts = estimate_uncertainty(found.fit, 0.3)
        of_parts = (parts.covariance, parts.spectrum, parts.step, parts.slow)
    return {
        "fastest": fastest_frequency(found.problem),
        "each": {key: value for key, value in vars(each).items() if key != "fit"},
        "covariance": each.covariance,
        "of parts": of_parts,
        "inflation": each.inflation,
        "std": (each.offset_std, each.offset_step, each.tilt_std, each.mass_std),
        "explained": (found.explained, found.biased, found.mass_is_open),
        "significant": offset_is_significant(found),
        "knots": found.fit.hats.n,
        "outliers": found.outliers,
    }


def of_profile() -> Any:
    """How well each offset explains a wrench; and what is doubted."""
    found = [profile_of(robust(kind)[1]) for kind in ("late", "fast")]
    doubts = []
    for offset, gain, rival in (
        (0.05, 500, 9),
        (0.3, 900, 800),
        (0.15, 30, 1),
        (0.19, 9, 8),
    ):
        grid = 0.02 * np.arange(-10.0, 11.0)
        square = 1000.0 - gain * np.exp(-(((grid - offset) / 0.03) ** 2))
        square -= rival * np.exp(-(((grid + 0.12) / 0.03) ** 2))
        profile = OffsetProfile(grid, square, offset, 1000.0, 1000.0 - gain)
        doubts.append((profile.doubt() or "none", profile.rival, profile.required_gain))
    samples, problem = problem_of(RECORDINGS["late"]())
    first = fit_from_scratch(samples, problem, GRAVITY)
    without = remove_offset(samples, GRAVITY, first, robust("late")[1])
    return {
        "profiles": [
            each and {**vars(each), "all": (each.gain, each.share_left, each.rival)}
            for each in found
        ],
        "doubts": doubts,
        "without": (without.fit.phi, without.fit.bias, without.fit.scale),
    }


def of_drift() -> Any:
    """Functions of time, numbers of knots, and what is between."""
    time = np.sort(np.random.default_rng(73).uniform(3.0, 50.0, 60))
    rows = np.column_stack((np.sin(time), time, np.ones(60)))
    found: dict[str, Any] = {
        "candidates": [
            candidates(*pair)
            for pair in ((7.9, 0.0), (8.0, 0), (30.0, 0), (99.0, 20.0), (4e3, 1.0))
        ]
    }
    for n in (0, 1, 2, 5):
        hats = HatFunctions.over(time, n)
        part = hats.part(slice(7, 31))
        found[str(n)] = {
            "hats": hats,
            "projected": hats.project(rows),
            "gram": hats.gram(rows[:, 0] ** 2),
            "combined": hats.combine(np.eye(hats.n)),
            "part": part.combine(np.eye(hats.n)),
        }
    drift = Drift(time[::20], rows[::20] @ np.ones((3, 6)), rows[:3], np.ones(6))
    return found | {
        "drift": drift(time),
        "change": drift.change(time),
        "range": drift.range,
        "kind": drift.kind,
        "knots": _numbers_of_knots(
            problem_of(recorded(lambda: motion(90.0, 10.0, 0.15)))[1].path,
            np.array((0.0, 89.0)),
            GRAVITY,
        ),
    }


CASES: dict[str, Callable[[], Any]] = {
    **{f"path, {kind}": partial(of_path, kind) for kind in RECORDINGS},
    **{f"steps, {kind}": partial(of_steps, kind) for kind in RECORDINGS},
    "steps, tilted": partial(of_steps, "late", tilted=True),
    "offsets": of_offsets,
    **{f"uncertainty, {kind}": partial(of_uncertainty, kind) for kind in RECORDINGS},
    "profile": of_profile,
    "drift": of_drift,
}
"""By name."""
