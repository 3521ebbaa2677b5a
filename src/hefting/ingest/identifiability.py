"""Identifiability: which parameters a motion determines, and why not the others.

Ranks and condition numbers depend on the motion alone. Which parameters are open
depends on the noise and on a free bias too, and so follows from unconstrained least
squares (`hefting.ingest.free_fit.FreeFit`). The reasons are found in the motion:
gravity's directions in sensor axes, and the axes of angular accelerations.
"""

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import json_ready
from hefting.core.measurements import Measurements
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, Moments
from hefting.core.spatial import (
    PARAMETERS,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Array,
    immutable,
)
from hefting.estimators.joint_state import State, as_one
from hefting.estimators.quadratic import RANK_TOLERANCE, stacked_factor
from hefting.estimators.sample_state import SampleState
from hefting.ingest.condensed import Excitation
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.tool import left_open

RigidModel = Literal["full", "reduced"]
_EQUATIONS = {"full": FULL_EQUATIONS[6:16], "reduced": REDUCED_EQUATIONS[6:10]}
AXES = "xyz"
STILL = 0.01
"""[rad] Root-mean-square turn of gravity in sensor axes below which its direction
counts as constant."""
NARROW = 0.2
"""[rad] Root-mean-square turn of gravity below which it counts as small."""
IDLE, IDLE_SHARE = 0.005, 0.02
"""Root-mean-square angular acceleration about an axis below which it counts as zero:
[rad/s²], and relative to the axis of the largest one."""


def rank(state: State | Moments, model: RigidModel = "full") -> int:
    """Rank of the stacked regressors of all samples: at most 10, and 4 of the reduced
    (gravity-only) model.

    Singular values below `RANK_TOLERANCE` times the largest count as zero, with columns in
    SI units: those of a body of 1 kg and 1 m. Another frame of the sensor does not
    change it. Noise in the motion can hide a deficiency; `condition_number` then shows
    it. Raises `InputError` for another model.
    """
    singular = np.linalg.svd(_columns(_moments(state), model), compute_uv=False)
    return (
        int(np.sum(singular > RANK_TOLERANCE * singular[0])) if singular[0] > 0.0 else 0
    )


def condition_number(
    moments: Moments, size: float, model: RigidModel = "full"
) -> float:
    """Condition number of the stacked regressors in the units of the body; infinite
    where they are rank-deficient.

    Columns are multiplied by a-priori magnitudes of their parameters (Gautier & Khalil,
    IJRR 11(4), 1992), here those of 1 kg with a radius of gyration of `size` [m]: 1,
    size, size²; torques are counted in force times `size`. So the figure is the same in
    any unit of length, and falls as the rotation comes to weigh as much as gravity: for
    slow motion it is about |g| / (size · angular acceleration).

    This is the reading of "scaled" that comes nearest to Nadeau et al. 2022.

    Raises `InputError` for another model or a size that is not positive.
    """
    if not 0.0 < size < np.inf:
        raise InputError(f"the size of a body must be positive and finite, not {size}")
    if rank(moments, model) < len(_EQUATIONS[model]):
        return np.inf
    return float(np.linalg.cond(_columns(moments, model, size)))


def _moments(state: State | Moments) -> Moments:
    if isinstance(state, Moments):
        return state
    whole = as_one(state)
    return whole.reduced.merge(whole.full, one_bias=True)


def _columns(moments: Moments, model: str, size: float = 1.0) -> Array:
    """Triangular factor of the regressors, in units of 1 kg and `size` [m]."""
    if model not in _EQUATIONS:
        raise InputError(f"unknown model '{model}'", fix=f"use {', '.join(_EQUATIONS)}")
    equations = _EQUATIONS[model] / np.repeat((1.0, size), 3)[:, None]
    return (
        moments.factor_of(equations)
        * np.repeat((1.0, size, size**2), (1, 3, 6))[: len(equations)]
    )


