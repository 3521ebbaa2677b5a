"""Samples of pose streams that no body can have passed: all of those, and no others."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.motion.continuity import find_discontinuities
from hefting.motion.pose_steps import (
    ORIENTATION_LIMITS,
    POSITION_LIMITS,
    Runs,
    Steps,
    displacement,
)
from hefting.simulation import UR5, random_smooth, stop_and_go, trapezoids

MOTIONS = {
    "random": lambda rate, seed: random_smooth(8.0, rate, 1.0, seed=seed),
    "stop-and-go": lambda rate, seed: stop_and_go(8.0, rate, seed=seed),
    "trapezoids": lambda rate, seed: trapezoids(8.0, rate, 2.0, 8.0, seed=seed),
    "long rests": lambda rate, seed: trapezoids(8.0, rate, dwell=(1.5, 2.5), seed=seed),
}
NOISES = (0.0, 1e-5, 1e-4, 1e-3)
"""Standard deviations of position [m]; that of orientation is 3.5 rad/m times it."""


@cache
def moved(kind, rate, seed):
    """One of `MOTIONS` of the sensor."""
    return UR5.motion(MOTIONS[kind](rate, seed))


def poses(kind, rate, seed, noise=0.0):
    """Times (K,), positions (K, 3) and quaternions (K, 4), of random signs."""
    motion, rng = moved(kind, rate, seed), np.random.default_rng(seed)
    place, turn = rng.normal(size=(2, len(motion.time), 3))
    turned = Rotation.from_matrix(motion.rotation) * Rotation.from_rotvec(
        3.5 * noise * turn
    )
    return motion.time, motion.position + noise * place, turned.as_quat()


def found(time, position, orientation):
    return (
        find_discontinuities(time, position, POSITION_LIMITS),
        find_discontinuities(time, orientation, ORIENTATION_LIMITS),
    )


@pytest.mark.parametrize("rate", [10.0, 25.0, 100.0, 500.0])
@pytest.mark.parametrize("kind", MOTIONS)
def test_none_of_a_motion_without_faults(kind, rate):
    """Whatever the noise; also where messages are lost, values are held between slower
    updates or rounded to a millimetre, and time stamps are off: 112 recordings."""
    rng = np.random.default_rng(1)
    for noise in NOISES:
        time, p, q = poses(kind, rate, 3, noise)
        assert found(time, p, q) == (None, None)
        kept = rng.random(len(time)) > 0.2
        assert found(time[kept], p[kept], q[kept]) == (None, None)
        slower = np.arange(len(time)) // 4 * 4
        assert found(time, p[slower], q[slower]) == (None, None)
        assert found(time, np.round(p, 3), q) == (None, None)
        late = time + rng.uniform(0.0, min(0.004, 0.9 / rate), len(time))
        assert found(np.sort(late), p, q) == (None, None)


def test_the_sign_of_a_quaternion_does_not_matter():
    """Even where it changes at random: the same orientation is no jump."""
    time, _, q = poses("random", 100.0, 4, 1e-4)
    flipped = q * np.random.default_rng(2).choice((-1.0, 1.0), (len(q), 1))
    assert find_discontinuities(time, flipped, ORIENTATION_LIMITS) is None
    np.testing.assert_allclose(
        displacement(flipped[:-1], flipped[1:]), displacement(q[:-1], q[1:]), atol=1e-12
    )


@pytest.mark.parametrize("kind", MOTIONS)
@pytest.mark.parametrize("size", [0.05, 1.0, 1e3])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_glitches_are_exactly_the_ones_made(kind, size, noise):
    """Single samples, neighbours, and short runs that move along with the body."""
    time, p, q = poses(kind, 100.0, 5, noise)
    bad = np.zeros(len(time), dtype=bool)
    bad[[0, 40, 41, 300, len(time) - 1, *range(500, 512)]] = True
    rng = np.random.default_rng(3)
    aside = np.repeat(rng.normal(size=(5, 3)), (1, 2, 1, 12, 1), axis=0)
    aside *= size / np.linalg.norm(aside, axis=1, keepdims=True)
    p[bad] += aside
    turns = Rotation.from_rotvec(min(3.0 * size, 2.0) * aside / size)
    q[bad] = (Rotation.from_quat(q[bad]) * turns).as_quat()
    for each in found(time, p, q):
        assert each is not None
        np.testing.assert_array_equal(each.left_out, bad)
        assert not each.frozen.any()
        assert not len(each.jumps)


@pytest.mark.parametrize("rate", [100.0, 125.0, 500.0])
def test_angles_interpolated_over_their_end_are_left_out(rate):
    """Ten a second, joined to a faster log: between -179 and 179 degrees they turn by 358
    degrees in 0.1 s, at 62 rad/s from one sample to the next."""
    time = np.arange(0.0, 8.0, 1.0 / rate)
    known = np.arange(0.0, 8.01, 0.1)
    yaw = (170.0 + 25.0 * np.sin(known) + 180.0) % 360.0 - 180.0
    turns = np.outer(np.radians(np.interp(time, known, yaw)), (0.0, 0.0, 1.0))
    q = Rotation.from_rotvec(turns).as_quat()
    each = find_discontinuities(time, q, ORIENTATION_LIMITS)
    wrapped = np.flatnonzero(np.abs(np.diff(yaw)) > 180.0)
    assert len(wrapped) == 3
    between = np.zeros(len(time), dtype=bool)
    for k in wrapped:
        between |= (time > known[k] + 1e-9) & (time < known[k + 1] - 1e-9)
    assert each is not None
    # besides one sample at either end of a spin, which may count as of it
    assert (each.left_out | ~between).all()
    assert (each.left_out & ~between).sum() <= 2 * len(wrapped)


def test_a_stop_within_a_sample_is_no_fault():
    """Of a robot at its full speed, as by its brakes; to the half of it no step is even
    looked into."""
    time = np.arange(0.0, 4.0, 0.002)
    run = np.minimum(time, 2.0)
    p = np.outer(2.0 * run, (1.0, 0.0, 0.0))
    q = Rotation.from_rotvec(np.outer(3.0 * run, (0.0, 0.0, 1.0))).as_quat()
    assert found(time, p, q) == (None, None)
    for values, limits in ((0.5 * p, POSITION_LIMITS), (q, ORIENTATION_LIMITS)):
        assert not Steps.of(Runs.of(time, values), limits).broken().any()


@pytest.mark.parametrize("noise", NOISES)
def test_a_stall_is_where_the_body_moves_on(noise):
    """0.2 s of the same pose in motion are left out but for the first; where they begin
    the recording, all of them."""
    time, p, q = poses("random", 100.0, 6, noise)
    for values, limits in ((p, POSITION_LIMITS), (q, ORIENTATION_LIMITS)):
        stalled = values.copy()
        stalled[300:321] = stalled[300]
        each = find_discontinuities(time, stalled, limits)
        assert each is not None
        np.testing.assert_array_equal(np.flatnonzero(each.left_out), range(301, 321))
        assert each.frozen.sum() == 20
        early = values[250:].copy()
        early[:20] = early[0]
        each = find_discontinuities(time[250:], early, limits)
        assert each is not None
        np.testing.assert_array_equal(np.flatnonzero(each.ends), range(20))


def test_a_robot_that_stands_still_is_no_stall():
    """The same value for two seconds, in the same motion that is stalled elsewhere."""
    time, p, _ = poses("long rests", 100.0, 7)
    held = np.flatnonzero((np.diff(p, axis=0) == 0.0).all(axis=1))
    assert len(held) > 300
    speed = np.linalg.norm(np.gradient(p, time, axis=0), axis=1)
    begin = int(np.argmax(speed))
    p[begin : begin + 15] = p[begin]
    each = find_discontinuities(time, p, POSITION_LIMITS)
    assert each is not None
    np.testing.assert_array_equal(
        np.flatnonzero(each.left_out), range(begin + 1, begin + 15)
    )


@pytest.mark.parametrize("silent", [3, 30, 150])
def test_a_driver_that_has_not_begun(silent):
    """Zeros and the identity before, and after, the motion."""
    for kind in MOTIONS:
        time, p, q = poses(kind, 100.0, 8)
        for values, limits in ((p, POSITION_LIMITS), (q, ORIENTATION_LIMITS)):
            nothing = np.eye(values.shape[1])[-1] * (values.shape[1] == 4)
            before, after = values.copy(), values.copy()
            before[:silent], after[-silent:] = nothing, nothing
            for changed, bad in (
                (before, range(silent)),
                (after, range(len(time) - silent, len(time))),
            ):
                each = find_discontinuities(time, changed, limits)
                assert each is not None
                np.testing.assert_array_equal(np.flatnonzero(each.left_out), bad)
                assert each.ends.sum() == silent


def test_parts_out_of_reach_are_both_kept():
    """A frame that jumps by 3 m in the middle: no sample is a glitch, the jump is
    told."""
    time, p, _ = poses("random", 100.0, 9, 1e-4)
    p[400:] += (3.0, 0.0, 0.0)
    each = find_discontinuities(time, p, POSITION_LIMITS)
    assert each is not None
    assert not each.left_out.any()
    np.testing.assert_array_equal(each.jumps, [400])


def test_the_frame_does_not_matter():
    """In axes turned by any rotation, and in a time that begins elsewhere, the same
    samples are left out."""
    time, p, q = poses("random", 100.0, 10, 1e-4)
    bad = np.random.default_rng(4).random(len(time)) < 0.03
    p[bad] += 0.3
    q[bad] = Rotation.random(int(bad.sum()), rng=np.random.default_rng(5)).as_quat()
    turn = Rotation.from_rotvec((0.3, -1.0, 0.5))
    here = found(time, p, q)
    there = found(time + 1.7e3, turn.apply(p), (turn * Rotation.from_quat(q)).as_quat())
    for one, other in zip(here, there, strict=True):
        assert one is not None
        assert other is not None
        np.testing.assert_array_equal(one.left_out, other.left_out)
