"""Steps between the poses of a stream, and which of them no moving body can make.

A position or an orientation changes by bounded accelerations. A step between successive
values that no velocity nearby explains, within the largest acceleration, the noise and
the errors of the time stamps, is a break.
"""

import numpy as np

from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    changed_rows,
    immutable,
    lengths,
    median,
    quantile,
    runs_of,
)

TIMING_ERROR = 0.005
"""[s] Error of time stamps that is tolerated. Rows of recordings at a nominal 1 kHz are
some milliseconds off."""
TIMING_ERROR_IN_INTERVALS = 1.5
"""The same in sampling intervals, where these are longer: a sample may come a whole
interval late."""
NOISE_FACTOR = 15.0
"""Tolerated difference between a step and the one that its neighbour predicts, in
standard deviations of a component's noise. The difference of two steps has 2.4 of them;
15 are exceeded once in 10⁸ times."""
NEIGHBOURING_STEPS = (-2, -1, 1, 2)
"""Places, relative to a step, of the steps whose velocity may explain it: two on each
side, as one of them may end at a faulty sample."""
NEARBY_INTERVALS = 2.5
"""Largest time between two steps, in intervals of the longer one, for one to explain
the other; not across a rest."""
NEARBY = 0.02
"""[s] The same where intervals are shorter."""
KINK_STEPS, KINK_TIME = 3, 0.02
"""Smallest number of steps, and duration [s], of the velocities before and after a
kink."""
KINK_ACCELERATION = 3.0
"""Acceleration of a kink over the limit. Angles that were interpolated across 180
degrees turn for some steps at tens of radians per second."""
STEPS_OF_VELOCITY = 4
"""Largest number of steps from which the velocity at the end of a piece is found."""
NOISE_OF_JUMP = 5.0
"""Standard deviations of a component's noise that are added to the longest first step
of a body that starts from rest, to call a step a jump. A step has 1.4 of them."""
ACCELERATION_TIME = 0.05
"""[s] Time over which velocities are taken for the usual acceleration."""
STARTS_OVER_USUAL = 3.0
"""Largest acceleration of a start from rest, over the 90 % quantile in the moving parts
of the recording."""
FEWEST_HELD_ROWS = 3
"""Smallest number of equal rows that may be a stalled stream."""
HELD_UPDATES = 2.0
"""Length of a stalled stream's run of equal rows over the usual length."""
ROWS_FOR_NOISE = 20_000
"""Largest number of rows from which the noise is found."""
ROWS_AT_A_TIME = 8192
"""Number of rows processed together, whose intermediate values stay in the processor's
cache."""
SMALLEST_STEPS = 0.01
"""Quantile of the steps that is taken for the smallest step; values that were rounded
change by no less than their last digit."""
ROUNDING_OVER_STEP = 0.5
"""Noise of rounding over the smallest step. A step of one digit along all three axes is
then no jump."""


@immutable
class Limits:
    """Bounds on the motion of what a robot holds."""

    speed: float
    """[m/s] or [rad/s]"""
    acceleration: float
    """[m/s²] or [rad/s²]"""


POSITION_LIMITS = Limits(speed=10.0, acceleration=30.0)
"""Of a sensor's origin. Robot arms accelerate by up to 15 m/s², in an emergency stop by
twice as much."""
ORIENTATION_LIMITS = Limits(speed=30.0, acceleration=200.0)
"""Of a sensor's axes. The last joints of robot arms accelerate by up to 50 rad/s²."""


@immutable
class Runs:
    """Runs of equal rows of a stream: its updates."""

    first: Indices
    """(U,) first row of each run"""
    length: Indices
    """(U,) number of its rows"""
    of_row: Indices
    """(K,) run of each row"""
    time: Array
    """(U,) [s] of the first rows"""
    end: Array
    """(U,) [s] of the last rows"""
    values: Array
    """(U, 3) or (U, 4)"""

    @property
    def long(self) -> Mask:
        """(U,) the runs of more equal rows than usual."""
        usual = median(self.length)
        return (self.length >= FEWEST_HELD_ROWS) & (self.length > HELD_UPDATES * usual)

    @property
    def any_long(self) -> bool:
        """Whether any run is long enough to be of a stalled stream."""
        return bool((self.length >= FEWEST_HELD_ROWS).any())

    @property
    def at_ends(self) -> Mask:
        """(K,) rows of the first and of the last run, where these are long."""
        long = self.length >= FEWEST_HELD_ROWS
        long[1:-1] = False
        return long[self.of_row]

    @classmethod
    def of(cls, time: Array, values: Array) -> "Runs":
        """Runs of values (K, d) at times (K,)."""
        changed = changed_rows(values)
        if changed.all():
            rows = np.arange(len(time))
            return cls(rows, np.ones_like(rows), rows, time, time, values)
        first = np.flatnonzero(changed)
        length = np.diff(np.append(first, len(time)))
        return cls(
            first,
            length,
            np.cumsum(changed) - 1,
            time[first],
            time[first + length - 1],
            values[first],
        )


