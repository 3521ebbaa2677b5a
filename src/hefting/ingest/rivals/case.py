"""Case: what rival explanations of a recording are judged by."""

from dataclasses import field, replace
from functools import cached_property

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.core.spatial import Array, Mask, median
from hefting.ingest.blocks import Blocks
from hefting.ingest.channels import rounding_error
from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING, HatFunctions
from hefting.ingest.path import MOTION_COLUMNS, WORLD_AXES_COLUMNS, Path
from hefting.motion.weighting import excess_variance, samples_per_error

MOST_BLOCKS = 250
"""Largest number of averages of the wrench that explanations are compared on."""
LONGEST_AVERAGE = 0.04
"""[s] Longest time over which samples are averaged for it; of longer recordings every so
many averages are chosen."""
SMALLEST_SENSOR_ERROR = 0.003
"""Share of the wrench's changes below which what is left counts as the sensor's error
and not as something to be explained."""
AVERAGES_VARIANCE = (13.0 / 12.0) ** 2 + 2.0 / 24.0**2
"""Variance of a mean from which its neighbours' second difference is taken (`_averages`),
over that of the mean."""
LOST = 3.0 / 640.0
"""What `_averages` leave of a mean's error, over the fourth difference of the means."""
MOST_LOST = 0.1
"""The same over noise and sensor's errors up to which averages may lose it; white noise
makes 0.04. Of what a hand's tremor of 3 to 9 Hz does 40 ms lose up to a tenth, which a
loose mass, a lever arm or a payload explained."""
COLOUR_STEP, COLOUR_AVERAGES = 0.12, 1500
"""[s] Step of fourth differences, which have 3 % of a motion of 1 Hz; averages that are
looked at."""
CLEAR_COLOUR = 1.15
"""Ratio to the floor from which on noise is coloured: of white noise it is found to 6 %."""
COARSE_OFFSETS = 0.02 * np.arange(-5.0, 6.0)
"""[s] Clock offsets that are tried with every explanation, besides those near the one
that conditioning found."""
FINE_OFFSETS = 0.005 * np.array((-2.0, -1.0, 0.0, 1.0, 2.0))
"""[s] Clock offsets about the best of the coarse ones."""
ANOTHER_POSE = 0.1
"""Change of gravity in sensor axes, as a share of it, between one rest and another: six
degrees. Within a rest it is a thousand times less."""


@immutable
class Motion:
    """Motion at K times for each of O clock offsets, in logged sensor axes."""

    a: Array
    """(O, K, 3) linear acceleration, or specific force where that was measured"""
    rest: Array
    """(O, K, 9) angular acceleration and vech(w w')"""
    axes: Array
    """(O, K, 3, 3) rotation from world to sensor axes"""
    known: Mask
    """(O, K)"""

    def features(self, gravity: Array) -> Array:
        """(O, K, 12) of `hefting.core.regressor`, for gravity (3,) in world axes."""
        return np.concatenate((self.a - self.axes @ gravity, self.rest), axis=2)


