"""Faults of a simulated log: each does what it says and nothing else; rates, seeds, IMU
and joint angles."""

from dataclasses import fields

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.robots import with_poses
from hefting.simulation import (
    UR5,
    WRENCH_NOISE,
    XARM7,
    Faults,
    Rates,
    held_modular,
    random_smooth,
    record,
    sinusoids,
    tilted_gravity,
    wield_analytically,
)
from hefting.simulation.faults import FT300

NONE = Faults(pose_noise=(0.0, 0.0), gyroscope_noise=0.0, accelerometer_noise=0.0)
ALL = Rates(joints=None, imu=None)
BODY = held_modular("hammer").parameters
NAMES = (
    "wrench",
    "position",
    "orientation",
    "joint_positions",
    "gyroscope",
    "accelerometer",
)


def faulty(**changes):
    from dataclasses import replace

    return replace(NONE, **changes)


@pytest.fixture(scope="module")
def wielding():
    """Twenty seconds at 200 Hz."""
    return wield_analytically(UR5, random_smooth(20.0, 200.0, 1.0, seed=1), BODY)


@pytest.fixture(scope="module")
def clean(wielding):
    return record(wielding, NONE, ALL)


def unchanged(log, clean, *but):
    for name in set(NAMES) - set(but):
        np.testing.assert_array_equal(log[name].values, clean[name].values)
        np.testing.assert_array_equal(log[name].time, clean[name].time)


def test_without_faults_the_log_is_exact(wielding, clean):
    z, motion = wielding.measurements, wielding.motion
    assert tuple(sorted(clean.streams)) == tuple(sorted(NAMES))
    np.testing.assert_array_equal(clean["wrench"].values, z.wrench)
    np.testing.assert_array_equal(clean["position"].values, motion.position)
    turn = Rotation.from_matrix(motion.rotation).inv() * Rotation.from_quat(
        clean["orientation"].values
    )
    assert turn.magnitude().max() < 1e-7
    np.testing.assert_array_equal(
        clean["joint_positions"].values, wielding.joints.position
    )
    np.testing.assert_array_equal(clean["gyroscope"].values, z.angular_velocity)
    np.testing.assert_array_equal(
        clean["accelerometer"].values, z.linear_acceleration - z.gravity
    )


@pytest.mark.parametrize("level", WRENCH_NOISE)
def test_noise_levels(wielding, clean, level):
    log = record(wielding, faulty(wrench_noise=WRENCH_NOISE[level]), ALL, seed=2)
    error = log["wrench"].values - clean["wrench"].values
    # 4,000 normal samples a channel: deviation known to 1.1 %; five times that
    np.testing.assert_allclose(error.std(axis=0), WRENCH_NOISE[level], rtol=0.056)
    unchanged(log, clean, "wrench")


def test_coloured_noise_has_its_size_and_its_colour(wielding, clean):
    log = record(wielding, faulty(wrench_noise=FT300, noise_correlation=0.8), seed=3)
    error = (log["wrench"].values - clean["wrench"].values) / FT300
    # (1 + r) / (1 - r) = 9 times fewer independent samples: deviation to 3.4 %,
    # correlation to 1 %
    np.testing.assert_allclose(error.std(axis=0), 1.0, rtol=0.15)
    lag = [np.corrcoef(e[1:], e[:-1])[0, 1] for e in error.T]
    np.testing.assert_allclose(lag, 0.8, atol=0.05)
    first = [
        record(wielding, faulty(wrench_noise=FT300, noise_correlation=0.99), seed=s)[
            "wrench"
        ].values[0]
        for s in range(40)
    ]
    spread = ((np.array(first) - clean["wrench"].values[0]) / FT300).std()
    # 240 samples: stationary from the first on
    assert spread == pytest.approx(1.0, rel=0.2)