@immutable
class Steps:
    """Steps between successive runs."""

    runs: Runs
    """U of them"""
    steps: Array
    """(U - 1, 3) [m] or [rad]"""
    interval: Array
    """(U - 1,) [s] from the end of a run to the next one, not shorter than the usual
    one: stamps may come in bursts"""
    usual: float
    """[s] median time from the beginning of a run to that of the next one"""
    timing_error: float
    """[s]"""
    noise: float
    """[m] or [rad] standard deviation of a component"""
    limits: Limits

    @classmethod
    def of(cls, runs: Runs, limits: Limits) -> "Steps":
        """Steps between runs."""
        usual = median(np.diff(runs.time))
        steps = displacement(runs.values[:-1], runs.values[1:])
        return cls(
            runs,
            steps,
            np.maximum(runs.time[1:] - runs.end[:-1], usual),
            usual,
            max(TIMING_ERROR, TIMING_ERROR_IN_INTERVALS * usual),
            _noise(steps),
            limits,
        )

    def broken(self) -> Mask:
        """(U - 1,) the steps that no velocity nearby explains."""
        length = lengths(self.steps)
        noise = NOISE_FACTOR * self.noise
        too_fast = (
            length > self.limits.speed * (self.interval + self.timing_error) + noise
        )
        # the acceleration alone explains most steps
        by_acceleration = 0.5 * self.limits.acceleration * self.interval**2 + noise
        suspect = np.flatnonzero(length > by_acceleration)
        explained = np.zeros(len(suspect), dtype=bool)
        for place in NEIGHBOURING_STEPS:
            explained |= self._explained_by(place, suspect, length, too_fast)
        broken = np.zeros(len(self.steps), dtype=bool)
        broken[suspect] = ~explained
        broken |= too_fast
        broken[self._kinks(broken)] = True
        return broken

    def _explained_by(
        self, place: int, suspect: Indices, length: Array, too_fast: Mask
    ) -> Mask:
        """(S,) whether the velocity of the step `place` steps later explains each of the
        suspect steps (S,), within acceleration, errors of the time stamps and noise;
        `length` and `too_fast` (U - 1,) are those of all steps."""
        n, dt = len(self.steps), self.interval[suspect]
        other = suspect + place
        exists = (other >= 0) & (other < n)
        other = np.clip(other, 0, n - 1)
        other_dt = self.interval[other]
        middle = self.runs.end[:-1] + 0.5 * self.interval
        since = np.abs(middle[other] - middle[suspect])
        longer = np.maximum(dt, other_dt)
        is_near = since <= np.maximum(NEARBY_INTERVALS * longer, NEARBY)
        expected = self.steps[other] * (dt / other_dt)[:, None]
        apart = lengths(self.steps[suspect] - expected)
        allowed = (
            self.limits.acceleration * dt * since
            + self.timing_error * (length[other] / other_dt)
            + NOISE_FACTOR * self.noise * np.maximum(1.0, dt / other_dt)
        )
        return exists & ~too_fast[other] & is_near & (apart <= allowed)

    def _kinks(self, broken: Mask) -> Indices:
        """Steps before which the velocity changes by more than any acceleration allows;
        only where no step nearby is broken (U - 1,)."""
        several = max(KINK_STEPS, int(np.ceil(KINK_TIME / self.usual)))
        count = len(self.steps) + 1 - 2 * several
        if count <= 0:
            return np.zeros(0, dtype=int)
        change, impossible = np.empty(count), np.empty(count, dtype=bool)
        for first in range(0, count, ROWS_AT_A_TIME):
            some = slice(first, min(first + ROWS_AT_A_TIME, count))
            change[some], impossible[some] = self._changes_of_velocity(some, several)
        if not impossible.any():
            return np.zeros(0, dtype=int)
        faults = np.concatenate(([0], np.cumsum(broken)))
        whole = faults[2 * several :] == faults[: -2 * several]
        return np.array(
            [
                several + first + int(np.argmax(change[first:end]))
                for first, end in runs_of(whole & impossible)
            ],
            dtype=int,
        )

    def _changes_of_velocity(self, some: slice, several: int) -> tuple[Array, Mask]:
        """(S,) changes of the mean velocity of `several` steps to that of as many after
        them, from each of some first steps, and whether none is possible (S,)."""
        end = some.stop + 2 * several
        way = np.zeros((end - some.start, 3))
        np.cumsum(self.steps[some.start : end - 1], axis=0, out=way[1:])
        time = self.runs.time[some.start : end]
        lasts = np.maximum(time[several:] - time[:-several], several * self.usual)
        velocity = (way[several:] - way[:-several]) / lasts[:, None]
        before, after = velocity[:-several], velocity[several:]
        lasts = 0.5 * (lasts[:-several] + lasts[several:])
        change = lengths(after - before)
        allowed = KINK_ACCELERATION * self.limits.acceleration * lasts + (
            NOISE_FACTOR * self.noise / lasts
        )
        if (change > allowed).any():
            slower = np.minimum(lengths(before), lengths(after))
            allowed += self.timing_error * slower / lasts
        return change, change > allowed

    def usual_acceleration(self) -> float:
        """[m/s²] or [rad/s²] Largest acceleration of a start from rest: several times
        that of the moving parts of this recording, within the limits."""
        lag = max(int(np.ceil(ACCELERATION_TIME / self.usual)), 2)
        way = np.cumsum(self.steps, axis=0)
        if len(way) < 4 * lag:
            return self.limits.acceleration
        time = self.runs.time[1:]
        velocity = (way[lag:] - way[:-lag]) / (time[lag:] - time[:-lag])[:, None]
        change = lengths(velocity[lag:] - velocity[:-lag])
        acceleration = change / (0.5 * (time[2 * lag :] - time[: -2 * lag]))
        speed = lengths(velocity[lag:])
        moving = speed * lag * self.usual > NOISE_FACTOR * self.noise + 1e-9
        if not moving.any():
            return self.limits.acceleration
        usual = STARTS_OVER_USUAL * quantile(acceleration[moving], 0.9)
        return min(usual, self.limits.acceleration)

    def starts_from_rest(self, interval: Array) -> Array:
        """(R,) [m] or [rad] longest first step of a body that starts from rest within
        an interval (R,) [s]."""
        late = np.minimum(self.timing_error, 0.5 * interval)
        return (
            0.5 * self.usual_acceleration() * (interval + late) ** 2
            + NOISE_OF_JUMP * self.noise
        )

    def reaches(self, begin: Indices, end: Indices, first: int, last: int) -> Mask:
        """(B,) whether a piece of samples `first` to `last` can be reached from earlier
        pieces of samples `begin` (B,) to `end` (B,), by their velocities on both sides.
        """
        # the stream may have stalled at its last value, unless only one sample follows
        time, values = self.runs.time, self.runs.values
        since = time if last > first else self.runs.end
        gap = time[first] - since[end]
        here = np.full(len(end), first)
        way = displacement(values[end], values[here])
        allowed_noise = NOISE_FACTOR * self.noise
        reached = lengths(way) <= (
            self.limits.speed * (gap + self.timing_error) + allowed_noise
        )
        back = np.maximum(end - STEPS_OF_VELOCITY, begin)
        forth = np.full(len(end), min(first + STEPS_OF_VELOCITY, last))
        for one, other in ((back, end), (here, forth)):
            known = other > one
            lasts = np.where(known, time[other] - time[one], 1.0)
            lasts = np.maximum(lasts, 0.5 * self.usual)
            velocity = displacement(values[one], values[other]) / lasts[:, None]
            allowed = (
                0.5 * self.limits.acceleration * gap * (gap + lasts)
                + self.timing_error * lengths(velocity)
                + allowed_noise * (1.0 + gap / lasts)
            )
            apart = lengths(way - gap[:, None] * velocity)
            reached &= ~known | (apart <= allowed)
        return reached


