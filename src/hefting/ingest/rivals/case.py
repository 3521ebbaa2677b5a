"""Case: averages of a recording's wrench and its motion, on which explanations are
compared."""

from dataclasses import field, replace
from functools import cached_property

import numpy as np

from hefting.core.recording import Recording
from hefting.core.sensor_accuracy import TYPICAL_SHARE
from hefting.core.spatial import (
    Array,
    Mask,
    column_medians,
    distinct,
    immutable,
    median,
)
from hefting.ingest.blocks import Blocks
from hefting.ingest.channels import rounding_error
from hefting.ingest.drift import SHORTEST_DRIFTING_RECORDING, HatFunctions
from hefting.ingest.path import MOTION_COLUMNS, WORLD_AXES_COLUMNS, Path
from hefting.motion.state import (
    acceleration_variances,
    excess_variance,
    samples_per_error,
)

MOST_BLOCKS = 250
"""Largest number of averages of the wrench on which explanations are compared."""
LONGEST_AVERAGE = 0.04
"""[s] Longest time over which samples are averaged; of longer recordings evenly chosen
averages are used."""
SMALLEST_SENSOR_ERROR = 0.003
"""Share of the wrench's changes up to which residuals count as the sensor's error."""
AVERAGES_VARIANCE = (13.0 / 12.0) ** 2 + 2.0 / 24.0**2
"""Variance of a mean corrected by its neighbours' second difference (`_averages`), over
that of the mean."""
LOST = 3.0 / 640.0
"""Error that is left in `_averages`, over the fourth difference of the means."""
MOST_LOST = 0.1
"""Largest such error over noise and sensor's errors; white noise makes 0.04. Averages
of 40 ms lose up to a tenth of a hand's tremor of 3 to 9 Hz, which a loose mass, a lever
arm or a payload explained."""
COLOUR_STEP, COLOUR_AVERAGES = 0.12, 1500
"""[s] Step of the fourth differences, which contain 3 % of a motion of 1 Hz; number of
averages used."""
FEWEST_DIFFERENCES = 40
"""Least number of fourth differences to which the twelve features are fitted."""
OF_DIFFERENCES = 70.0**0.5
"""Deviation of fourth differences over that of the values: 1 + 16 + 36 + 16 + 1."""
CLEAR_COLOUR = 1.15
"""Ratio to the floor above which noise is coloured; of white noise it is found to 6 %."""
COARSE_OFFSETS = 0.02 * np.arange(-5.0, 6.0)
"""[s] Clock offsets that are tried with every explanation, beside those near the one
that conditioning found."""
FINE_OFFSETS = 0.005 * np.array((-2.0, -1.0, 0.0, 1.0, 2.0))
"""[s] Clock offsets about the best of the coarse ones."""
ANOTHER_POSE = 0.1
"""Change of gravity in sensor axes, relative to its size, between two rests: six
degrees. Within a rest it is a thousand times less."""


