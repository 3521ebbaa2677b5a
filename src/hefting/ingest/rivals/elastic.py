"""The grip yields to the load, as a suction cup or soft fingers do, or has slack; or the
sensor's mount does; or the arm vibrates.

The centre of mass is c - C s, with the compliance C (3, 3) and the specific force s of
the sensor in its axes, which is nearly that of gravity for slow motion. The force is
that of the rigid body; the torque also has m s x C s, in which a multiple of the
identity in C cancels. For an object with slack, which moves until it meets a stop,
tanh(s / g0) by axes takes the place of s, with g0 a third of gravity; for one that
slides slowly from stop to stop, the integral of s between them.

A mount turns the sensor against the logged frame, by a compliance k that is the same
about all axes, times the torque about some point r of the mount. To first order, and
without the velocity of the turn, s is turned: by s x k (t + r x f) for a force f and a
torque t.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.quantity import significant
from hefting.core.spatial import Array, interpolated
from hefting.ingest.blocks import Blocks
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    Rows,
    beside_body,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.rivals.explanation import Explanation, at_offset, fit_as_given

GRIP = "grip-elastic"
SMALLEST_MOVE = 0.001
"""[m] Smallest movement of the COM that is reported."""
STOPPED = 3.3
"""[m/s²] Specific force along an axis at which slack is used up."""
SLIDING = (0.1, 0.2, 0.4, 0.8, 1.6)
"""[s] Times that are tried in which `WEIGHT` slides an object from the middle to a
stop."""
WEIGHT = 9.81
"""[m/s²] Specific force of gravity, about."""
LEVI_CIVITA = np.cross(np.eye(3)[:, None], np.eye(3))
"""(3, 3, 3) cross products of the unit vectors."""


def explain_grip(case: Case) -> Explanation | None:
    """The likeliest compliance, at the clock offset of the recording as given."""
    if not case.path.moves:
        return None
    given, offset = fit_as_given(case)
    fitted = at_offset(case, lambda motion: _rows(case, motion), offset)
    if is_hopeless(case, fitted, given):
        return None
    body, rest = np.split(fitted.solution[fitted.best], [10])
    C = rest[:9].reshape(3, 3) / body[0]
    if not fitted.best:
        C = _with_isotropic(C)
    place = -_laws(case, fitted.rows.known[0, :, :3])[fitted.best] @ C.T
    mean = place.mean(axis=0)
    moved = float(np.linalg.norm(place - mean, axis=1).max())
    if not SMALLEST_MOVE < moved < 1.0:
        return None
    body[1:4] += body[0] * mean
    way = (
        "have slack in the grip, or a part that slides"
        if fitted.best
        else "give way in the grip, as in a suction cup or soft fingers"
    )
    return Explanation(
        GRIP,
        f"the object seems to {way}: its centre of mass is up to {significant(1e3 * moved)} mm "
        "from its mean place",
        "grip it stiffer and record again, or allow for that motion",
        fitted,
        8 + min(fitted.best, 2),  # one more for slack, and for the time of sliding
        parameters=body,
        of_many_laws=True,
    )


def yielding_columns(features: Array) -> Array:
    """(..., 6, 9) derivatives of the wrench by mass times compliance, row by row, from
    features (..., 12)."""
    s = features[..., :3]
    return np.tensordot(_products(s, s), YIELDING, 1)


def _rows(case: Case, motion: Motion) -> Rows:
    """Rows of a body, of its mass times the compliance by each law in turn, and of a
    bias."""
    features = case.features(motion)[0]
    s = features[:, :3]
    laws = _laws(case, s)
    known = [np.concatenate((features, _products(s, law)), 1) for law in laws]
    used = np.repeat(motion.known, len(laws), axis=0)
    return with_bias(case, np.stack(known), beside_body(YIELDING), used)


def _laws(case: Case, s: Array) -> Array:
    """(L, K, 3) driving quantity of the COM's movement by each law, from the specific
    force (K, 3) [m/s²]."""
    stopped = np.tanh(s / STOPPED)
    share = np.diff(case.time, prepend=case.time[0])[:, None, None] * s[:, None]
    share = share / (WEIGHT * np.array(SLIDING)[:, None])
    sliding = np.empty_like(share)
    place = stopped[0]
    for k, step in enumerate(share):
        place = sliding[k] = np.clip(place + step, -1.0, 1.0)
    return np.stack((s, STOPPED * stopped, *(STOPPED * sliding.swapaxes(0, 1))))


def _products(s: Array, law: Array) -> Array:
    """(..., 9) products of the components of the specific force and of the driving
    quantity."""
    return (s[..., :, None] * law[..., None, :]).reshape(*s.shape[:-1], 9)


YIELDING = np.einsum("irc,jl->ijcrl", LEVI_CIVITA, np.eye(3)).reshape(9, 3, 9)
YIELDING = np.concatenate((np.zeros_like(YIELDING), YIELDING), axis=1)
"""(9, 6, 9) columns of the compliance, row by row, per unit of each product."""


def _with_isotropic(C: Array) -> Array:
    """The compliance (3, 3) plus the least multiple of the identity for which nothing
    moves against its load."""
    return C - np.linalg.eigvalsh(C + C.T)[0] / 2.0 * np.eye(3)


MOUNT = "mount-elastic"
MOUNT_UNKNOWNS = 4
"""The compliance, and its product with the place of the point."""
PASSES = 2
"""Number of times that the load is predicted, with improved turns."""
SMALLEST_TURN = np.radians(1.0)
"""Smallest turn from the mean one that is reported: arms yield by some tenths of a
degree."""
LARGEST_TURN = np.radians(10.0)
"""Largest turn of a mount that could stay unnoticed; beyond, another object is
likelier."""


def explain_mount(case: Case) -> Explanation | None:
    """The likeliest compliance, at the clock offset of the recording as given."""
    if not case.path.moves:
        return None
    fitted, offset = fit_as_given(case)
    motion = case.motion_late(offset)
    features = case.features(motion)
    maps = beside_body(np.eye(6 * MOUNT_UNKNOWNS).reshape(-1, 6, MOUNT_UNKNOWNS))
    for _ in range(PASSES):
        body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best, :10]
        turns = _turns(features[0] @ body)
        moved = np.cross(features[0, :, None, :3], turns)
        columns = np.einsum("kux,xc->kcu", moved, body[:3])
        known = np.concatenate((features, columns.reshape(1, len(turns), -1)), axis=2)
        fitted = fit_rows(case, with_bias(case, known, maps, motion.known))
    turn = np.einsum("kux,u->kx", turns, fitted.solution[0, 10:][:MOUNT_UNKNOWNS])
    largest = float(np.linalg.norm(turn - turn.mean(axis=0), axis=1).max())
    if not SMALLEST_TURN < largest < LARGEST_TURN:
        return None
    what = (
        "the mount of the sensor seems to give way under the load, so that it is turned by "
        f"up to {np.degrees(largest):.2g}° from its mean direction in the logged frame"
    )
    fix = "mount it stiffer, or move slower with a lighter object"
    return Explanation(MOUNT, what, fix, fitted, MOUNT_UNKNOWNS, rarity=2.0)


def _turns(load: Array) -> Array:
    """(K, 4, 3) turns under loads (K, 6), per unit of the compliance and of its product
    with the place of the point."""
    force, torque = load[:, None, :3], load[:, None, 3:]
    return np.concatenate((torque, np.cross(np.eye(3), force)), axis=1)


LOWEST_FREQUENCY = 3.0
"""[Hz] Below it arms with an object move, and liquids in it swing."""
BAND = 0.1
"""Half width of a vibration's band relative to its frequency."""
LEAST_SHARE = 0.5
"""Least share of the residual variance in that band: of white noise it is at most a
fifth."""
WIDEST = 4.0
"""Largest ratio of the frequencies that bound nine tenths of what is above the
motion's: for 5 to 15 Hz it is 3, for white noise above 10."""
MOST_BLOCKS = 6_000
"""Largest number of blocks of the wrench that are used, the first ones: a minute."""
FEWEST_BLOCKS = 64
"""Least number of blocks."""