def displacement(before: Array, after: Array) -> Array:
    """(K, 3) way from positions (K, 3), or orientations (K, 4), to others [m], [rad].

    Of orientations it is the rotation vector in world axes, up to a quarter turn; the
    sign of a quaternion does not matter.
    """
    if before.shape[1] == 3:
        return after - before
    if len(after) > ROWS_AT_A_TIME:
        way = np.empty((len(after), 3))
        for first in range(0, len(after), ROWS_AT_A_TIME):
            part = slice(first, first + ROWS_AT_A_TIME)
            way[part] = displacement(before[part], after[part])
        return way
    # by components, each side by side: `numpy.cross` takes four times as long
    x, y, z, s = np.ascontiguousarray(after.T)
    a, b, c, r = np.ascontiguousarray(before.T)
    vector = np.empty((3, len(after)))
    vector[0] = r * x - s * a - (y * c - z * b)
    vector[1] = r * y - s * b - (z * a - x * c)
    vector[2] = r * z - s * c - (x * b - y * a)
    vector *= np.where(s * r + a * x + b * y + c * z < 0.0, -2.0, 2.0)
    return vector.T


def _noise(steps: Array) -> float:
    """Robust standard deviation of the noise of a component, or of rounding, from the
    smallest steps."""
    if len(steps) < 2:
        return 0.0
    length = lengths(steps[:: -(-len(steps) // ROWS_FOR_NOISE)])
    smallest = quantile(length, SMALLEST_STEPS)
    return max(white_noise(steps), ROUNDING_OVER_STEP * smallest)


def white_noise(steps: Array) -> float:
    """Robust standard deviation of the white noise of a component, from second
    differences, of the steps (K, n) between samples, K > 1."""
    nth = -(-len(steps) // ROWS_FOR_NOISE)
    second = np.abs(steps[1::nth] - steps[:-1:nth])
    return 1.4826 * median(second) / 6.0**0.5
