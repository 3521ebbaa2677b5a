"""Cases of `hefting.ingest.rivals`: each mistake by its own explanation, and each
explanation of recordings that are right, or wrong in another way."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any
from unittest.mock import patch

import numpy as np
from benchmarks.given import Given
from benchmarks.mistaken import mistakes

from hefting.core.spatial import STANDARD_GRAVITY, Array, rotation_by
from hefting.ingest import condition
from hefting.ingest.filtering import Signal
from hefting.ingest.path import path_of, static_path
from hefting.ingest.rivals import (
    EXPLANATIONS,
    LARGE_EXPLANATIONS,
    LINEAR_EXPLANATIONS,
    axes_turned,
    axis_flipped,
    base,
    bias,
    consequence,
    elastic,
    not_rigid,
    placement,
    pose_forms,
    sensor_calibration,
    timing,
    units,
)
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.consequence import doubt_of
from hefting.ingest.rivals.explanation import (
    Explanation,
    as_given,
    fit_as_given,
    newton_euler,
)
from hefting.ingest.rivals.judge import evidence, judge_one
from hefting.ingest.rivals.placement import advice
from reference.recorded import (
    accelerated,
    changed,
    given,
    only,
    recorded,
    short,
    static_poses,
    stopping,
)

NAMES = {
    base.explain: "base_tilted",
    base.explain_axes: "base_axes",
    bias.explain: "bias_wrong",
    bias.explain_drift: "short_drift",
    not_rigid.explain_change: "object_changing",
    not_rigid.explain_sloshing: "sloshing",
    timing.explain_clock_rate: "clock_rate",
    timing.explain_filter: "wrench_filtered",
    pose_forms.explain: "orientation_form",
    pose_forms.explain_order: "quaternion_order",
    pose_forms.explain_composed: "orientation_form",
    pose_forms.explain_inverse: "pose_inverse",
    pose_forms.explain_position_axes: "position_axes",
    sensor_calibration.explain: "calibration_matrix",
    sensor_calibration.explain_by_load: "gain_by_load",
    sensor_calibration.explain_channel: "one_channel",
    sensor_calibration.explain_hysteresis: "hysteresis",
    placement.explain_lever: "lever_arm",
    units.explain_position: "position_unit",
    units.explain_time: "time_unit",
    units.explain_force: "force_unit",
    elastic.explain_grip: "elastic_grip",
    elastic.explain_mount: "elastic_mount",
    axes_turned.explain_with_tilt: "turned_and_tilted",
    axis_flipped.explain_turned_apart: "turned_apart",
    axes_turned.explain_with_axis: "turned_and_tilted",
}
RIVALS = {
    NAMES.get(explain, explain.__module__.rpartition(".")[2]): explain
    for explain in (*EXPLANATIONS, *LINEAR_EXPLANATIONS, *LARGE_EXPLANATIONS)
}
"""Explanations by the names of their files, or by their own of several in a file."""
OWN = {
    "turned about z, 30°": "axes_turned",
    "turned about a diagonal, 120°": "axes_turned",
    "turned about x, 10°": "axes_turned",
    "quaternion order, w first": "quaternion_order",
    "inverse pose, whole": "pose_inverse",
    "axis flipped, fx": "axis_flipped",
    "axis flipped, all torques": "axis_flipped",
    "columns swapped, x and y": "axis_flipped",
    "torque turned alone, 45°": "turned_apart",
    "wrench in base axes, ": "base_axes",
    "bias none, 5 N": "bias_wrong",
    "another run's bias, 3 N": "bias_wrong",
    "unit of position, mm": "position_unit",
    "unit of position, in": "position_unit",
    "unit of force, kgf": "force_unit",
    "unit of torque, N cm": "force_unit",
    "compensated wrench, 60% of the payload": "wrench_compensated",
    "low-passed, 2 Hz": "wrench_filtered",
    "low-passed, 0.7 Hz": "wrench_filtered",
    "flange behind sensor, 50 mm": "lever_arm",
    "torque about the TCP, 150 mm": "lever_arm",
    "pose clock fast, 1.0%": "clock_rate",
    "pose clock fast, 3.0%": "clock_rate",
    "base tilted, 5°": "base_tilted",
    "base tilted, 15°": "base_tilted",
    "gravity, upwards": "base_tilted",
    "gain of one axis, 10%": "calibration_matrix",
    "cross-talk, 3%": "calibration_matrix",
    "play, 3%": "hysteresis",
    "cable, 5 N/m": "cable",
    "sloshing, 30%": "sloshing",
}
"""Mistakes of the benchmark, and the explanation of each."""


@cache
def case_of(mistake: str = "") -> Case:
    """The case of a mistake in a recording of 10 s, or of none."""
    wrong = given()
    if mistake:
        (found,) = (m for m in mistakes() if f"{m.name}, {m.strength}" == mistake)
        wrong = found.make(wrong, np.random.default_rng(60))
    return _case(wrong)


def _case(wrong: Given) -> Case:
    gravity = np.array(wrong.options.get("gravity", STANDARD_GRAVITY), dtype=float)
    recording, bias = wrong.recording, wrong.options.get("bias", "auto")
    if not isinstance(bias, str):
        recording = changed(recording, "wrench", lambda _, w: w - bias)
    path = path_of(recording)
    assert path is not None
    offset = condition(recording, gravity, changes=False).offset
    return Case.of(recording, path, gravity, offset, biased="bias" not in wrong.options)


@cache
def other_case(kind: str) -> Case:
    """Recordings of other kinds."""
    gravity = np.array(STANDARD_GRAVITY)
    if kind == "static":
        poses = static_poses()
        return Case.of(poses, static_path(poses), gravity, 0.0, biased=True)
    recording = {
        "short": recorded(short),
        "accelerated": accelerated(),
        "orientations": only(recorded(stopping), "orientation", "wrench"),
    }[kind]
    path = path_of(recording)
    assert path is not None
    return Case.of(recording, path, gravity, 0.011, biased=kind != "orientations")


def told(case: Case, found: Explanation | None) -> Any:
    """All of an explanation."""
    if found is None:
        return "none"
    fitted = found.fitted
    return {
        **{
            name: value
            for name, value in vars(found).items()
            if name not in ("fitted", "of_many_laws")  # a fact of the kind, no result
        },
        "vector": found.vector,
        "likelihood": found.likelihood,
        "evidence": evidence(case, as_given(case), found),
        "likelihoods": fitted.likelihood,
        "solution": fitted.solution[fitted.best],
        "scale": fitted.scale[fitted.best],
        "weights": fitted.weights[fitted.best],
        "residual": fitted.residual[fitted.best],
    }


def explained(case: Callable[[], Case], rival: str) -> Any:
    """One explanation of a case."""
    return told(case(), RIVALS[rival](case()))


def judged(case: Callable[[], Case]) -> Any:
    """What is named, and what is said of it; judged once."""
    found = judge_one(case())
    named = None if found.named is None else told(case(), found.named)
    with patch.object(consequence, "judge", lambda _: found):
        doubt = doubt_of(case())
    return {"judged": replace(found, named=None, given=None), "named": named} | {
        "doubt": doubt
    }


def cases(kind: str) -> Any:
    """What explanations are judged by."""
    case = other_case(kind) if kind else case_of()
    wide = replace(case, biased=not case.biased)
    fitted, offset = fit_as_given(case)
    return {
        "time": case.time,
        "wrench": case.wrench,
        "noise": case.noise,
        "floor": case.floor,
        "offsets": case.offsets,
        "gravity": case.modelled_gravity,
        "bias": case.bias_functions,
        "no bias": wide.bias_functions,
        "features": case.motion.features(case.gravity),
        "axes": case.motion.axes,
        "known": case.motion.known,
        "as found": case.motion_as_found.features(case.gravity),
        "offset": offset,
        "given": told(case, as_given(case)),
        "likelihoods": fitted.likelihood,
    }


def _fix_of(turn: Array) -> str:
    """What is to be typed for a turn [degrees about each axis]."""
    R = rotation_by(np.radians(turn))
    return advice(case_of("turned about x, 10°"), R, np.zeros(3), np.eye(3) * 2.5e-5)


def parts() -> dict[str, Any]:
    """Parts of explanations."""
    time = np.arange(0.0, 3.0, 0.01)
    values = np.column_stack([np.sin(f * time) for f in (2.0, 5.0, 7.0)]) + 0.3
    six = np.hstack((5.0 * values, 0.2 * values[:, ::-1]))
    from_zero = Signal(np.vstack((np.zeros(3), values)), 100.0)
    matrices = [matrix for _, matrix, _ in axis_flipped._changes()]
    case = case_of("turned about x, 10°")
    rows = newton_euler(case, case.motion)
    scale = np.tile((0.3, 0.02), (len(case.offsets), 1))
    turned, value = axes_turned._ascend(
        case, rows, rows.used, scale, axes_turned.QUARTER_TURNS
    )
    Q, square = axes_turned._quadratic(case, rows, rows.used, scale)
    errors = 0.01 * np.random.default_rng(61).normal(size=(6, 6))
    return {
        "swing": not_rigid.swing(Signal(values, 100.0), 1.5, 0.1),
        "swings": not_rigid._Driven.of(case).swinging(2.0, 0.05),
        "filtered": [timing.low_passed(from_zero, order, 1.7)[1:] for order in (1, 2)],
        "lag": list(sensor_calibration._lags(six, np.array((0.01, 0.2)))),
        "flips": matrices,
        "starts": axes_turned.QUARTER_TURNS,
        "fixes": {
            str(turn): list(TYPED.findall(_fix_of(np.array(turn)))) for turn in TURNS
        },
        "ascent": (turned, value, Q, square),
        "matrix": [
            sensor_calibration._largest_error(
                np.array(each), np.array((9, 8, 7, 1, 1, 0.5))
            )
            for each in (errors, errors * (1.0 + 9.0 * np.eye(6)))
        ],
    }


TURNS = (
    (0, 0, 45.2),
    (0, -30, 0),
    (180, 0, 0.1),
    (0, 0, -179.9),
    (9, 12, -7),
    (3, 0, 0),
)
"""Turns of a sensor [degrees]."""
TYPED = re.compile(r"[xyz]:|-?\d+\.?\d*")
"""Axis and numbers of what is to be typed."""
JUDGED = (
    "turned about z, 30°",
    "axis flipped, fx",
    "columns swapped, x and y",
    "bias none, 5 N",
    "unit of force, kgf",
    "low-passed, 2 Hz",
    "base tilted, 5°",
    "gain of one axis, 10%",
    "play, 3%",
    "cable, 5 N/m",
    "sloshing, 30%",
)
"""Mistakes that are also told from all others."""
KINDS = ("short", "static", "orientations", "accelerated")
"""Recordings of other kinds."""

CASES: dict[str, Callable[[], Any]] = {
    **{
        mistake: partial(explained, partial(case_of, mistake), rival)
        for mistake, rival in OWN.items()
    },
    **{
        f"{mistake}, judged": partial(judged, partial(case_of, mistake))
        for mistake in JUDGED
    },
    **{f"right, {rival}": partial(explained, case_of, rival) for rival in RIVALS},
    **{
        f"wrong, {rival}": partial(
            explained, partial(case_of, "turned about x, 10°"), rival
        )
        for rival in RIVALS
    },
    **{
        f"static, {rival}": partial(explained, partial(other_case, "static"), rival)
        for rival in ("axes_turned", "axis_flipped", "base_tilted", "base_axes")
    },
    **{
        f"accelerated, {rival}": partial(
            explained, partial(other_case, "accelerated"), rival
        )
        for rival in ("wrench_compensated", "lever_arm", "force_unit", "cable")
    },
    **{f"{kind}, judged": partial(judged, partial(other_case, kind)) for kind in KINDS},
    "right, judged": partial(judged, case_of),
    **{f"case, {kind}": partial(cases, kind) for kind in KINDS},
    "case": partial(cases, ""),
    "parts": parts,
}
"""By name."""
