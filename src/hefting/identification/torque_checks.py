"""Checks of joint torques: whether they can be those of the arm, and doubts about their
estimate."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, error, note, warning
from hefting.core.quantity import significant
from hefting.core.recording import Recording
from hefting.core.spatial import Array, angle_between
from hefting.core.torque_moments import PAYLOAD, pseudo_inverse_half
from hefting.identification.checks import mass_undetermined
from hefting.identification.torque_suspects import give_gravity, levelled
from hefting.robots.joint_motion import angle_doubts
from hefting.torques.dynamics import JointDynamics
from hefting.torques.noise import TorqueFit
from hefting.torques.rivals import better_rival
from hefting.torques.runs import (
    FRICTION_CHANGE,
    LARGEST_CHANGE,
    TYPICAL_PAYLOAD,
    LoadedRuns,
)
from hefting.torques.samples import LEAST_TURN, STICTION_SPEED, UR_JOINT, TorqueSamples

LARGEST_MISFIT = 2.0
"""Slow residual of a joint by empty and loaded runs together over that of each alone,
above which they are not of the same arm: for others of its kind it was at least 2.4."""
LEAST_LOAD = 2.0
"""Mass over its standard deviation below which no load is significant."""
NEGATIVE = 4.0
"""The same ratio above which a negative mass is significant."""
LARGEST_EFFORT = 3.0
"""Impossible torque of a joint over the URDF's limit, during half of the motion."""
LARGEST_TORQUE = 30.0
"""Torques over those that the URDF's arm needs, above which they have another unit: in
simulated and real runs they were 0.9 to 1.8."""
UNIT = 0.3, 5.0
"""Smallest and largest normal `share_of_arm`: in simulated and real runs 0.7 to 1.4."""
ALIKE = 0.75, 0.975
"""Correlation in `share_of_arm` above which the ratio shows the unit, the second for
ratios below `UNIT`. In right runs it was mostly above 0.98, for external or compensated
torques at most 0.97."""
LEAST_SEEN = 10.0
"""Size of the part of the torques in `share_of_arm`, in standard deviations of the noise,
below which it is chance."""
GAIN_ERROR = 0.1
"""Error of a joint's gain that is normal, and standard deviation above which nothing is
reported on it."""
LINK_ERROR = 0.05, 0.01
"""Standard deviation of each parameter of a link from the URDF's, over its own and over
the link's mass [m, m²]."""
OPPOSED = -0.8
"""Correlation of the torques with those of the URDF's arm below which they, or gravity,
have the other sign: in right runs it was at least 0.85."""
OFF_AXIS = np.radians(15.0)
"""Angle of gravity from an axis of the base above which errors of the links do not
explain it."""
CHECKED = 300
"""Number of samples of a run that are compared with the URDF's arm."""


def require_arms_torques(
    samples: TorqueSamples, dynamics: JointDynamics, source: str
) -> None:
    """`InputError` for a run that is too slow, for angles in degrees, for a moving
    joint's torque that never changes, and for torques of another unit or sign than the
    URDF's arm needs."""
    for doubt in angle_doubts(samples.position, dynamics.robot):
        raise InputError(str(doubt), source, "if so, name the columns 'q1 [deg]' ...")
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
        what = "the torques have the other sign than those of the URDF's arm"
        fix = "give those that the motors exert on the links, or another `gravity`"
        raise InputError(what, source, fix)


def of_unit(dynamics: JointDynamics, fits: Iterable[TorqueFit]) -> list[Message]:
    """An error for torques that are proportional to those of the URDF's arm, but far
    from them; a note if their unit cannot be checked."""
    shares = [share_of_arm(dynamics, each) for each in fits]
    clear = [x for x, alike in shares if abs(alike) > ALIKE[abs(x) < UNIT[0]]]
    if not clear:
        what = (
            "the URDF's arm cannot show the torques' unit: it moves too little, has no "
            "inertias, or its own torques are subtracted"
        )
        return [note("torque-unit-untold", what)]
    far = [share for share in clear if not UNIT[0] < share < UNIT[1]]
    if not far:
        return []
    what = (
        f"the torques are {significant(far[0])} times those of the URDF's arm: give N m, not kgf "
        "m, kgf cm or N mm, and check `torque_gains` and the URDF's inertias"
    )
    return [error("torque-unit", what, "torque_gains")]


