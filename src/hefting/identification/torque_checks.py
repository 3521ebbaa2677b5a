"""Checks of joint torques: whether they can be those of the arm, and what an answer from
them leaves in doubt."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, error, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.core.torque_moments import PAYLOAD
from hefting.identification.checks import mass_undetermined
from hefting.robots.joint_log import angle_doubts
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import STICTION_SPEED
from hefting.torques.noise import TorqueFit
from hefting.torques.rivals import better_rival
from hefting.torques.runs import TYPICAL_PAYLOAD, EmptyRuns, LoadedRuns
from hefting.torques.samples import LEAST_TURN, UR_JOINT, TorqueSamples

LARGEST_MISFIT = 2.0
"""Slow residual of any joint by empty and loaded runs together over that of each alone,
from which on they are not of the same arm: of the same simulated robot it was at most
1.03, of others of its kind at least 4.7."""
LEAST_LOAD = 2.0
"""Mass over its standard deviation below which no load is seen."""
NEGATIVE = 4.0
"""The same of a mass below zero, from which on it is no chance."""
LARGEST_EFFORT = 3.0
"""Torque of a joint over the URDF's limit, for half of the motion, that no arm has."""
LARGEST_TORQUE = 30.0
"""Torques over those that the URDF's arm needs, from which on they are of another unit:
of simulated and real runs they were 0.9 to 1.8."""
UNIT = 0.3, 5.0
"""The same, least and most, of what no payload, offset or Coulomb friction explains:
of simulated and real runs it was 0.7 to 1.4."""
ALIKE = 0.75
"""Correlation of both from which on that ratio tells the unit: of right runs mostly
above 0.9, of external or compensated torques at most 0.63."""
OPPOSED = -0.8
"""Correlation of both below which torques or gravity have another sign: of right runs
it was at least 0.85."""
CHECKED = 300
"""Samples of a run that are compared with the URDF's arm."""


