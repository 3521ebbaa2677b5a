"""Cases of `hefting.core`: bodies, regressors, moments, and what is known of sensors,
scales and places."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
from scipy.spatial.transform import Rotation

from hammers import noisy
from hefting.core import regressor, spatial
from hefting.core.accuracy import Accuracy, errors_between
from hefting.core.gravity import Gravity, normal_gravity
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.measurements import Noise
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, Moments
from hefting.core.quantity import MassReading, decimals, quantity, rounded
from hefting.core.sensor_accuracy import SHEETS, SensorAccuracy
from hefting.core.torque_moments import TorqueMoments, merged, pseudo_inverse_half
from hefting.core.undetermined import Covariance
from random_problems import random_body, random_motion, random_pose, with_wrench
from torque_rows import folded, payload


def body() -> dict[str, Any]:
    """A body, moved, joined and taken apart; and ten numbers that are none."""
    rng = np.random.default_rng(1)
    one, other, pose = random_body(rng), random_body(rng, 0.3), random_pose(rng)
    values, axes = one.principal()
    impossible = InertialParameters(one.vector * (1, 1, 1, 1, 1, 1, 1, -0.2, 1, 1))
    return {
        "vector": one.vector,
        "at com": one.inertia_at_com,
        "pseudo": one.pseudo_inertia,
        "principal": values,
        "rebuilt": (axes * values) @ axes.T,
        "moved": one.moved(pose).vector,
        "both": (one + other).vector,
        "apart": (one - other).vector,
        "consistency": one.consistency(0.3),
        "inconsistency": impossible.consistency(-0.1),
        "jacobian": com_jacobian(one),
        "errors": errors_between(
            other,
            one,
            (0.1, 0.2, 0.3),
            Rotation.from_euler("xyz", (1, 2, 3)).as_matrix(),
        ),
    }


def frames() -> dict[str, Any]:
    """Rotations and changes of frame."""
    rng = np.random.default_rng(2)
    pose, wrench = random_pose(rng), rng.normal(size=(4, 6))
    a, w, alpha = rng.normal(size=(3, 4, 3))
    turn = np.array((0.3, -2.5, 1.1))
    R = spatial.rotation_by(turn)
    return {
        "inverse": spatial.inverse_pose(pose),
        "wrench": np.hstack(spatial.move_wrench(pose, wrench[:, :3], wrench[:, 3:])),
        "motion": np.hstack(spatial.move_motion(pose, a, w, alpha)),
        "rotation": R,
        "quaternion": spatial.quaternion_of(R),
        "vector": spatial.rotation_vector(R),
        "slight": spatial.rotation_vector(spatial.rotation_by(1e-9 * turn)) * 1e9,
        "half turn": np.abs(spatial.rotation_vector(np.diag((1.0, -1.0, -1.0)))),
        "pose": spatial.pose_matrix((0.1, 0.2, 0.3, 0.5, -0.5, 0.1, 0.7)),
    }


def regressors() -> dict[str, Any]:
    """Regressors, features and their weights, of samples of any motion."""
    rng = np.random.default_rng(3)
    z = random_motion(rng, 12)
    thing = random_body(rng)
    z = replace(with_wrench(z, thing, 0.3), weights=rng.uniform(0.5, 2.0, 12))
    moved = z.moved(random_pose(rng))
    return {
        "features": regressor.features(z),
        "motion": regressor.motion_features(z),
        "full": regressor.full_regressor(z),
        "reduced": regressor.reduced_regressor(z),
        "dynamism": regressor.dynamism(z),
        "weight": regressor.full_model_weight(z, 10.0),
        "wrench": regressor.predict_wrench(z, thing.vector),
        "moved": moved,
        "noisy": z.with_noise(Noise(0.1, 0.01, 0.05, 0.5), 4),
    }


def moments() -> dict[str, Any]:
    """Moments, folded, merged, weighed, and without a bias."""
    z = noisy(3, 90)
    z = replace(z, weights=np.random.default_rng(5).uniform(0.3, 3.0, len(z)))
    first, second = Moments.of(z[:50]), Moments.of(z[50:])
    both = first.merge(second, one_bias=True)
    scaled = first.fold(z[50:], np.linspace(0.1, 2.0, 40))
    free = both.without_bias().merge(scaled.scaled(3.0).without_bias())
    return {
        "both": both,
        "duration": both.duration,
        "one by one": second.fold(z[:1]),
        "scaled": scaled,
        "free": free,
        "holds a bias": [each.may_hold_bias for each in (both, free)],
        "full": {"factor": both.factor_of(FULL_EQUATIONS)},
        "reduced": {"factor": both.factor_of(REDUCED_EQUATIONS)},
    }


def covariance() -> dict[str, Any]:
    """A covariance with an open parameter and a direction without variance."""
    F = np.random.default_rng(6).normal(size=(10, 8)) * np.logspace(0, -4, 10)[:, None]
    C = F @ F.T
    C[4, :] = C[:, 4] = 0.0
    C[4, 4] = np.inf
    found = Covariance.of(C)
    beside = np.array(C)  # a covariance with what is open tells nothing
    beside[4, :4] = beside[:4, 4] = 0.01
    return {
        "size": found.size,
        "values": found.values,
        "open": found.open,
        "covariance": found.root @ found.root.T,
        "information": found.information,
        "beside what is open": Covariance.of(beside).values,
    }


def torques() -> dict[str, Any]:
    """Moments of joint torques with nuisances of the joints and of the arm, one of
    which the samples leave open."""
    rng = np.random.default_rng(7)
    rows, time = rng.normal(size=(120, 3, 18)), np.linspace(0.0, 1.19, 120)
    rows[:, :, 1] = rows[:, :, 0]
    used = rng.random((120, 3)) < 0.7
    empty = TorqueMoments.empty(3, 3, 4)
    parts = [
        folded(empty, rows[:70], time[:70]),
        folded(empty, rows[70:], time[70:], used[70:]),
    ]
    both = merged(parts)
    std = np.array((0.1, 0.3, 0.2))
    return {
        "counts": both.counts,
        "samples": both.samples,
        "duration": both.duration,
        "shared": {"factor": both.shared(std)},
        "payload": {"factor": payload(both, std)},
        "weighed": {"factor": payload(both.weighed(std))},
        "inverse": {"spread": pseudo_inverse_half(rows[:9, 0])},
    }


def sensors() -> dict[str, Any]:
    """Accuracies of sensors as written, as by data sheets, and what follows from
    them."""
    found: dict[str, Any] = {}
    stated = [sheet.model for sheet in SHEETS.values() if sheet.states_accuracy]
    for text in ("0.5% 0.3N 0.01Nm", "2%", "7N", "300mNm", *stated):
        one = SensorAccuracy.parse(text)
        found[text] = [
            (one.share, one.force, one.torque, one.lever),
            np.array((one.gain_std, one.slow_std)),
            one.offset_std,
            one.channel_stds[[0, 0, 3, 3], [0, 3, 0, 3]],
            one.none,
        ]
    return found


def readings() -> dict[str, Any]:
    """Scales, gravity, units, limits and rounding."""
    scales = ("0.512kg±1g", "512 g", "0.5kg", "1.25 lb ± 0.1oz", "2kg±1%")
    draws = random_body(np.random.default_rng(8)).vector
    draws = draws * np.random.default_rng(9).normal(1.0, 0.1, (400, 10))
    asked = Accuracy.parse("mass=1%,com=2mm,inertia=20%")
    claimed = Accuracy.of_draws(draws, InertialParameters(draws.mean(axis=0)), 0.95)
    places = [(0.0, 0.0), (45.0, 0.0), (-60.0, 1500.0), (90.0, -200.0)]
    widths = np.array((0.0123, 4.5, 0.0, np.inf, 1e-9, 99.6))
    return {
        "scales": {text: _scale(text) for text in scales},
        "gravity": np.array([normal_gravity(*place) for place in places]),
        "place": [Gravity.at(51.0), Gravity.at(51.0, 300.0).relative_std],
        "claimed": claimed,
        "met": [asked.met_by(claimed), claimed.met_by(claimed)],
        "places": decimals(widths, 34.0),
        "fewest": decimals(widths, 34.0, 3),
        "rounded": rounded(widths * 1.2345678, decimals(widths, 3.4)),
        "units": [
            quantity(text, cast(Any, kind))
            for text, kind in (
                ("2.5cm", "length"),
                ("3um", "length"),
                ("90deg", "angle"),
                ("3e1%", "share"),
                ("20mN", "force"),
                ("7mNm", "torque"),
                ("3oz", "mass"),
                ("2lb", "mass"),
            )
        ],
    }


def _scale(text: str) -> MassReading | None:
    return MassReading.of(text)


CASES = {
    "body": body,
    "frames": frames,
    "regressors": regressors,
    "moments": moments,
    "covariance": covariance,
    "torques": torques,
    "sensors": sensors,
    "readings": readings,
}
"""By name."""