@immutable
class Motion:
    """Motion at K times for each of O clock offsets, in logged sensor axes."""

    a: Array
    """(O, K, 3) linear acceleration, or measured specific force"""
    rest: Array
    """(O, K, 9) angular acceleration and vech(w w')"""
    axes: Array
    """(O, K, 3, 3) rotation from world to sensor axes"""
    known: Mask
    """(O, K)"""

    def features(self, gravity: Array) -> Array:
        """(O, K, 12) motion features of `hefting.core.regressor`, for gravity (3,) in
        world axes."""
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
    """(2,) standard deviation of the averages' force [N] and torque [N m] for white
    noise"""
    offset: float
    """[s] clock offset that conditioning found"""
    biased: bool
    """whether a bias is possible: False if it was given or excluded"""
    consecutive: tuple[Array, Array]
    """times (B,) [s] and wrenches (B, 6) of the first averages, without gaps"""
    worth: Array
    """(K,) weight of each average by all errors of the logged motion, as in
    `hefting.motion.state`; the same for all explanations"""
    sensor_errors: float = TYPICAL_SHARE
    """of the sensor that are no mistake, as a share of its ranges"""
    few_offsets: tuple[float, ...] = ()
    """[s] clock offsets to try with every explanation; empty for the usual ones"""
    most_left: float = np.inf
    """missing log-likelihood per sample above which the rough fit of a mistake is given
    up"""
    more_knots: int = 0
    """of the bias, beyond the usual number for the recording's length"""
    parameters: Array | None = None
    """(10,) of the object that conditioning found, if any"""
    _late: dict[tuple[float, ...], Motion] = field(default_factory=dict, init=False)
    """Motion by clock offsets, as many explanations use the same ones."""

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
        # static poses have no order
        noise = _high_frequency_noise(blocks.wrench) if path.moves else np.zeros(2)
        time, values = np.array(blocks.time), np.array(blocks.wrench)
        rounding = rounding_error(wrench.values)
        if path.moves:
            time, values, noise = _averaged(time, values, noise, rounding)
        # values that rest on one step show no rounding
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
            parameters=parameters,
        )
        if parameters is None:
            return case
        reading = path.at(case.time - offset)
        variances = reading.variances
        if path.curves is not None:  # with those at jumps, which a mistake may explain
            smoothed = path.curves.alone.at(reading.time)
            variances = np.maximum(variances, acceleration_variances(smoothed))
        excess = excess_variance(parameters, variances, *case.floor)
        lasting = samples_per_error(case.time, path.bandwidth)
        worth, known = 1.0 / (1.0 + lasting * excess), reading.known
        if not worth[known].any():
            return case
        # samples without known motion have the mean weight
        usual = float(worth[known].mean())
        return replace(case, worth=np.where(known, worth, usual))

    def every(self, nth: int) -> "Case":
        """With every n-th average only."""
        parts = {
            name: getattr(self, name)[::nth] for name in ("time", "wrench", "worth")
        }
        other = replace(self, **parts)
        vars(other)["coloured"] = self.coloured  # the same of all
        return other

    def with_drift(self, knots: int) -> "Case":
        """With `knots` more knots of the bias."""
        other = replace(self, more_knots=self.more_knots + knots)
        return self._of_same_motion(other)

    def with_gravity(self, gravity: Array) -> "Case":
        """With another gravity (3,), on which the motion does not depend."""
        return self._of_same_motion(replace(self, gravity=gravity))

    def with_wrench(self, matrix: Array) -> "Case":
        """With the wrench multiplied by a matrix (6, 6), which may exchange force and
        torque but not mix them."""
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
        """With linear accelerations multiplied by one factor, and angular ones and
        squares of angular velocities by another."""
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
        """Number of informative poses: all averages, or if only rests count the
        different ones among these."""
        rests = self.worth > 0.0
        if not self.path.moves or rests.all():
            return len(self.time)
        down = (self.motion_as_found.axes[0] @ self.gravity)[rests]
        turned = np.linalg.norm(np.diff(down, axis=0), axis=1)
        return 1 + int(np.sum(turned > ANOTHER_POSE * np.linalg.norm(self.gravity)))

    @property
    def relative_worth(self) -> Array:
        """(K,) weight of each average relative to the mean."""
        return self.worth / self.worth.mean()

    @property
    def modelled_gravity(self) -> Array:
        """(3,) in world axes [m/s²]; zero if the specific force was measured."""
        return np.zeros(3) if self.path.gravity_measured else self.gravity

    def features(self, motion: Motion) -> Array:
        """(O, K, 12) of `hefting.core.regressor`, with gravity as modelled."""
        return motion.features(self.modelled_gravity)

    @cached_property
    def floor(self) -> Array:
        """(2,) smallest residual of force [N] and torque [N m] that is to be
        explained."""
        changes = np.sqrt(np.var(self.wrench, axis=0).reshape(2, 3).mean(axis=1))
        size = np.sqrt(np.mean(self.wrench**2, axis=0).reshape(2, 3).mean(axis=1))
        error = SMALLEST_SENSOR_ERROR * changes
        return np.maximum(np.hypot(self.noise, error), 1e-9 * np.maximum(size, 1e-9))

    @property
    def level(self) -> Array:
        """(2,) residual that noise explains: the floor, or more for coloured noise."""
        coloured = self.coloured
        return np.where(coloured > CLEAR_COLOUR * self.floor, coloured, self.floor)

    @cached_property
    def coloured(self) -> Array:
        """(2,) size of coloured noise, which shows in fourth differences of the wrench
        that are no linear function of the motion's; zero where too few are known."""
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
        if len(both) < FEWEST_DIFFERENCES:
            return np.zeros(2)
        known, wrench = both[:, :-6], both[:, -6:]
        left = wrench - known @ np.linalg.lstsq(known, wrench, rcond=1e-9)[0]
        return _size(left) / OF_DIFFERENCES

    @cached_property
    def offsets(self) -> Array:
        """(O,) [s] clock offsets to try."""
        if not self.path.moves:
            return np.zeros(1)
        if self.few_offsets:
            return np.array(self.few_offsets)
        near = self.offset + 0.02 * np.array((-1.0, 0.0, 1.0))
        return distinct(np.concatenate((COARSE_OFFSETS, near)).round(6))

    @property
    def likely_offsets(self) -> Array:
        """(1,) or (2,) [s] zero, and the clock offset that conditioning found."""
        return distinct((0.0, self.offset))

    @property
    def motion(self) -> Motion:
        """At the offsets to try."""
        return self.motion_late(self.offsets)

    @cached_property
    def motion_as_found(self) -> Motion:
        """At the clock offset that conditioning found."""
        return self.motion_late(self.offset)

    def motion_late(self, offsets: float | Array) -> Motion:
        """For wrenches that are late by clock offsets (O,) or a single one [s]."""
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
        """(..., 3) [m] logged position at times (...) [s]."""
        position = self.recording["position"]
        each = [np.interp(times, position.time, x) for x in position.values.T]
        return np.stack(each, axis=-1)

    @cached_property
    def bias_functions(self) -> Array:
        """(K, n) functions of time that compose a bias; n = 0 if none is possible."""
        if not self.biased:
            return np.zeros((len(self.time), 0))
        long = self.path.moves and np.ptp(self.time) >= SHORTEST_DRIFTING_RECORDING
        knots = (2 if long else 1) + self.more_knots
        return HatFunctions.over(self.time, knots).values