def test_sensors_of_motion(wielding, clean):
    bias, tilt = (0.01, -0.02, 0.03), (0.1, 0.2, -0.3)
    faults = Faults(
        pose_noise=(2e-3, 3e-3), joint_noise=1e-3, gyroscope_noise=0.01, gyroscope_bias=bias,
        accelerometer_noise=0.2, accelerometer_bias=tilt,
    )  # fmt: skip
    log = record(wielding, faults, ALL, seed=4)
    np.testing.assert_array_equal(log["wrench"].values, clean["wrench"].values)
    turn = Rotation.from_quat(clean["orientation"].values).inv() * Rotation.from_quat(
        log["orientation"].values
    )
    errors = {name: log[name].values - clean[name].values for name in NAMES} | {
        "orientation": turn.as_rotvec()
    }
    levels = {
        "position": 2e-3,
        "orientation": 3e-3,
        "joint_positions": 1e-3,
        "gyroscope": 0.01,
        "accelerometer": 0.2,
    }
    for name, level in levels.items():
        np.testing.assert_allclose(errors[name].std(axis=0), level, rtol=0.056)
    np.testing.assert_allclose(errors["gyroscope"].mean(axis=0), bias, atol=0.08 * 0.01)
    np.testing.assert_allclose(
        errors["accelerometer"].mean(axis=0), tilt, atol=0.08 * 0.2
    )


def test_bias_drift_and_sign(wielding, clean):
    bias, drift = (1.0, 2.0, 3.0, 0.1, 0.2, 0.3), (0.5, 0.0, -0.5, 0.02, 0.01, 0.0)
    exact, share = clean["wrench"].values, np.linspace(0.0, 1.0, 4000)[:, None]
    log = record(wielding, faulty(bias=bias, drift=drift, on_sensor=True), ALL)
    np.testing.assert_allclose(
        log["wrench"].values, -exact + bias + share * drift, atol=1e-13
    )
    unchanged(log, clean, "wrench")
    curved = (
        record(wielding, faulty(drift=drift, drift_kind="exponential"))["wrench"].values
        - exact
    )
    np.testing.assert_allclose(
        curved[[0, -1]], np.array((0.0 * np.array(drift), drift)), atol=1e-13
    )
    assert curved[1000, 0] > 0.5 * 0.5  # more than half of it in the first quarter
    rate = np.diff(curved[:, 0])
    # rounding of 1e-4 in 0.5
    np.testing.assert_allclose(rate[1:] / rate[:-1], np.exp(-3.0 / 3999), rtol=1e-8)


def test_the_wrench_is_late_by_the_delay(wielding, clean):
    log = record(wielding, faulty(wrench_delay=0.03), ALL)
    np.testing.assert_array_equal(log["wrench"].values, clean["wrench"].values)
    np.testing.assert_allclose(
        log["wrench"].time - clean["wrench"].time, 0.03, atol=1e-14
    )
    unchanged(log, clean, "wrench")


def test_spikes(wielding, clean):
    log = record(wielding, faulty(spikes=0.05, spike_size=(20.0, 1.0)), ALL, seed=5)
    error = log["wrench"].values - clean["wrench"].values
    hit = (error != 0.0).any(axis=1)
    assert hit.mean() == pytest.approx(0.05, abs=0.015)  # 200 of 4,000, give or take 14
    # 5 % known, five times
    np.testing.assert_allclose(
        error[hit].std(axis=0), (20.0,) * 3 + (1.0,) * 3, rtol=0.25
    )
    unchanged(log, clean, "wrench")


def test_messages_get_lost_each_on_its_own(wielding, clean):
    log = record(wielding, faulty(dropped=0.2), ALL, seed=6)
    for name in NAMES:
        kept = np.isin(clean[name].time, log[name].time)
        assert kept[0]
        assert kept.mean() == pytest.approx(0.8, abs=0.03)
        np.testing.assert_array_equal(log[name].values, clean[name].values[kept])
    # one message
    np.testing.assert_array_equal(log["position"].time, log["orientation"].time)
    assert (np.isin(log["wrench"].time, log["position"].time)).mean() < 0.85