@immutable
class Identifiability:
    """Ranks and condition numbers of a motion, and what a recording leaves open."""

    rank_full: int
    """of 10"""
    rank_reduced: int
    """of 4: mass and centre of mass by gravity alone"""
    condition_full: float
    """see `condition_number`; infinite when rank-deficient"""
    condition_reduced: float
    """the same of the reduced model"""
    open: dict[str, str]
    """open parameters (`hefting.core.spatial.PARAMETERS`), each with a sentence why"""
    summary: tuple[str, ...]
    """the same sentences, with parameters of one reason joined"""

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values; null for an infinite condition number."""
        own = self.__dataclass_fields__
        return json_ready({n: getattr(self, n) for n in own if n != "summary"})


def identifiability(
    motion: Measurements | Excitation,
    fit: FreeFit,
    size: float,
    tool: Estimate | None = None,
) -> Identifiability:
    """Identifiability of a body of about `size` [m] from measurements or their sums,
    given their unconstrained `fit` and a `tool`. Open are `fit.open_parameters(size)`;
    with a bias if the fit has one."""
    if isinstance(motion, Measurements):
        motion = Excitation.of(motion)
    moments = motion.moments
    found = _Reasons(motion, fit, size, tool).found()
    return Identifiability(
        rank_full=rank(moments, "full"),
        rank_reduced=rank(moments, "reduced"),
        condition_full=condition_number(moments, size, "full"),
        condition_reduced=condition_number(moments, size, "reduced"),
        open={name: _sentence([finding]) for name, finding in found.items()},
        summary=_join_findings(found.values()),
    )


@immutable
class _Finding:
    """An undetermined parameter, and why: a reason, or noise."""

    subject: str
    reason: str = ""
    excess: float = 0.0
    """Ratio of the standard deviation to its limit, if noise is the reason."""
    yardstick: str = ""
    """The limit in words."""
    remedy: str = ""
    """Advice, with {} in place of the axes."""
    axes: str = ""
    """Axes about which motion would help."""


def _sentence(group: list[_Finding]) -> str:
    first, one = group[0], len(group) == 1
    subjects = ", ".join(dict.fromkeys(finding.subject for finding in group))
    if first.reason:
        return f"{subjects} not observable: {first.reason}"
    excess = max(finding.excess for finding in group)
    names = sorted(set("".join(finding.axes for finding in group)))
    axes = (" or " if one else " and ").join(
        (*[", ".join(names[:-1])] * (len(names) > 1), *names[-1:])
    )
    return (
        f"{subjects} {'is' if one else 'are'} lost in the noise: {'its' if one else 'the largest'} standard deviation "
        f"is {excess:.2g} times {first.yardstick}; {first.remedy.format(axes)}"
    )


def _join_findings(findings: Iterable[_Finding]) -> tuple[str, ...]:
    groups: dict[tuple[str, str], list[_Finding]] = {}
    for finding in findings:
        groups.setdefault((finding.reason, finding.yardstick), []).append(finding)
    return tuple(_sentence(group) for group in groups.values())


class _Reasons:
    """Facts of a motion, and reasons that follow from them."""

    def __init__(
        self, motion: Excitation, fit: FreeFit, size: float, tool: Estimate | None
    ):
        self._motion, self._fit, self._size = motion, fit, size
        self._open_of_tool = left_open(tool)
        self._biased = fit.bias is not None
        self._std = np.sqrt(fit.covariance.diagonal()[:10])
        self._gravity = motion.directions_about(mean=self._biased)
        self._turn = _length(motion.directions_about(mean=True))

    def found(self) -> dict[str, _Finding]:
        names = self._fit.open_parameters(self._size)
        if not names:
            return {}
        com, idle = self._open_com_directions(), self._idle_directions()
        found = {"m": self._mass()} if "m" in names else {}
        found |= {
            name: self._com(axis, com)
            for axis, name in enumerate(PARAMETERS[1:4])
            if name in names
        }
        return found | {
            name: self._inertia(entry, idle)
            for entry, name in enumerate(PARAMETERS[4:])
            if name in names
        }

    # mass and centre of mass: where gravity pointed

    def _mass(self) -> _Finding:
        reason = (
            self._gravity_reason() if self._biased else None
        ) or self._reason_besides_noise(0)
        if reason is not None:
            return _Finding("mass", reason)
        mass = abs(self._fit.mass)
        excess = 3.0 * float(self._std[0]) / max(mass, 1e-300)
        limit = f"a third of the {mass:.2g} kg found"
        return _Finding("mass", "", excess, limit, "is anything held?")

    def _com(self, axis: int, open_directions: Array) -> _Finding:
        # the part of the axis that is open
        direction = open_directions.T @ open_directions[:, axis]
        length = float(np.linalg.norm(direction))
        direction = _align_to_axis(
            direction / length if length > 1e-3 else open_directions[-1]
        )
        name = _format_direction(direction)
        subject = f"COM {name}" if len(name) == 1 else f"COM along {name}"
        reason = self._gravity_reason(direction) or self._reason_besides_noise(1 + axis)
        if reason is not None:
            return _Finding(subject, reason)
        limit = abs(self._fit.mass) * self._size / 2.0
        remedy = f"turn sensor {{}} further {'over' if self._biased else 'from the vertical'}, or record longer"
        excess = float(self._std[1 + axis]) / limit
        return _Finding(
            f"COM {AXES[axis]}",
            "",
            excess,
            f"half of {self._size:g} m",
            remedy,
            AXES[axis],
        )

    def _gravity_reason(self, direction: Array | None = None) -> str | None:
        """Why gravity does not determine the mass, or the COM along `direction` (3,);
        None if it does."""
        if not self._motion.has_gravity:
            return (
                "without gravity only acceleration shows it, and there was too little"
            )
        if not self._biased:
            assert direction is not None
            tilt = self._rms_perpendicular(direction)
            name = _format_direction(direction)
            what = f"sensor {name}" if len(name) == 1 else "this direction"
            if tilt < STILL:
                return f"{what} never left the vertical"
            if tilt < NARROW:
                return f"{what} stayed within about {_degrees(tilt)} of the vertical"
            return None
        if self._turn < STILL:
            return "gravity kept its direction in sensor axes, so a bias cannot be told from weight"
        if (
            direction is not None
            and self._rms_perpendicular(direction) < 0.3 * self._turn
        ):
            name = _format_direction(direction)
            return f"gravity in sensor axes changed along {name} only, and a constant torque may be bias"
        if self._turn < NARROW:
            turn = _degrees(self._turn)
            return f"gravity turned by only about {turn} in sensor axes, so a bias can hardly be told from weight"
        return None

    def _open_com_directions(self) -> Array:
        """(k, 3) orthonormal directions in which m c is undetermined if all other
        parameters are free; at least the least determined one."""
        moments = self._motion.moments
        state = SampleState(Moments.empty(), moments, moments.samples)
        R = stacked_factor(state, self._fit.noise, self._biased)
        A = R[6:, 6:16] if self._biased else R[:, :10]
        others = np.delete(A, (1, 2, 3), axis=1)
        U, S, _ = np.linalg.svd(others, full_matrices=False)
        U = U[:, RANK_TOLERANCE * S[0] < S]
        seen = A[:, 1:4] - U @ (U.T @ A[:, 1:4])
        _, S, V = np.linalg.svd(seen, full_matrices=False)
        limit = abs(self._fit.mass) * self._size / 2.0
        known = (RANK_TOLERANCE * float(np.linalg.norm(A, 2)) < S) & (
            limit * S >= np.sqrt(self._fit.autocorrelation)
        )
        return V[~known] if not known.all() else V[-1:]

    # inertia: about which axes the sensor was accelerated

    def _inertia(self, entry: int, idle: Array) -> _Finding:
        name, axes = PARAMETERS[4 + entry], (TENSOR_ROWS[entry], TENSOR_COLUMNS[entry])
        if len(idle) and all(np.linalg.norm(idle[:, axis]) > 0.05 for axis in axes):
            return _Finding(name, self._idle_reason(idle))
        reason = self._reason_besides_noise(4 + entry)
        if reason is not None:
            return _Finding(name, reason)
        limit = abs(self._fit.mass) * self._size**2 / 12.0
        yardstick = f"what a body of {self._size:g} m would have"
        remedy = "turn faster or longer about {}"
        return _Finding(
            name, "", float(self._std[4 + entry]) / limit, yardstick, remedy, name[1:]
        )

    def _idle_directions(self) -> Array:
        """(k, 3) orthonormal directions about which there was no angular acceleration,
        k = 0 to 3.

        It counts as zero if it is too small to determine the inertia of a body of the
        given size in the noise of the torque, and also below its own noise,
        `IDLE_SHARE` of the largest, or `IDLE`. The limit `IDLE` does not apply if the
        noise hides the motion about every axis.
        """
        _, S, V = np.linalg.svd(self._motion.angular_acceleration, full_matrices=False)
        mass = self._motion.force / max(self._motion.gravity, 1e-300)
        if not self._fit.mass_is_open:
            mass = abs(self._fit.mass)
        per_sample = self._fit.autocorrelation / max(self._motion.samples, 1)
        noise = self._fit.noise.torque * np.sqrt(per_sample)
        needed = noise / max(mass * self._size**2 / 12.0, 1e-300)
        known = self._motion.angular_noise
        most = float(S[0])
        idle = 0.0 if IDLE < most < needed else IDLE
        return V[min(needed, max(idle, IDLE_SHARE * most, 1.2 * known)) > S]

    def _idle_reason(self, idle: Array) -> str:
        if not self._motion.angular_acceleration.any():
            return "no angular acceleration in poses taken as static"
        if len(idle) == 3:
            return "no angular acceleration about any axis"
        if len(idle) == 1:
            return f"no angular acceleration about {_format_direction(_align_to_axis(idle[0]))}"
        name = _format_direction(_align_to_axis(np.cross(*idle)))
        if len(name) == 1:
            return f"no angular acceleration about {' or '.join(axis for axis in AXES if axis != name)}"
        return f"angular acceleration about {name} only"

    def _reason_besides_noise(self, index: int) -> str | None:
        """Why a parameter that the motion excites is undetermined; None for noise."""
        if index and self._fit.mass_is_open:
            return "the mass itself is not known"
        if np.isfinite(self._std[index]):
            return None
        if self._open_of_tool[index]:
            what = "inertia" if index > 3 else "COM"
            return f"the tool's {what} is open: record the gripper empty in motion"
        others = "other parameters or a bias" if self._biased else "other parameters"
        count = self._motion.samples
        samples = f"{count} sample{'s' * (count != 1)}"
        return f"in {'this motion' if count > 3 else samples} {others} explain the wrench as well"

    def _rms_perpendicular(self, direction: Array) -> float:
        """Root-mean-square component of gravity's directions perpendicular to
        `direction`; with a bias, of their deviations from the mean."""
        along = np.outer(self._gravity @ direction, direction)
        return _length(self._gravity - along)


def _length(rows: Array) -> float:
    return float(np.sqrt(np.sum(rows**2)))


def _align_to_axis(direction: Array) -> Array:
    """The sensor axis within 6° of a unit vector (3,), else the vector with its largest
    component positive."""
    largest = int(np.argmax(np.abs(direction)))
    if abs(direction[largest]) > 0.995:
        return np.eye(3)[largest]
    return direction * np.sign(direction[largest])


def _format_direction(direction: Array) -> str:
    """Text of a direction (3,): "z" for an axis, else as "(0.71, 0, 0.71)"."""
    if np.count_nonzero(direction) == 1:
        return AXES[int(np.argmax(direction))]
    return "(" + ", ".join(f"{round(float(x), 2) + 0.0:g}" for x in direction) + ")"


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.2g}°"