def require_arms_torques(
    samples: TorqueSamples, dynamics: JointDynamics, source: str
) -> None:
    """`InputError` for a run that is too slow, for angles in degrees, for a moving
    joint's torque that never changes, and for torques of another unit or sign than the
    URDF's arm needs."""
    for doubt in angle_doubts(samples.position, dynamics.robot):
        raise InputError(str(doubt), source)
    speed = np.abs(samples.velocity).max()
    if speed < STICTION_SPEED:
        raise InputError(
            f"no joint moves faster than {speed:.2g} rad/s, and below "
            f"{STICTION_SPEED:g} rad/s friction has no law",
            source,
            "move faster; or is its time in milliseconds?",
        )
    turned, changed = (np.ptp(x, axis=0) for x in (samples.position, samples.torque))
    for j in np.flatnonzero((turned > LEAST_TURN) & (changed == 0.0)):
        what = f"the torque of {dynamics.names[j]} never changes though it moves"
        raise InputError(what, source, "check its column")
    part = samples[:: max(1, len(samples.time) // CHECKED)]
    states = part.position, part.velocity, part.acceleration
    needed, torque = dynamics.regressor(*states) @ dynamics.arm, part.torque
    square, both = float((needed**2).sum()), float((needed * torque).sum())
    over = np.median(np.abs(torque), axis=0) > LARGEST_EFFORT * dynamics.efforts
    if over.any() and both > LARGEST_TORQUE * square:
        raise InputError(
            f"the torques are {both / square:.3g} times those of the URDF's arm, and "
            f"beyond the limit of {dynamics.names[int(np.argmax(over))]}",
            source,
            "give them in N m",
        )
    if both < OPPOSED * (square * float((torque**2).sum())) ** 0.5:
        raise InputError(
            "the torques have the other sign than those of the URDF's arm",
            source,
            "give those that the motors exert on the links, or another `gravity`",
        )


def of_unit(
    dynamics: JointDynamics, runs: Iterable[TorqueSamples]
) -> Iterable[Message]:
    """An error where the torques are in proportion to those of the URDF's arm, but far
    from them."""
    ratios = [share_of_arm(dynamics, samples) for samples in runs]
    ratio = max(ratios, key=lambda value: abs(np.log(value)), default=1.0)
    if UNIT[0] < ratio < UNIT[1]:
        return []
    what = (
        f"the torques are {ratio:.2g} times those of the URDF's arm: give N m, not kgf m, "
        "kgf cm or N mm, and check `torque_gains` and the URDF's inertias"
    )
    return [error("torque-unit", what, "torque_gains")]


def share_of_arm(dynamics: JointDynamics, samples: TorqueSamples) -> float:
    """Torques over those of the URDF's arm, without what any payload, offset and
    Coulomb friction explain of both; 1 where the rest is not alike."""
    part = samples[:: max(1, len(samples.time) // CHECKED)]
    W = dynamics.regressor(part.position, part.velocity, part.acceleration)
    one = np.eye(dynamics.joints)
    friction = np.sign(part.velocity)[:, :, None] * one
    offset = np.broadcast_to(one, friction.shape)
    others = np.concatenate((W[:, :, -PAYLOAD:], offset, friction), axis=2)
    A = others.reshape(-1, others.shape[2])
    both = np.column_stack(((W @ dynamics.arm).ravel(), part.torque.ravel()))
    left = both - A @ np.linalg.lstsq(A, both, rcond=None)[0]
    (square, product), (_, own) = left.T @ left
    if not product > ALIKE * (square * own) ** 0.5:
        return 1.0
    return float(product / square)


def of_gains(recording: Recording, gains: Array | None) -> list[Message]:
    """A warning about gains of what is said to be torque; a UR driver's is not."""
    if gains is None or not recording.has("joint_torques") or np.all(gains == 1.0):
        return []
    if UR_JOINT in recording.joint_names:
        return []
    what = (
        f"{recording.source} says torque, which was multiplied by `torque_gains`: leave "
        "them out where it is in N m"
    )
    return [warning("gains-on-torques", what, "torque_gains")]


def of_rivals(
    dynamics: JointDynamics, runs: Sequence[TorqueSamples]
) -> Iterable[Message]:
    """An error where another order or sign of joints, or another gravity, explains the
    torques far better."""
    better = better_rival(dynamics, runs)
    if better is None:
        return []
    words, times = better
    what = (
        f"the torques are explained far better {words} (residuals up to {times:.1f} "
        "times smaller): put the log right, or `gravity`"
    )
    return [error("torques-of-other-arm", what, "gravity")]


def of_arm(runs: LoadedRuns, found: TorqueFit) -> list[Message]:
    """What was taken for the arm, where it may be another."""
    if runs.arm_known:
        what = (
            "the URDF's inertias stand for the arm's: a published arm was found to put "
            "the mass of 1 kg wrong by 57 to 100 g and its COM by 5 to 15 mm, and the "
            "intervals allow for that: record an empty run (`empty`)"
        )
        return [warning("arm-published", what, "empty")]
    each = [EmptyRuns.of(runs.dynamics, runs.loaded)]  # with the payload as a link
    if runs.empty:
        each.append(EmptyRuns.of(runs.dynamics, runs.empty))
    if runs.calibration is not None:
        each.append(runs.calibration)
    alone = np.max([one.fit.slow_std for one in each], axis=0)
    ratio = float((found.slow_std / alone).max())
    if not ratio > LARGEST_MISFIT:
        return []
    what = (
        "empty and loaded runs contradict each other: together their slow residuals "
        f"are {ratio:.1f} times those of each alone: are they of the same robot, with "
        "the same tool, and in the same order of joints?"
    )
    return [error("empty-run-contradicts", what, "empty")]


def of_load(estimate: Estimate, fit: TorqueFit) -> Iterable[Message]:
    """An error where no load is seen, or its mass is not determined."""
    if estimate.covariance is None:
        return []
    std = float(estimate.covariance[0, 0]) ** 0.5
    if estimate.mass > LEAST_LOAD * std:
        return mass_undetermined(estimate)
    what = (
        f"the torques show no load ({estimate.mass:.3g} ± {std:.2g} kg): "
        f"{cause_of_no_load(fit)}"
    )
    return [error("no-load-seen", what)]


def of_torques(message: str, fit: TorqueFit) -> str:
    """What a method says of a wrench, as what is said of torques."""
    if not isinstance(message, Message):
        return message
    text = message.replace("the wrench", "the torques")
    if message.code == "mass-contradicts-wrench":
        text = (
            f"the scale contradicts the torques, which show {fit.common[-PAYLOAD]:.4g} "
            "kg, and is left out: is its unit right, was the same weighed that the empty "
            "run lacks, and are the torques' constants (`torque_gains`) right?"
        )
    return Message(message.code, text, message.severity, message.argument)


def cause_of_no_load(fit: TorqueFit) -> str:
    """Why no load is seen, by the mass of least squares."""
    mass, std = float(fit.common[-PAYLOAD]), float(fit.covariance[0, 0]) ** 0.5
    if not std < TYPICAL_PAYLOAD[0]:
        return "they hardly tell it: move faster, and shoulder and elbow too"
    if mass < -NEGATIVE * std:
        return (
            f"least squares finds {mass:.3g} ± {std:.2g} kg: are empty and loaded runs "
            "exchanged, or is the sign not that of the motors' torques?"
        )
    return "does the controller compensate the payload already?"
