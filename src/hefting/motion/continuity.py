"""Continuity of poses: which samples no moving body can reach from their neighbours.

A position or an orientation changes by bounded accelerations. A step between successive
samples that no velocity nearby explains, within the largest acceleration, the noise and
the errors of the time stamps, is a break. Breaks divide the samples into pieces; of
these the chain is kept that holds most samples, each piece reachable from the one
before. A value that is repeated exactly, from which the next step is a jump, is not a
body at rest but a stream that stalled, or had not begun.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, Indices, Mask

TIMING_ERROR = 0.005
"""[s] Error of a pose's time stamp that is not a fault of the pose. Rows of recordings
at a nominal 1 kHz are some milliseconds off."""
TIMING_ERROR_IN_INTERVALS = 1.5
"""The same in sampling intervals, where these are longer: a sample that came a whole
interval late is no fault."""
NOISE_FACTOR = 15.0
"""Standard deviations of a component's noise by which a step may differ from that of
its neighbours. The difference of two steps has 2.4 of them: 15 are exceeded once in
10⁸ times."""
NEIGHBOURING_STEPS = (-2, -1, 1, 2)
"""Places, relative to a step, of the steps whose velocity may explain it. Two on each
side, as one of them may end at a faulty sample."""
STEPS_OF_VELOCITY = 4
"""Largest number of steps from which the velocity at the end of a piece is found."""
FEWEST_HELD_ROWS = 3
"""Smallest number of equal rows that may be a stalled stream."""
NOISE_OF_JUMP = 8.0
"""Standard deviations of a component's noise by which the first step after a held value
is longer than that of a body that starts from rest. A step has 1.4 of them."""
ACCELERATION_TIME = 0.05
"""[s] Time over which velocities are taken for the usual acceleration."""
STARTS_OVER_USUAL = 4.0
"""Acceleration of a start from rest over that which the moving parts of a recording
exceed for a tenth of the time."""
HELD_UPDATES = 2.0
"""Number of usual runs of equal rows that a run of a stalled stream exceeds."""
ROWS_FOR_NOISE = 20_000
"""Largest number of rows from which the noise is found."""
PIECES_LOOKED_BACK = 40
"""Number of earlier pieces from which a piece may be reached: of more faulty pieces in
a row the chain is cut."""
HELD_TIMING_ERRORS = 2.0
"""Errors of time stamps that a stall of the stream lasts longer than. Shorter ones are
part of every log: in recordings at a nominal 1 kHz some last 3 to 8 ms."""
JUMP_COST = 1.0
"""[s] Duration of poses that a jump must be worth: two parts of a recording that cannot
be reached from each other are both kept where each is longer."""


@dataclass(frozen=True)
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


@dataclass(frozen=True, eq=False)
class Discontinuities:
    """Samples of a pose stream that no body can have passed, and jumps."""

    glitch: Mask
    """(K,) samples out of reach of the others"""
    frozen: Mask
    """(K,) samples repeated while the body moved on"""
    ends: Mask
    """(K,) values held before the motion begins with a jump, or after it ends with
    one"""
    jumps: Indices
    """(J,) first samples of parts that are out of reach of the part before, and are
    kept nevertheless"""

    @property
    def left_out(self) -> Mask:
        """(K,) any of the masks."""
        return self.glitch | self.frozen | self.ends


def find_discontinuities(
    time: Array, values: Array, limits: Limits
) -> Discontinuities | None:
    """Samples of a stream of positions or orientations that cannot be reached from the
    others; None where there are none.

    Parameters
    ----------
    time : (K,) [s], increasing.
    values : (K, 3) positions [m], or (K, 4) unit quaternions, of either sign.
    limits : bounds on the motion.
    """
    if len(time) < FEWEST_HELD_ROWS:
        return None
    runs = _Runs.of(time, values)
    if len(runs.first) < FEWEST_HELD_ROWS:
        return None
    steps = _Steps.of(runs, limits)
    broken = steps.broken()
    reached, jumps = np.ones(len(runs.first), dtype=bool), np.zeros(0, dtype=int)
    if broken.any():
        reached, jumps = _reached(steps, _pieces(broken), _are_long(runs))
    out = ~reached[runs.of_row]
    frozen = np.zeros(len(time), dtype=bool)
    kept = np.flatnonzero(~out)
    if runs.any_long and len(kept) >= FEWEST_HELD_ROWS:
        frozen[kept] = _frozen(time[kept], values[kept], limits)
    if not (out.any() or frozen.any() or len(jumps)):
        return None
    ends = (out | frozen) & runs.at_ends
    return Discontinuities(
        out & ~ends, frozen & ~ends, ends, runs.first[jumps].astype(int)
    )


@dataclass(frozen=True, eq=False)
class _Runs:
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
    def of(cls, time: Array, values: Array) -> "_Runs":
        """Runs of values (K, d) at times (K,)."""
        changed = np.ones(len(time), dtype=bool)
        changed[1:] = (values[1:] != values[:-1]).any(axis=1)
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


@dataclass(frozen=True, eq=False)
class _Steps:
    """Steps between successive runs."""

    time: Array
    """(U,) [s] at which the runs begin"""
    end: Array
    """(U,) [s] at which they end"""
    values: Array
    """(U, 3) or (U, 4) of the runs"""
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
    def of(cls, runs: _Runs, limits: Limits) -> "_Steps":
        """Steps between runs."""
        usual = float(np.median(np.diff(runs.time)))
        return cls(
            runs.time,
            runs.end,
            runs.values,
            steps := displacement(runs.values[:-1], runs.values[1:]),
            np.maximum(runs.time[1:] - runs.end[:-1], usual),
            usual,
            max(TIMING_ERROR, TIMING_ERROR_IN_INTERVALS * usual),
            _noise(steps),
            limits,
        )

    def broken(self) -> Mask:
        """(U - 1,) the steps that no velocity nearby explains."""
        limits, n = self.limits, len(self.steps)
        length = np.sqrt(np.einsum("ij,ij->i", self.steps, self.steps))
        speed = length / self.interval
        allowed_noise = NOISE_FACTOR * self.noise
        most = limits.speed * (self.interval + self.timing_error) + allowed_noise
        # most steps are explained by the acceleration alone
        suspect = np.flatnonzero(
            length > 0.5 * limits.acceleration * self.interval**2 + allowed_noise
        )
        explained = np.zeros(len(suspect), dtype=bool)
        middle = self.end[:-1] + 0.5 * self.interval
        for place in NEIGHBOURING_STEPS:
            other = suspect + place
            there = (other >= 0) & (other < n)
            other = np.clip(other, 0, n - 1)
            there &= length[other] <= most[other]
            dt = self.interval[suspect]
            expected = self.steps[other] * (dt / self.interval[other])[:, None]
            apart = np.linalg.norm(self.steps[suspect] - expected, axis=1)
            allowed = (
                limits.acceleration * dt * np.abs(middle[other] - middle[suspect])
                + self.timing_error * speed[other]
                + allowed_noise * np.maximum(1.0, dt / self.interval[other])
            )
            explained |= there & (apart <= allowed)
        broken = np.zeros(n, dtype=bool)
        broken[suspect] = ~explained
        return broken | (length > most)

    def usual_acceleration(self) -> float:
        """Acceleration [m/s²] or [rad/s²] that a body at rest may start with: several
        times that of the moving parts of this recording, within the limits."""
        lag = max(int(np.ceil(ACCELERATION_TIME / self.usual)), 2)
        way = np.cumsum(self.steps, axis=0)
        if len(way) < 4 * lag:
            return self.limits.acceleration
        time = self.time[1:]
        velocity = (way[lag:] - way[:-lag]) / (time[lag:] - time[:-lag])[:, None]
        change = np.linalg.norm(velocity[lag:] - velocity[:-lag], axis=1)
        acceleration = change / (0.5 * (time[2 * lag :] - time[: -2 * lag]))
        speed = np.linalg.norm(velocity[lag:], axis=1)
        moving = speed * lag * self.usual > NOISE_FACTOR * self.noise + 1e-9
        if not moving.any():
            return self.limits.acceleration
        usual = STARTS_OVER_USUAL * float(np.quantile(acceleration[moving], 0.9))
        return min(usual, self.limits.acceleration)

    def starts_from_rest(self, interval: Array) -> Array:
        """(R,) largest first step [m] or [rad] of a body at rest within an interval
        (R,) [s]."""
        late = np.minimum(self.timing_error, interval)
        return (
            0.5 * self.usual_acceleration() * (interval + late) ** 2
            + NOISE_OF_JUMP * self.noise
        )

    def reaches(self, begin: Indices, end: Indices, first: int, last: int) -> Mask:
        """(B,) whether a piece, from sample `first` to `last`, is reached from earlier
        ones, from samples `begin` (B,) to `end` (B,)."""
        gap = self.time[first] - self.time[end]
        way = displacement(self.values[end], self.values[np.full(len(end), first)])
        allowed_noise = NOISE_FACTOR * self.noise
        reached = np.linalg.norm(way, axis=1) <= (
            self.limits.speed * (gap + self.timing_error) + allowed_noise
        )
        back = np.maximum(end - STEPS_OF_VELOCITY, begin)
        here = np.full(len(end), first)
        forth = np.full(len(end), min(first + STEPS_OF_VELOCITY, last))
        for one, other in ((back, end), (here, forth)):
            known = other > one
            lasts = np.where(known, self.time[other] - self.time[one], 1.0)
            lasts = np.maximum(lasts, 0.5 * self.usual)
            velocity = displacement(self.values[one], self.values[other])
            velocity = velocity / lasts[:, None]
            allowed = (
                0.5 * self.limits.acceleration * gap * (gap + lasts)
                + self.timing_error * np.linalg.norm(velocity, axis=1)
                + allowed_noise * (1.0 + gap / lasts)
            )
            apart = np.linalg.norm(way - gap[:, None] * velocity, axis=1)
            reached &= ~known | (apart <= allowed)
        return reached


def displacement(before: Array, after: Array) -> Array:
    """(K, 3) way from positions (K, 3), or orientations (K, 4), to others [m], [rad].

    Of orientations it is the rotation vector in world axes, up to a quarter turn; the
    sign of a quaternion does not matter.
    """
    if before.shape[1] == 3:
        return after - before
    v, s = after[:, :3], after[:, 3:]
    u, r = before[:, :3], before[:, 3:]
    scalar = s * r + np.einsum("ij,ij->i", v, u)[:, None]
    vector = r * v - s * u - np.cross(v, u)
    return np.where(scalar < 0.0, -2.0, 2.0) * vector


def _noise(steps: Array) -> float:
    """Robust standard deviation of the noise of a component, from second
    differences."""
    stride = -(-len(steps) // ROWS_FOR_NOISE)
    second = np.diff(steps, axis=0)[::stride]
    if not len(second):
        return 0.0
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))


def _are_long(runs: _Runs) -> Mask:
    """(U,) the runs of more equal rows than usual."""
    usual = float(np.median(runs.length))
    return (runs.length >= FEWEST_HELD_ROWS) & (runs.length > HELD_UPDATES * usual)


def _frozen(time: Array, values: Array, limits: Limits) -> Mask:
    """(K,) samples of runs of equal rows that are longer than usual, and than errors of
    time stamps, and begin or end with a jump.

    The first sample of such a run, at which the stream stalled, is not among them,
    unless it is the first of all: the stream had not begun.
    """
    runs = _Runs.of(time, values)
    steps = _Steps.of(runs, limits)
    long = np.flatnonzero(
        _are_long(runs)
        & (runs.end - runs.time > HELD_TIMING_ERRORS * steps.timing_error)
    )
    if not len(long) or len(runs.first) < FEWEST_HELD_ROWS:
        return np.zeros(len(time), dtype=bool)
    length = np.linalg.norm(steps.steps, axis=1)
    from_rest = steps.starts_from_rest(steps.interval)
    last = len(runs.length) - 1
    frozen = np.zeros(last + 1, dtype=bool)
    for step, there in ((long, long < last), (long - 1, long > 0)):
        step = np.clip(step, 0, last - 1)
        frozen[long] |= there & (length[step] > from_rest[step])
    repeated = np.ones(len(time), dtype=bool)
    repeated[runs.first[1:]] = False
    return repeated & frozen[runs.of_row]


def _pieces(broken: Mask) -> Indices:
    """(P + 1,) first sample of each piece between breaks (U - 1,), and the number of
    samples."""
    return np.concatenate(([0], np.flatnonzero(broken) + 1, [len(broken) + 1]))


def _reached(steps: _Steps, pieces: Indices, held: Mask) -> tuple[Mask, Indices]:
    """(U,) the samples of the chain of pieces with most samples, and the first samples
    of those of its pieces that follow a jump.

    A piece is not reached from the one just before it, from which a break separates it,
    unless this ends with a value that is held: the body may have moved meanwhile. Where
    two parts are out of reach of each other a jump between them costs the samples of
    `JUMP_COST`.

    Parameters
    ----------
    steps : between U samples, or runs of equal ones.
    pieces : (P + 1,) as `_pieces` gives them.
    held : (U,) the runs that are longer than usual.
    """
    samples = np.diff(pieces)
    cost = JUMP_COST / steps.usual
    P, first, last = len(samples), pieces[:-1], pieces[1:] - 1
    score, before = samples.astype(float), np.full(P, -1)
    jumped = np.zeros(P, dtype=bool)
    for p in range(1, P):
        best = int(np.argmax(score[:p]))
        if score[best] > cost:
            score[p], before[p] = samples[p] + score[best] - cost, best
            jumped[p] = True
        earlier = np.arange(max(p - PIECES_LOOKED_BACK, 0), p - 1 + held[last[p - 1]])
        near = earlier[steps.reaches(first[earlier], last[earlier], first[p], last[p])]
        if not len(near):
            continue
        source = int(near[np.argmax(score[near])])
        if samples[p] + score[source] > score[p]:
            score[p], before[p] = samples[p] + score[source], source
            jumped[p] = False
    reached, after_jump = np.zeros(pieces[-1], dtype=bool), []
    p = int(np.argmax(score))
    while p >= 0:
        reached[first[p] : last[p] + 1] = True
        if jumped[p]:
            after_jump.append(int(first[p]))
        p = int(before[p])
    return reached, np.array(after_jump[::-1], dtype=int)
