"""The spline smoother: exact laws, believable variances, gaps, held values, bad
input."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from hefting.core.errors import InputError
from hefting.motion.curve import fresh_rows
from hefting.motion.spline import aligned, fit_poses, smooth
from motions import noisy, normalised_errors, random_smooth


def assert_same(one, other):
    """Equal up to rounding: 1e-16 over h², and what the search for the bandwidth makes
    of it."""
    for field in fields(one):
        if field.name not in ("time", "position", "orientation", "bandwidth"):
            np.testing.assert_allclose(
                getattr(one, field.name),
                getattr(other, field.name),
                atol=1e-6,
                rtol=1e-4,
            )


# --- laws ---


def test_polynomial_positions_and_steady_rotation_are_recovered():
    rng = np.random.default_rng(0)
    t, c = np.linspace(0, 3, 301), rng.normal(size=(4, 3))
    w = np.array([0.3, -0.5, 0.8])
    rotation = Rotation.from_rotvec(t[:, None] * w)
    motion = smooth(
        t, sum(c[k] * t[:, None] ** k for k in range(4)), rotation.as_quat()
    )
    # a cubic costs no penalty of order 4: what is left is rounding, 1e-15 m over h²,
    # times the condition
    a = rotation.inv().apply(2 * c[2] + 6 * c[3] * t[:, None])
    np.testing.assert_allclose(motion.linear_acceleration, a, atol=1e-6)
    v = rotation.inv().apply(c[1] + 2 * c[2] * t[:, None] + 3 * c[3] * t[:, None] ** 2)
    np.testing.assert_allclose(motion.linear_velocity, v, atol=1e-7)
    # a quaternion turning at 0.5 rad/s is a sinusoid, matched by quintics 0.01 s long
    # to (0.5 h)^4
    np.testing.assert_allclose(motion.angular_velocity, np.tile(w, (301, 1)), atol=1e-6)
    np.testing.assert_allclose(motion.angular_acceleration, 0, atol=1e-5)


def test_exact_poses_give_nearly_exact_motion():
    truth = random_smooth(np.arange(0, 3, 0.01), np.random.default_rng(1))
    motion = smooth(truth.time, *truth.poses())
    # sinusoids up to 1.2 Hz on knots of 10 ms: (2 pi 1.2 h)^4 = 3e-5 of up to 20; more
    # at the ends
    inner = slice(15, -15)
    np.testing.assert_allclose(
        motion.linear_acceleration[inner], truth.linear_acceleration[inner], atol=1e-4
    )
    np.testing.assert_allclose(
        motion.angular_acceleration[inner], truth.angular_acceleration[inner], atol=1e-3
    )
    np.testing.assert_allclose(
        motion.angular_acceleration, truth.angular_acceleration, atol=2e-2
    )


def test_constant_rotation_of_the_world_changes_nothing_in_sensor_axes():
    truth, p, q = noisy(2)
    world = Rotation.from_euler("xyz", [0.4, -1.1, 2.0])
    turned = smooth(
        truth.time, world.apply(p), (world * Rotation.from_quat(q)).as_quat()
    )
    assert_same(smooth(truth.time, p, q), turned)


def test_signs_and_lengths_of_quaternions_do_not_matter():
    truth, p, q = noisy(3)
    rng = np.random.default_rng(3)
    factor = rng.choice([-1.0, 1.0], size=(len(q), 1)) * rng.uniform(
        0.5, 2.0, (len(q), 1)
    )
    assert_same(smooth(truth.time, p, q), smooth(truth.time, p, q * factor))


def test_time_may_start_anywhere():
    truth, p, q = noisy(4)
    one = smooth(truth.time, p, q)
    assert_same(one, smooth(truth.time + 16.0, p, q))
    # a clock's stamps, near 1.7e9 s, are rounded to 2e-7 s, and the search ends 2 %
    # elsewhere
    other = smooth(truth.time + 1.7e9, p, q)
    change = np.abs(one.angular_acceleration - other.angular_acceleration)
    assert (change < 0.3 * one.angular_acceleration_std[:, None]).all()


def test_slower_clock_scales_derivatives():
    truth, p, q = noisy(5)
    one, slow = smooth(truth.time, p, q), smooth(truth.time * 2.0, p, q)
    # the knots need not come out alike (their spacing starts at 20 ms), so a thousandth
    # of the signal is left
    np.testing.assert_allclose(
        slow.angular_velocity * 2.0, one.angular_velocity, atol=3e-3
    )
    np.testing.assert_allclose(
        slow.linear_acceleration * 4.0, one.linear_acceleration, atol=1e-2
    )


# --- what recordings do ---


def test_short_gaps_are_bridged_and_long_ones_are_not():
    truth, p, q = noisy(9, 5.0)
    bridged = (truth.time < 2) | (truth.time > 2.12)
    motion = smooth(truth.time[bridged], p[bridged], q[bridged], at=truth.time)
    assert np.isfinite(motion.linear_acceleration).all()
    std = motion.linear_acceleration_std
    assert std[206] > 1.2 * std[150]
    cut = (truth.time < 2) | (truth.time >= 3)
    motion = smooth(truth.time[cut], p[cut], q[cut], at=truth.time)
    assert np.array_equal(np.isnan(motion.linear_acceleration[:, 0]), ~cut)
    assert np.array_equal(np.isinf(motion.angular_acceleration_std), ~cut)
    assert 0.2 < normalised_errors(motion, truth)[0] < 3.0


def test_irregular_stamps_and_missing_samples_are_harmless():
    truth = random_smooth(
        np.sort(np.random.default_rng(10).uniform(0, 5, 450)), np.random.default_rng(10)
    )
    motion = smooth(truth.time, *truth.poses(np.random.default_rng(11)))
    assert all(0.2 < e < 3.0 for e in normalised_errors(motion, truth))


def test_held_values_count_once():
    truth, p, q = noisy(12, 3.0, 1000.0)
    held = np.arange(len(p)) // 10 * 10
    news = fresh_rows(truth.time, p[held])
    assert np.array_equal(np.flatnonzero(news), np.arange(0, len(p), 10))
    at = truth.time[:-10]
    slow = smooth(truth.time[::10], p[::10], q[::10], at=at[at <= truth.time[-10]])
    motion = smooth(truth.time, p[held], q[held], at=slow.time)
    np.testing.assert_allclose(
        motion.linear_acceleration[:-10], slow.linear_acceleration[:-10], atol=0.02
    )
    # the last hold included
    assert np.isfinite(smooth(truth.time, p[held], q[held]).linear_acceleration).all()


@pytest.mark.parametrize("step", [2.0, 7.0, 8.7, 100.0])
def test_of_values_that_were_interpolated_linearly_those_count(step):
    """Turns at a steady rate along arcs, too; written with seven digits, knots between
    rows by the row before. Rests whose noise is small beside the moves are none."""
    truth, p, q = noisy(12, 10.0, 1000.0)
    at = np.arange(0.0, len(p) - 1, step)
    rows = np.arange(len(p))
    position = np.stack([np.interp(rows, at, np.interp(at, rows, x)) for x in p.T], 1)
    turns = Rotation.from_quat(q[at.astype(int)])
    inside = rows[rows <= at[-1]]
    arcs = Slerp(at, turns)(inside).as_quat()
    for values in (position[inside], aligned(arcs)):
        kept = np.flatnonzero(fresh_rows(truth.time[inside], np.round(values, 7)))
        assert len(kept) == pytest.approx(len(at), rel=0.2)
        off = np.abs(kept - step * np.round(kept / step))
        assert np.mean(off <= 1.0) > 0.9
    rests = np.where(rows[:, None] % 400 < 397, p[rows // 400 * 400], p)
    rests += 1e-5 * np.random.default_rng(0).normal(size=p.shape)
    assert fresh_rows(truth.time, rests).all()


def test_single_repeats_and_rests_are_kept():
    truth, p, _ = noisy(13, 2.0)
    p = p.copy()
    p[50] = p[49]  # clock jitter
    assert fresh_rows(truth.time, p).all()
    p[60:160] = p[60]  # an exact rest
    assert fresh_rows(truth.time, p).all()


def test_at_rest_nothing_moves():
    t = np.linspace(0, 3, 301)
    motion = smooth(
        t, np.tile([0.1, 0.2, 0.3], (301, 1)), np.tile([0, 0, 0, 1.0], (301, 1))
    )
    # rounding of 0.3 m over (10 ms)²
    assert np.abs(motion.linear_acceleration).max() < 1e-9
    assert np.abs(motion.angular_velocity).max() < 1e-9


def test_orientation_alone():
    truth, p, q = noisy(14)
    motion = smooth(truth.time, None, q)
    assert motion.position is None
    assert motion.linear_acceleration is None
    np.testing.assert_array_equal(
        motion.angular_velocity, smooth(truth.time, p, q).angular_velocity
    )


def test_results_are_read_only_and_can_be_cut():
    truth, p, q = noisy(15)
    motion = smooth(truth.time, p, q)
    with pytest.raises(ValueError, match="read-only"):
        motion.angular_velocity[0] = 0.0
    np.testing.assert_array_equal(
        motion[10:20].linear_acceleration, motion.linear_acceleration[10:20]
    )


def test_a_long_recording_is_tuned_on_parts_of_it():
    t = np.arange(0, 600, 0.02)
    rng = np.random.default_rng(16)
    p = 0.1 * np.column_stack((np.sin(t), np.cos(0.7 * t), np.sin(1.3 * t)))
    R = Rotation.from_euler(
        "xyz", np.column_stack((0.3 * np.sin(t), np.sin(0.5 * t), np.cos(t)))
    )
    motion = smooth(
        t,
        p + 1e-4 * rng.normal(size=p.shape),
        R.as_quat() + 2e-4 * rng.normal(size=(len(t), 4)),
    )
    ddp = 0.1 * np.column_stack(
        (-np.sin(t), -0.49 * np.cos(0.7 * t), -1.69 * np.sin(1.3 * t))
    )
    error = motion.linear_acceleration - R.inv().apply(ddp)
    assert 0.2 < np.mean(error**2 / motion.linear_acceleration_std[:, None] ** 2) < 3.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, p, q: (t, p[:, :2], q), r"position: has shape"),
        (lambda t, p, q: (t, p, q[:-1]), r"orientation: has shape"),
        (lambda t, p, q: (t[::-1], p, q), r"time: row 1 is not later"),
        (
            lambda t, p, q: (
                t,
                np.where(np.arange(len(t))[:, None] == 7, np.nan, p),
                q,
            ),
            r"position: row 7 is not",
        ),
        (
            lambda t, p, q: (t, p, np.where(np.arange(len(t))[:, None] == 5, 0.0, q)),
            r"orientation: row 5 is no",
        ),
        (lambda t, p, q: (t[:5], p[:5], q[:5]), r"5 poses are too few"),
        (lambda t, p, q: (t[:0], p[:0], q[:0]), r"0 poses are too few"),
        (
            lambda t, p, q: (np.append(0.0, 1.7e9 + t[:19]), p[:20], q[:20]),
            r"20 poses in 1\.7e\+09 s are too far apart",
        ),
        (lambda t, p, q: (t, p, q, [t[-1] + 0.01]), r"ask only for times inside"),
        (
            lambda t, p, q: (
                np.cumsum(np.where(np.arange(len(t)) % 7, 0.001, 5.0)),
                p,
                q,
            ),
            r"gaps leave no",
        ),
    ],
)
def test_bad_input_is_named(change, message):
    truth, p, q = noisy(17, 1.0)
    with pytest.raises(InputError, match=message):
        smooth(*change(truth.time, p, q))


def test_positions_at_times_of_their_own():
    """At a third of the orientations' rate and starting later: as near the truth as
    their noise allows."""
    truth, position, orientation = noisy(5, duration=4.0)
    apart = slice(7, None, 3)
    at = truth.time[
        (truth.time >= truth.time[7]) & (truth.time <= truth.time[apart][-1])
    ]
    motion = smooth(
        truth.time, position[apart], orientation, at=at, position_time=truth.time[apart]
    )
    index = np.searchsorted(truth.time, at)
    error = motion.linear_acceleration - truth.linear_acceleration[index]
    square = np.mean((error / motion.linear_acceleration_std[:, None]) ** 2)
    assert 0.1 < square < 4.0  # one window: few independent errors
    together = smooth(truth.time, position, orientation)
    np.testing.assert_array_equal(  # the orientation is smoothed alone
        smooth(
            truth.time,
            position[apart],
            orientation,
            at=at,
            position_time=truth.time[apart],
        ).angular_velocity,
        together[index].angular_velocity,
    )
    with pytest.raises(InputError, match="known from"):
        smooth(
            truth.time, position[apart], orientation, position_time=truth.time[apart]
        )


def test_motion_is_known_where_position_and_orientation_are():
    """A stretch may be too short for one of the two curves, whose knots differ."""
    truth, position, orientation = noisy(3, duration=4.0)
    kept = (truth.time < 3.0) | (truth.time > 3.95)
    short = (truth.time < 3.0) | (truth.time > 3.5)
    whole = fit_poses(
        truth.time[short], position[short], orientation[short], truth.time[short]
    )
    part = fit_poses(truth.time[kept], position[kept], orientation[kept])
    poses = replace(whole, position=part.position)
    at = truth.time[truth.time > 3.6]
    motion = poses.at(at)
    assert np.isfinite(motion.angular_acceleration).all()
    assert not motion.known.any()
    assert not len(motion.measurements(at, np.zeros((len(at), 6)), (0, 0, -9.81)))