def _averaged(
    time: Array, wrench: Array, noise: Array, rounding: Array
) -> tuple[Array, Array, Array]:
    """Averages of blocks at `time` (B,) with wrenches (B, 6) and noise (2,): over as
    long as they lose little of the wrench relative to noise and `rounding` (2,)."""
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
    """Number of blocks at `time` (B,) to average, for `MOST_BLOCKS` averages."""
    if len(time) <= MOST_BLOCKS:
        return 1
    interval = median(np.diff(time))
    longest = int(LONGEST_AVERAGE / max(interval, 1e-9) + 1e-6)
    return max(min(-(-len(time) // MOST_BLOCKS), longest), 1)


def _averages(time: Array, wrench: Array, together: int) -> tuple[Array, Array]:
    """Times (K,) and wrenches (K, 6) of `together` blocks each; a remainder at the end
    is left out.

    The mean of x(t) over a time T is x + T² x'' / 24 in its middle. Where the times are
    even the second term is removed by the second difference of the means.
    """
    K = len(time) // together
    time = time[: K * together].reshape(K, together).mean(axis=1)
    mean = wrench[: K * together].reshape(K, together, 6).mean(axis=1)
    steps = np.diff(time)
    usual = median(steps)
    even = np.abs(np.diff(steps)) < 0.2 * usual
    even &= np.abs(steps[1:] - usual) < 0.2 * usual
    bend = mean[:-2] - 2.0 * mean[1:-1] + mean[2:]
    found = mean.copy()
    found[1:-1] -= even[:, None] * bend / 24.0
    return time, found


def _high_frequency_noise(wrench: Array) -> Array:
    """(2,) standard deviation of the noise of force and torque, from second differences
    of the wrench (B, 6), in which a slow motion does not show."""
    if len(wrench) < 4:
        return np.zeros(2)
    return _size(np.diff(wrench, 2, axis=0)) / 6.0**0.5


def _size(values: Array) -> Array:
    """(2,) robust standard deviations of force and torque values (B, 6)."""
    # the median of |x| is 0.6745 standard deviations
    size = column_medians(np.abs(values)) / 0.6745
    return np.sqrt(np.mean(np.square(size).reshape(2, 3), axis=1))