@immutable
class Case:
    """Averages of the wrench as recorded, and the motion as logged."""

    recording: Recording
    path: Path
    gravity: Array
    """(3,) in world axes [m/s²], as assumed"""
    time: Array
    """(K,) [s]"""
    wrench: Array
    """(K, 6) as recorded [N, N m]"""
    noise: Array
    """(2,) standard deviation of the averages' force [N] and torque [N m] by white
    noise"""
    offset: float
    """[s] clock offset that conditioning found"""
    biased: bool
    """whether a bias is possible: False where one was given, or excluded"""
    consecutive: tuple[Array, Array]
    """times (B,) [s] and wrenches (B, 6) of the first averages, none left out"""
    worth: Array
    """(K,) what each average counts beside errors of the motion as logged, as of
    `hefting.motion.weighting.sample_weights`; the same for all explanations"""
    few_offsets: tuple[float, ...] = ()
    """[s] clock offsets to try with every explanation; none for the usual ones"""
    most_left: float = np.inf
    """log-likelihood of a sample, missing to that of noise alone, above which a mistake
    that is not fitted to the end explains too little"""
    more_knots: int = 0
    """of the bias, beside those that recordings of the same length have"""
    _late: dict[tuple[float, ...], Motion] = field(default_factory=dict, init=False)
    """Motion by the clock offsets it was read at: many explanations read it at the
    same ones."""

    @classmethod
    def of(
        cls,
        recording: Recording,
        path: Path,
        gravity: Array,
        offset: float,
        *,
        biased: bool,
        parameters: Array | None = None,
    ) -> "Case":
        """Of a recording and its motion; see the fields.

        Errors of the motion count by what they do to the wrench of an object of these
        `parameters` (10,); by default there are none.
        """
        wrench = recording["wrench"]
        blocks = Blocks.of(wrench.time, wrench.values, smooth=path.kind != "static")
        # static poses follow no order
        noise = _high_frequency_noise(blocks.wrench) if path.moves else np.zeros(2)
        time, values = np.array(blocks.time), np.array(blocks.wrench)
        rounding = rounding_error(wrench.values)
        if path.moves:
            time, values, noise = _averaged(time, values, noise, rounding)
        # neither noise of averages nor differences of samples that rest on one step
        noise = np.hypot(noise, rounding)
        step = -(-len(time) // MOST_BLOCKS)
        case = cls(
            recording,
            path,
            np.array(gravity, dtype=float),
            time[::step],
            values[::step],
            noise,
            offset,
            biased,
            (time[:COLOUR_AVERAGES], values[:COLOUR_AVERAGES]),
            np.ones(len(time[::step])),
        )
        if parameters is None:
            return case
        reading = path.at(case.time - offset)
        excess = excess_variance(parameters, reading.variances, *case.floor)
        lasting = samples_per_error(case.time, path.bandwidth)
        worth, known = 1.0 / (1.0 + lasting * excess), reading.known
        if not worth[known].any():
            return case
        # where the motion is unknown a sample counts as the others do on average
        usual = float(worth[known].mean())
        return replace(case, worth=np.where(known, worth, usual))

    def every(self, nth: int) -> "Case":
        """Of every n-th average alone."""
        parts = {
            name: getattr(self, name)[::nth] for name in ("time", "wrench", "worth")
        }
        other = replace(self, **parts)
        vars(other)["coloured"] = self.coloured  # the same of all
        return other

    def with_drift(self, knots: int) -> "Case":
        """With a bias that drifts more freely, by so many knots."""
        other = replace(self, more_knots=knots)
        return self._of_same_motion(other)

    def with_gravity(self, gravity: Array) -> "Case":
        """With gravity (3,) elsewhere, which no motion that was read depends on."""
        return self._of_same_motion(replace(self, gravity=gravity))

    def with_wrench(self, matrix: Array) -> "Case":
        """With the wrench multiplied by a matrix (6, 6), which mixes no force with torque
        but may exchange them."""
        time, wrench = self.consecutive
        size = np.abs(matrix).reshape(2, 3, 2, 3).max(axis=(1, 3))
        other = replace(
            self,
            wrench=self.wrench @ matrix.T,
            noise=size @ self.noise,
            consecutive=(time, wrench @ matrix.T),
        )
        return self._of_same_motion(other)

    def with_accelerations(self, linear: float, angular: float) -> "Case":
        """With the linear accelerations multiplied by one factor, and the angular ones
        and the squares of angular velocities by another."""
        other = replace(self, path=self.path.scaled(linear, angular))
        for at, motion in self._late.items():
            a, rest = linear * motion.a, angular * motion.rest
            other._late[at] = replace(motion, a=a, rest=rest)
        return other

    def _of_same_motion(self, other: "Case") -> "Case":
        other._late.update(self._late)
        return other

    @property
    def poses(self) -> int:
        """How many poses tell something: all, or where only rests count, these."""
        rests = self.worth > 0.0
        if not self.path.moves or rests.all():
            return len(self.time)
        down = (self.motion_as_found.axes[0] @ self.gravity)[rests]
        turned = np.linalg.norm(np.diff(down, axis=0), axis=1)
        return 1 + int(np.sum(turned > ANOTHER_POSE * np.linalg.norm(self.gravity)))

    @property
    def relative_worth(self) -> Array:
        """(K,) what each average counts over the usual one."""
        return self.worth / self.worth.mean()

    @property
    def modelled_gravity(self) -> Array:
        """(3,) in world axes [m/s²]; zero where the specific force was measured."""
        return np.zeros(3) if self.path.gravity_measured else self.gravity

    def features(self, motion: Motion) -> Array:
        """(O, K, 12) of `hefting.core.regressor`, with gravity as modelled."""
        return motion.features(self.modelled_gravity)

    @cached_property
    def floor(self) -> Array:
        """(2,) smallest size of a residual of force [N] and torque [N m] that is to be
        explained."""
        changes = np.sqrt(np.var(self.wrench, axis=0).reshape(2, 3).mean(axis=1))
        size = np.sqrt(np.mean(self.wrench**2, axis=0).reshape(2, 3).mean(axis=1))
        error = SMALLEST_SENSOR_ERROR * changes
        return np.maximum(np.hypot(self.noise, error), 1e-9 * np.maximum(size, 1e-9))

    @property
    def level(self) -> Array:
        """(2,) size of a residual that noise explains: the floor, or more of coloured
        noise."""
        coloured = self.coloured
        return np.where(coloured > CLEAR_COLOUR * self.floor, coloured, self.floor)

    @cached_property
    def coloured(self) -> Array:
        """(2,) size of coloured noise, by the fourth differences of the wrench that no
        linear function of the motion has; zero where too few are known."""
        time, wrench = self.consecutive
        if not self.path.moves:
            return np.zeros(2)
        step = max(round(COLOUR_STEP / max(median(np.diff(time)), 1e-9)), 1)
        motion = self.motion_at(time[None] - self.offset)
        known = np.where(motion.known[0, :, None], self.features(motion)[0], np.nan)
        both = np.concatenate((known, wrench), axis=1)
        for _ in range(4):
            both = both[step:] - both[:-step]
        both = both[np.isfinite(both).all(axis=1)]
        if len(both) < 40:
            return np.zeros(2)
        known, wrench = both[:, :-6], both[:, -6:]
        left = wrench - known @ np.linalg.lstsq(known, wrench, rcond=1e-9)[0]
        return _size(left) / 70.0**0.5

    @cached_property
    def offsets(self) -> Array:
        """(O,) [s] clock offsets to try."""
        if not self.path.moves:
            return np.zeros(1)
        if self.few_offsets:
            return np.array(self.few_offsets)
        near = self.offset + 0.02 * np.array((-1.0, 0.0, 1.0))
        return np.unique(np.concatenate((COARSE_OFFSETS, near)).round(6))

    @property
    def likely_offsets(self) -> Array:
        """(1,) or (2,) [s] none, and the clock offset that conditioning found."""
        return np.unique((0.0, self.offset))

    @property
    def motion(self) -> Motion:
        """At the offsets to try."""
        return self.motion_late(self.offsets)

    @cached_property
    def motion_as_found(self) -> Motion:
        """At the clock offset that conditioning found."""
        return self.motion_late(self.offset)

    def motion_late(self, offsets: float | Array) -> Motion:
        """For wrenches that are late by clock offsets (O,), or by one [s]."""
        each = np.atleast_1d(offsets)
        at = tuple(each.tolist())
        if at not in self._late:
            self._late[at] = self.motion_at(self.time - each[:, None])
        return self._late[at]

    def motion_at(self, times: Array) -> Motion:
        """At times (O, K) [s]."""
        reading = self.path.at(times.ravel(), spread=False)
        O, K = times.shape
        rows = reading.value.reshape(O, K, -1)
        motion = rows[:, :, MOTION_COLUMNS]
        axes = rows[:, :, WORLD_AXES_COLUMNS].reshape(O, K, 3, 3)
        return Motion(
            motion[:, :, :3], motion[:, :, 3:], axes, reading.known.reshape(O, K)
        )

    def places(self, times: Array) -> Array:
        """(..., 3) [m] of the sensor as logged, at times (...) [s]."""
        position = self.recording["position"]
        each = [np.interp(times, position.time, x) for x in position.values.T]
        return np.stack(each, axis=-1)

    @cached_property
    def bias_functions(self) -> Array:
        """(K, n) functions of time of which a bias is composed; n = 0 where none is
        possible."""
        if not self.biased:
            return np.zeros((len(self.time), 0))
        long = self.path.moves and np.ptp(self.time) >= SHORTEST_DRIFTING_RECORDING
        knots = (2 if long else 1) + self.more_knots
        return HatFunctions.over(self.time, knots).values


def _averaged(
    time: Array, wrench: Array, noise: Array, rounding: Array
) -> tuple[Array, Array, Array]:
    """Averages of blocks at `time` (B,) with wrenches (B, 6) and noise (2,), as long as
    they lose little of the wrench beside that and `rounding` (2,)."""
    together = _averaged_together(time)
    changes = np.sqrt(np.var(wrench, axis=0).reshape(2, 3).mean(axis=1))
    while together > 1:
        times, means = _averages(time, wrench, together)
        less = noise * (AVERAGES_VARIANCE / together) ** 0.5
        lost = LOST * _size(np.diff(means, 4, axis=0)) if len(means) > 4 else noise
        error = np.hypot(np.hypot(less, rounding), SMALLEST_SENSOR_ERROR * changes)
        if (lost < MOST_LOST * error).all():
            return times, means, less
        together //= 2
    return time, wrench, noise


def _averaged_together(time: Array) -> int:
    """How many of the blocks at `time` (B,) are averaged for `MOST_BLOCKS` of them."""
    if len(time) <= MOST_BLOCKS:
        return 1
    interval = median(np.diff(time))
    longest = int(LONGEST_AVERAGE / max(interval, 1e-9) + 1e-6)
    return max(min(-(-len(time) // MOST_BLOCKS), longest), 1)


def _averages(time: Array, wrench: Array, together: int) -> tuple[Array, Array]:
    """Times (K,) and wrenches (K, 6) of so many blocks each, those at the end that are
    fewer left out.

    The mean of x(t) over a time T is x + T² x'' / 24 in its middle: that is taken away
    by the second difference of the means, where their times are even.
    """
    K = len(time) // together
    time = time[: K * together].reshape(K, together).mean(axis=1)
    mean = wrench[: K * together].reshape(K, together, 6).mean(axis=1)
    steps = np.diff(time)
    even = np.abs(np.diff(steps)) < 0.2 * np.median(steps)
    even &= np.abs(steps[1:] - np.median(steps)) < 0.2 * np.median(steps)
    bend = mean[:-2] - 2.0 * mean[1:-1] + mean[2:]
    found = mean.copy()
    found[1:-1] -= even[:, None] * bend / 24.0
    return time, found


def _high_frequency_noise(wrench: Array) -> Array:
    """(2,) standard deviation of the noise of force and torque, by the second
    differences of the wrench (B, 6), which a slow motion does not show in."""
    if len(wrench) < 4:
        return np.zeros(2)
    return _size(np.diff(wrench, 2, axis=0)) / 6.0**0.5


def _size(values: Array) -> Array:
    """(2,) robust standard deviations of force and torque, of values (B, 6)."""
    # the median of |x| is 0.6745 standard deviations
    size = np.median(np.abs(values), axis=0) / 0.6745
    return np.sqrt(np.mean(np.square(size).reshape(2, 3), axis=1))