def share_of_arm(dynamics: JointDynamics, fit: TorqueFit) -> tuple[float, float]:
    """Ratio of the torques to those of the URDF's arm, both without the part that any
    payload, offset and friction explain, and their correlation."""
    size = len(dynamics.base)
    links = fit.shared[:size, :size] @ dynamics.links
    both = np.column_stack((links @ dynamics.arm, fit.shared[:size, -1]))
    free = links[:, -PAYLOAD:]
    left = both - free @ np.linalg.lstsq(free, both, rcond=None)[0]
    (square, product), (_, own) = left.T @ left + 1e-99
    alike = product / (square * own) ** 0.5 if own > LEAST_SEEN**2 else 0.0
    return float(product / square), float(alike)


def of_joints(dynamics: JointDynamics, fits: Iterable[TorqueFit]) -> list[Message]:
    """A warning about joints whose torques are not those of the URDF's arm, by runs
    without the payload."""
    for fit in fits:
        gain, std = joint_gains(dynamics, fit)
        z = np.where(std < GAIN_ERROR, (np.abs(gain - 1.0) - GAIN_ERROR) / std, 0.0)
        each = (f"{dynamics.names[j]} {gain[j]:.2g}" for j in np.flatnonzero(z > 2.0))
        if names := ", ".join(each):
            what = (
                f"torques over those of the URDF's arm are {names}: check "
                "`torque_gains`, joint zeros and the URDF's inertias"
            )
            return [warning("torque-gain", what, "torque_gains")]
    return []


def joint_gains(dynamics: JointDynamics, fit: TorqueFit) -> tuple[Array, Array]:
    """(n,) ratios of the torques to those of the URDF's arm, with a prior of 1 ± 1, and
    their standard deviations (n,), which allow for errors of the links and any payload
    on the last one."""
    n, size = dynamics.joints, len(dynamics.base)
    slow = np.maximum(fit.slow_std / fit.std, 1.0)
    rows = fit.moments.without_nuisances[:, :size] / slow[:, None, None]
    links = rows[:, :, :size] @ dynamics.links
    needed = links @ dynamics.arm
    std = link_errors(dynamics).reshape(n, PAYLOAD)
    std[-1] = TYPICAL_PAYLOAD
    each = needed[:, :, None] * np.eye(n)[:, None]
    A = np.concatenate((each, links * std.ravel()), axis=2).reshape(n * size, -1)
    half = pseudo_inverse_half(np.vstack((A, np.eye(A.shape[1]))))
    found = half[:n] @ (half.T @ (A.T @ (rows[:, :, -1] - needed).ravel()))
    return 1.0 + found, np.linalg.norm(half[:n], axis=1)


def link_errors(dynamics: JointDynamics) -> Array:
    """(10 n,) standard deviations of the links' parameters from the URDF's."""
    arm = dynamics.arm.reshape(-1, PAYLOAD)
    return (LINK_ERROR[0] * np.abs(arm) + LINK_ERROR[1] * arm[:, :1]).ravel()


def of_gains(recording: Recording, gains: ArrayLike | None) -> list[Message]:
    """A warning of gains given for recorded torques, except a UR driver's."""
    is_torque = recording.has("joint_torques") and UR_JOINT not in recording.joint_names
    if gains is None or not is_torque or np.all(np.equal(gains, 1.0)):
        return []
    what = (
        f"{recording.source} says torque, which was multiplied by `torque_gains`: leave "
        "them out where it is in N m"
    )
    return [warning("gains-on-torques", what, "torque_gains")]