@dataclass(frozen=True)
class Vibration:
    """A vibration in the residuals of a body's wrench."""

    frequency: float
    """[Hz] median of the band"""
    force: float
    """[N] amplitude, over all axes"""
    share: float
    """of the residual variance"""

    def beside(self, unexplained: float) -> float:
        """The part of an unexplained residual that is no vibration."""
        return unexplained * (1.0 - self.share) ** 0.5

    @classmethod
    def of(cls, case: Case) -> Self | None:
        """From the recording as given, with each channel detrended; None for too few
        samples, or if most of the residual is elsewhere."""
        time, residual = _residual(case)
        if len(time) < FEWEST_BLOCKS:
            return None
        line = np.column_stack((np.ones_like(time), time - time.mean()))
        residual = residual - line @ np.linalg.lstsq(line, residual, rcond=None)[0]
        even = np.linspace(time[0], time[-1], len(time))
        values = interpolated(even, time, residual)
        frequency = np.fft.rfftfreq(len(even), float(even[1] - even[0]))
        window = np.hanning(len(even))
        power = np.square(np.abs(np.fft.rfft(values * window[:, None], axis=0)))
        power *= 2.0 / (len(even) * np.square(window).sum())
        scale = np.maximum(
            np.square(values).mean(axis=0).reshape(2, 3).sum(axis=1), 1e-300
        )
        weighted = (power.reshape(-1, 2, 3).sum(axis=2) / scale).sum(axis=1)
        fast = frequency > LOWEST_FREQUENCY
        if not fast.any() or not weighted[fast].any():
            return None
        peak = float(frequency[np.argmax(np.where(fast, weighted, 0.0))])
        near = np.abs(frequency - peak) < BAND * peak
        share = float(weighted[near].sum() / weighted.sum())
        if share < LEAST_SHARE:
            below = np.cumsum(weighted[fast])
            parts = np.array((0.05, 0.5, 0.95)) * below[-1]
            low, peak, high = np.interp(parts, below, frequency[fast])
            if high > WIDEST * low:
                return None
            near, share = fast, float(below[-1] / weighted.sum())
        return cls(float(peak), float(np.sqrt(2.0 * power[near, :3].sum())), share)


def _residual(case: Case) -> tuple[Array, Array]:
    """Times (B,) [s] and residuals (B, 6) of the blocks' wrench."""
    wrench = case.recording["wrench"]
    blocks = Blocks.of(wrench.time, wrench.values)
    time, values = blocks.time[:MOST_BLOCKS], blocks.wrench[:MOST_BLOCKS]
    fitted, offset = fit_as_given(case)
    motion = case.motion_at(time[None] - offset)
    known = motion.known[0]
    body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best][:10]
    left = values - case.features(motion)[0] @ body
    return time[known], left[known]