def test_contacts_push_the_object_somewhere(wielding, clean):
    log = record(wielding, faulty(contacts=0.3, contact_force=(3.0, 8.0)), ALL, seed=7)
    push = clean["wrench"].values - log["wrench"].values
    size = np.linalg.norm(push[:, :3], axis=1)
    touching = size > 0.0
    assert touching.mean() == pytest.approx(0.3, abs=0.01)
    bouts = np.split(
        np.arange(len(size))[touching],
        np.flatnonzero(np.diff(np.flatnonzero(touching)) > 1) + 1,
    )
    assert len(bouts) == 10
    for bout in bouts:
        strongest = push[bout[np.argmax(size[bout])]]
        assert 3.0 <= np.linalg.norm(strongest[:3]) <= 8.0
        # a single force through a point near the body: no torque along it but by its
        # lever
        line = push[bout] / size[bout, None]
        np.testing.assert_allclose(line, np.tile(line[0], (len(bout), 1)), atol=1e-8)
        arm = np.linalg.norm(line[0, 3:])
        assert arm < np.linalg.norm(BODY.center_of_mass) + 0.1 * np.sqrt(3.0)
        assert abs(line[0, :3] @ line[0, 3:]) < 1e-9
    unchanged(log, clean, "wrench")


def test_saturation(wielding, clean):
    exact = clean["wrench"].values
    log = record(wielding, faulty(saturation=(10.0, 0.2)))["wrench"].values
    most = np.repeat((10.0, 0.2), 3)
    np.testing.assert_array_equal(log, np.clip(exact, -most, most))
    assert (np.abs(log) == most).any(axis=0)[2]


def test_rates(wielding, clean):
    log = record(wielding, NONE, Rates(wrench=100.0, pose=50.0, joints=200.0, imu=25.0))
    for name, step in (
        ("wrench", 2),
        ("position", 4),
        ("joint_positions", 1),
        ("gyroscope", 8),
    ):
        np.testing.assert_array_equal(log[name].values, clean[name].values[::step])
        np.testing.assert_array_equal(log[name].time, clean[name].time[::step])
    assert set(record(wielding, NONE, Rates(pose=0.0, joints=None)).streams) == {
        "wrench",
        "joint_positions",
    }
    for rate in (60.0, 400.0, -1.0, np.nan):
        with pytest.raises(InputError, match=r"wrench rate .* does not divide"):
            record(wielding, NONE, Rates(wrench=rate))


def test_seeds_decide_and_faults_do_not_disturb_each_other(wielding):
    some = Faults(wrench_noise=FT300, dropped=0.1)
    first, again, other = (record(wielding, some, ALL, seed) for seed in (1, 1, 2))
    for name in NAMES:
        np.testing.assert_array_equal(first[name].values, again[name].values)
        assert (
            len(first[name]) != len(other[name])
            or (first[name].values != other[name].values).any()
        )
    more = Faults(
        wrench_noise=FT300, dropped=0.1, spikes=0.05, contacts=0.2, bias=(1.0,) * 6
    )
    with_more = record(wielding, more, ALL, 1)
    unchanged(with_more, first, "wrench")
    same = np.isclose(
        with_more["wrench"].values - first["wrench"].values, 1.0, atol=1e-12
    ).all(axis=1)
    assert 0.7 < same.mean() < 0.8  # neither hit by a spike nor touching


def test_poses_from_the_joint_angles_of_the_log():
    wielding = wield_analytically(XARM7, random_smooth(2.0, 50.0, 1.0, 3, XARM7), BODY)
    log = record(wielding, NONE, Rates(joints=None))
    found = with_poses(log, XARM7.robot)
    np.testing.assert_allclose(
        found["position"].values, wielding.motion.position, atol=1e-14
    )
    assert log.joint_names == XARM7.robot.joints