def of_rivals(
    dynamics: JointDynamics, runs: Sequence[TorqueSamples]
) -> Iterable[Message]:
    """An error if another order or sign of joints, or another gravity, explains the
    torques far better."""
    better = better_rival(dynamics, runs)
    if better is None:
        return []
    rival, times = better
    words, fix, argument = rival.words, "put the log right", None
    if rival.dynamics is not dynamics:
        g, argument = rival.dynamics.gravity, "gravity"
        found = levelled(LoadedRuns(rival.dynamics, (), tuple(runs)))
        if angle_between(g, found) > OFF_AXIS:
            turned = np.degrees(angle_between(dynamics.gravity, found))
            g, words = found.round(3), f"with gravity turned by {turned:.0f}°"
        fix = give_gravity(g)
    what = f"the torques are explained far better {words} (residuals up to {times:.1f} times smaller): {fix}"
    return [error("torques-of-other-arm", what, argument)]


def of_arm(
    runs: LoadedRuns, found: TorqueFit, each: Sequence[TorqueFit]
) -> list[Message]:
    """A message if the arm that was assumed may be another one; `each` is that of
    `LoadedRuns.alone`."""
    if runs.arm_known and not runs.dynamics.arm.any():
        what = "the URDF has no inertias: record an empty run (`empty`)"
        return [error("arm-unknown", what, "empty")]
    if runs.arm_known:
        what = (
            "the arm's inertias are those of the URDF: with a published arm a mass of "
            "1 kg was off by 57 to 100 g and its COM by 5 to 15 mm, for which the "
            "intervals allow: record an empty run (`empty`)"
        )
        return [warning("arm-published", what, "empty")]
    alone = np.max([one.of_usual_gains.slow_std for one in each], axis=0)
    ratio = float((found.of_usual_gains.slow_std / alone).max())
    if not ratio > LARGEST_MISFIT:
        wider = float((found.prior[-1] / found.std).max()) / FRICTION_CHANGE
        if not wider > LARGEST_CHANGE:
            return []
        what = (
            f"offsets or friction changed between empty and loaded runs by {wider:.1f} "
            "times what is usual, which is in the intervals: record an empty run again"
        )
        return [warning("joints-changed", what, "empty")]
    what = (
        "empty and loaded runs contradict each other: together their slow residuals "
        f"are {ratio:.1f} times those of each alone: are they of the same robot, with "
        "the same tool, in the same order of joints? Is the base level (`gravity`), are "
        "joint zeros and gains right?"
    )
    return [error("empty-run-contradicts", what, "empty")]


def of_load(estimate: Estimate, fit: TorqueFit) -> Iterable[Message]:
    """An error if no load is significant, or its mass is undetermined."""
    if estimate.covariance is None:
        return []
    std = float(estimate.covariance[0, 0]) ** 0.5
    if estimate.mass > LEAST_LOAD * std:
        return mass_undetermined(estimate)
    what = f"the torques show no load ({estimate.mass:.3g} ± {std:.2g} kg): {cause_of_no_load(fit)}"
    return [error("no-load-seen", what)]


def of_torques(message: str, fit: TorqueFit) -> str:
    """A method's message on a wrench, reworded for torques."""
    if not isinstance(message, Message):
        return message
    text = message.replace("the wrench", "the torques")
    if message.code == "no-positive-mass":
        text = "no positive mass explains the torques: check their signs and `gravity`"
    if message.code == "mass-contradicts-wrench":
        text = (
            f"the scale contradicts the torques, which show {fit.common[-PAYLOAD]:.4g} "
            "kg, and is left out: is its unit right, was the same weighed that the empty "
            "run lacks, and are the torques' constants (`torque_gains`) right?"
        )
    return Message(message.code, text, message.severity, message.argument)


def cause_of_no_load(fit: TorqueFit) -> str:
    """Why no load is significant, by the mass of least squares."""
    if len(fit.common) == PAYLOAD:
        return "the URDF's inertias tell too little: record an empty run (`empty`)"
    mass, std = float(fit.common[-PAYLOAD]), float(fit.covariance[0, 0]) ** 0.5
    if not std < TYPICAL_PAYLOAD[0]:
        return "they hardly determine it: move faster, and shoulder and elbow too"
    if mass < -NEGATIVE * std:
        return (
            f"least squares finds {mass:.3g} ± {std:.2g} kg: are empty and loaded runs "
            "exchanged, or is the sign not that of the motors' torques?"
        )
    return (
        "does the controller compensate the payload already, or do shoulder and elbow "
        "move too little or too slowly to tell one?"
    )
