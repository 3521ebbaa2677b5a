"""The live filter: the same however samples arrive, optimal, believable, careful at
starts and gaps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.motion.fixed_lag import steady_filter
from hefting.motion.kalman import PoseFilter
from motions import POSITION_NOISE, ROTATION_NOISE, noisy, normalised_errors

LIVE = PoseFilter(
    0.01,
    POSITION_NOISE,
    ROTATION_NOISE,
    position_bandwidth=32.0,
    rotation_bandwidth=32.0,
)
VARIANTS = [
    LIVE,
    replace(LIVE, lag=0.0),
    replace(
        LIVE,
        order="acceleration",
        position_bandwidth=35.0,
        rotation_bandwidth=35.0,
        lag=0.0,
    ),
    replace(
        LIVE, order="acceleration", position_bandwidth=35.0, rotation_bandwidth=35.0
    ),
    replace(LIVE, cold_start=True, lag=0.0),
]


def run(pose_filter, time, position, orientation, cuts=()):
    """All motion given out, as one array (K, 13), for samples that arrive in pieces cut
    at `cuts`."""
    state, rows = pose_filter.start(), []
    for piece in np.split(np.arange(len(time)), cuts):
        state, m = pose_filter.update(
            state, time[piece], position[piece], orientation[piece]
        )
        std = (
            m.linear_acceleration_std,
            m.angular_velocity_std,
            m.angular_acceleration_std,
        )
        rows.append(
            np.column_stack(
                (
                    m.time,
                    m.linear_acceleration,
                    m.angular_velocity,
                    m.angular_acceleration,
                    np.transpose(std),
                )
            )
        )
    return np.concatenate(rows)


@pytest.mark.parametrize("pose_filter", VARIANTS)
@pytest.mark.parametrize("jitter", [0.0, 2e-3])
def test_one_at_a_time_equals_blocks_equals_all_at_once(pose_filter, jitter):
    truth, p, q = noisy(0, 2.0)
    rng = np.random.default_rng(1)
    t = truth.time + jitter * rng.uniform(-1, 1, len(truth.time))
    # signs must be carried from piece to piece, too
    q = q * rng.choice([-1.0, 1.0], size=(len(q), 1))
    whole = run(pose_filter, t, p, q)
    # block form and steps agree once covariances have settled to 1e-5 of theirs;
    # accelerations are up to 20
    np.testing.assert_allclose(
        run(pose_filter, t, p, q, range(1, len(t))), whole, atol=1e-5
    )
    cuts = np.sort(rng.choice(np.arange(1, len(t)), 9, replace=False))
    np.testing.assert_allclose(run(pose_filter, t, p, q, cuts), whole, atol=1e-5)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_variances_are_believable(rate):
    found = []
    for seed in range(3):
        truth, p, q = noisy(seed, 2.5, rate)
        live = PoseFilter.tuned(truth.time[: int(rate)], p[: int(rate)], q[: int(rate)])
        _, motion = live.update(live.start(), truth.time, p, q)
        found.append(normalised_errors(motion, truth))
    # 1 is perfect, the project promises 0.3 to 3; analytic motion is smoother than
    # white snap expects
    assert np.all(np.mean(found, axis=0) > 0.3)
    assert np.all(np.mean(found, axis=0) < 3.0)


def test_lag_pays():
    errors = {}
    for lag in (0.0, 0.1):
        truth, p, q = noisy(3, 4.0)
        live = replace(LIVE, lag=lag)
        _, m = live.update(live.start(), truth.time, p, q)
        at = np.searchsorted(truth.time, m.time - 1e-9)
        errors[lag] = np.std(m.angular_acceleration - truth.angular_acceleration[at])
    assert errors[0.1] < errors[0.0] / 4  # 10 in theory at lag 2/wc


@pytest.mark.parametrize(("n", "order"), [(4, "snap"), (3, "acceleration")])
def test_estimate_is_the_conditional_mean(n, order):
    """The fixed-lag estimate is that of a Gaussian process, conditioned on the samples
    up to then."""
    K, lag, period, wc, r = 30, 0.05, 0.01, 30.0, 1e-3
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.uniform(0.5, 1.5, K)) * period
    p = rng.normal(size=(K, 3)) * r
    live = PoseFilter(period, r, 1e-3, wc, 30.0, lag, order)
    _, m = live.update(live.start(), t, p, np.tile([0, 0, 0, 1.0], (K, 1)))
    k = int(np.flatnonzero(t == m.time[-1])[0])
    # n-fold integrated white noise of intensity q from t0 on, with a broad prior on the
    # state there
    q, u = r**2 * period * wc ** (2 * n), t - t[0]
    grid = np.linspace(0, u[-1], 4001)
    kernel = np.array([np.clip(x - grid, 0, None) ** (n - 1) for x in u]) / np.prod(
        np.arange(1, n)
    )
    kernel_dd = (
        np.clip(u[k] - grid, 0, None) ** (n - 3)
        * (grid < u[k])
        / np.prod(np.arange(1, n - 2))
    )
    step = grid[1]
    free = np.column_stack([u**i / np.prod(np.arange(1, i + 1)) for i in range(n)])
    prior = np.diag([1e4] + [1e8] * (n - 1)) * (r * wc ** np.arange(n)) ** 2
    free_dd = np.zeros(n)
    free_dd[2:] = free[k, : n - 2]
    C = q * step * kernel @ kernel.T + free @ prior @ free.T + r**2 * np.eye(K)
    c = q * step * kernel @ kernel_dd + free @ prior @ free_dd
    expected = c @ np.linalg.solve(C, p)
    # trapezoids of 0.1 ms give three digits
    np.testing.assert_allclose(
        m.linear_acceleration[-1],
        expected,
        rtol=1e-2,
        atol=1e-2 * np.abs(expected).max(),
    )


def test_steady_filter_solves_its_equations():
    s = steady_filter(4, 0.2, 10)
    assert np.all(np.abs(np.linalg.eigvals(s.decay[:4])) < 1)
    assert np.all(np.diff(s.variances[:, 2]) < 0)  # each later sample helps
    assert s.variances[0, 2] > 15 * s.variances[-1, 2]
    # a long lag reaches the variance of the two-sided smoother in continuous time, wc^5
    # dt/(8 sin(5 pi/8))
    s = steady_filter(4, 0.05, 300)
    assert s.variances[-1, 2] == pytest.approx(
        0.05 / (8 * np.sin(5 * np.pi / 8)), rel=0.01
    )


def test_nothing_is_given_out_before_it_is_known():
    truth, p, q = noisy(5, 4.0)
    _, m = LIVE.update(LIVE.start(), truth.time, p, q)
    # given out 0.1 s later: usable 0.12 to 0.25 s after the start
    assert 0.02 < m.time[0] <= 0.15
    assert m.time[-1] == pytest.approx(truth.time[-1] - 0.1)
    assert np.all(np.diff(m.time) > 0)
    first = m[:10]
    assert all(e < 4.0 for e in normalised_errors(first, truth))
    steady = m.angular_acceleration_std[-1]
    assert np.all(m.angular_acceleration_std <= 3.0 * steady * (1 + 1e-9))


def test_cold_start_gives_everything_and_errs():
    truth, p, q = noisy(6, 4.0)
    cold = replace(LIVE, cold_start=True, lag=0.0)
    _, m = cold.update(cold.start(), truth.time, p, q)
    assert len(m.time) == len(truth.time)
    early = np.abs(m.angular_acceleration - truth.angular_acceleration)[:30].max()
    assert early > 20 * m.angular_acceleration_std[0]


def test_missing_samples_and_gaps():
    truth, p, q = noisy(7, 8.0)
    rng = np.random.default_rng(7)
    kept = rng.uniform(size=len(p)) > 0.2  # a fifth lost at random
    kept[300:320] = False  # 0.2 s: bridged
    kept[500:700] = False  # 2 s: started anew
    _, m = LIVE.update(LIVE.start(), truth.time[kept], p[kept], q[kept])
    assert all(0.2 < e < 3.0 for e in normalised_errors(m, truth))
    after = m.time[m.time > 6.5]
    assert 7.02 < after[0] < 7.2
    assert set(m.time) <= set(truth.time[kept])


def test_frame_sign_and_time_shift_change_nothing():
    truth, p, q = noisy(8, 2.0)
    world = Rotation.from_euler("xyz", [0.4, -1.1, 2.0])
    one = run(LIVE, truth.time, p, q)
    other = run(
        LIVE,
        truth.time + 64.0,
        world.apply(p),
        -(world * Rotation.from_quat(q)).as_quat(),
    )
    np.testing.assert_allclose(one[:, 1:], other[:, 1:], atol=1e-6)  # rounding over dt²


def test_orientation_alone():
    truth, p, q = noisy(9, 4.0)
    state, m = LIVE.update(LIVE.start(), truth.time[:200], None, q[:200])
    both = LIVE.update(LIVE.start(), truth.time[:200], p[:200], q[:200])[1]
    assert m.linear_acceleration is None
    np.testing.assert_allclose(m.angular_velocity, both.angular_velocity, atol=1e-12)
    with pytest.raises(InputError, match="position"):
        LIVE.update(state, truth.time[200:], p[200:], q[200:])


def test_state_is_a_value():
    truth, p, q = noisy(10, 4.0)
    state, _ = LIVE.update(LIVE.start(), truth.time[:150], p[:150], q[:150])
    rest = truth.time[150:], p[150:], q[150:]
    one, other = LIVE.update(state, *rest)[1], LIVE.update(state, *rest)[1]
    np.testing.assert_array_equal(one.angular_acceleration, other.angular_acceleration)


def test_tuning_finds_the_noise():
    truth, p, q = noisy(11, 5.0)
    live = PoseFilter.tuned(truth.time, p, q, lag=0.05)
    assert live.lag == 0.05
    assert live.period == pytest.approx(0.01)
    # 1500 values each: 2 % of sampling error, and a little of the motion taken for
    # noise
    assert live.position_noise == pytest.approx(POSITION_NOISE, rel=0.1)
    assert live.rotation_noise == pytest.approx(ROTATION_NOISE, rel=0.1)
    assert 10 < live.rotation_bandwidth < 60


def test_bad_input_is_named():
    truth, p, q = noisy(12, 1.0)
    state, _ = LIVE.update(LIVE.start(), truth.time, p, q)
    with pytest.raises(InputError, match="not later"):
        LIVE.update(state, truth.time[-1:], p[-1:], q[-1:])
    with pytest.raises(InputError, match=r"PoseFilter\.lag"):
        PoseFilter(lag=-1.0)
    with pytest.raises(InputError, match=r"PoseFilter\.order"):
        PoseFilter(order="jerk")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match=r"PoseFilter\.period"):
        PoseFilter(period=0.0)
    same, nothing = LIVE.update(state, [], np.empty((0, 3)), np.empty((0, 4)))
    assert len(nothing.time) == 0
    assert same.latest == state.latest