def test_a_tilted_base_tilts_gravity():
    g = tilted_gravity(np.radians(15.0), heading=0.7)
    assert np.linalg.norm(g) == pytest.approx(9.80665, rel=1e-14)
    assert np.degrees(np.arccos(-g[2] / 9.80665)) == pytest.approx(15.0, abs=1e-9)
    # about an axis that stays level
    assert abs(g @ (np.cos(0.7), np.sin(0.7), 0.0)) < 1e-12
    turned = wield_analytically(UR5, random_smooth(1.0, 50.0, 1.0), BODY, g)
    tilt = Rotation.from_rotvec(
        np.radians(15.0) * np.array((np.cos(0.7), np.sin(0.7), 0.0))
    )
    np.testing.assert_allclose(tilt.apply(g), (0.0, 0.0, -9.80665), atol=1e-13)
    np.testing.assert_allclose(
        np.linalg.norm(turned.measurements.gravity, axis=1), 9.80665, rtol=1e-13
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"dropped": 1.0}, {"spikes": -0.1}, {"contacts": np.nan}, {"noise_correlation": 1.0}, {"bias": (1.0, 2.0)},
        {"drift_kind": "random"}, {"wrench_noise": (-1.0,) * 6}, {"saturation": (1.0,)}, {"wrench_delay": np.inf},
    ],
    ids=lambda wrong: next(iter(wrong)),
)  # fmt: skip
def test_impossible_faults_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Faults(**wrong)
    assert set(wrong) <= {field.name for field in fields(Faults)}


def test_the_papers_sensor_is_its_moderate_level_and_quieter_about_its_own_axis():
    """Robotiq FT 300, data sheet: signal noise 0.1 N; 0.005 N m about x and y, 0.003 N
    m about z."""
    assert WRENCH_NOISE["ft300"] == (*WRENCH_NOISE["moderate"][:5], 0.003)
    assert WRENCH_NOISE["moderate"] == (0.1, 0.1, 0.1, 0.005, 0.005, 0.005)


def test_a_single_sample():
    wielding = wield_analytically(UR5, sinusoids(0.01, 100.0, 1.0), BODY)
    faults = Faults(
        wrench_noise=FT300,
        noise_correlation=0.5,
        drift=(1.0,) * 6,
        dropped=0.9,
        contacts=0.5,
        spikes=0.5,
    )
    log = record(wielding, faults, ALL, seed=1)
    assert all(len(log[name]) == 1 for name in NAMES)


def test_the_body_is_in_the_sensor_frame(wielding):
    assert isinstance(wielding.body, InertialParameters)
    np.testing.assert_array_equal(wielding.body.vector, BODY.vector)


def test_faults_of_the_poses(wielding, clean):
    """Each changes its own samples of position and orientation, and no other stream."""
    glitches = record(wielding, faulty(pose_glitches=0.01), ALL)
    unchanged(glitches, clean, "position", "orientation")
    moved = (glitches["position"].values != clean["position"].values).any(axis=1)
    # 40 of 4,000 expected: five standard deviations
    assert 10 < moved.sum() < 75

    stalls = record(wielding, faulty(pose_stalls=0.06), ALL)
    unchanged(stalls, clean, "position", "orientation")
    held = (np.diff(stalls["position"].values, axis=0) == 0.0).all(axis=1)
    # 1.2 s at 200 Hz, of which the first of each of three stalls is a new pose
    assert abs(held.sum() - 240) <= 6

    silent = faulty(pose_startup=0.5, pose_shutdown=0.25)
    log = record(wielding, silent, ALL)
    unchanged(log, clean, "position", "orientation")
    none = (log["orientation"].values == (0.0, 0.0, 0.0, 1.0)).all(axis=1)
    assert none[:100].all()
    assert none[-50:].all()
    assert none.sum() == 150
