"""Gyroscope and accelerometer beside the poses: better motion, believable spreads,
their own faults found."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.recording import Recording, Stream
from hefting.motion import fit_poses, measure, smooth_poses
from hefting.motion.inertial import fuse
from motions import GRAVITY, random_smooth, stop_and_go

LEVER = np.array([0.03, -0.02, 0.04])
CLOCK = 0.004
BIASES = np.array([0.01, -0.02, 0.005]), np.array([0.1, -0.05, 0.2])
NOISE = 0.005, 0.03
"""rad/s and m/s²: a cheap MEMS sensor's, at 200 Hz"""


def readings(make, seed, duration=5.0, rate=200.0, noise=NOISE):
    """Gyroscope and accelerometer, biased, late and off the origin, on the motion
    `make` with this seed."""
    time, rng = np.arange(0, duration, 1 / rate), np.random.default_rng(seed + 100)
    truth = make(time, np.random.default_rng(seed))
    w, alpha = truth.angular_velocity, truth.angular_acceleration
    lever = np.cross(alpha, LEVER) + np.cross(w, np.cross(w, LEVER))
    force = truth.linear_acceleration - truth.gravity() + lever
    values = (
        x + b + n * rng.normal(size=x.shape)
        for x, b, n in zip((w, force), BIASES, noise, strict=True)
    )
    return [Stream(time + CLOCK, v) for v in values]


def poses_of(make, seed, duration=5.0):
    truth = make(np.arange(0, duration, 0.01), np.random.default_rng(seed))
    return truth, truth.poses(np.random.default_rng(seed + 200))


def deviations(motion, truth):
    """Errors (K, 3) of linear and angular acceleration."""
    return (
        motion.linear_acceleration - truth.linear_acceleration,
        motion.angular_acceleration - truth.angular_acceleration,
    )


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


@pytest.mark.parametrize(
    ("make", "bound"), [(random_smooth, 0.75), (stop_and_go, 0.65)]
)
def test_errors_shrink_and_stay_believable(make, bound):
    """Measured over these seeds: .3 to .56 of the errors without the sensors, squared
    error over variance .4 to 1.2."""
    before, after, normalised = [], [], []
    for seed in range(3):
        truth, (p, q) = poses_of(make, seed)
        plain = fit_poses(truth.time, p, q)
        fused, notes, warnings = fuse(plain, GRAVITY, *readings(make, seed))
        assert len(notes) == 2
        assert not warnings
        motion = fused.at(truth.time)
        before.append([rms(e) for e in deviations(plain.at(truth.time), truth)])
        errors = deviations(motion, truth)
        after.append([rms(e) for e in errors])
        stds = motion.linear_acceleration_std, motion.angular_acceleration_std
        normalised.append(
            [np.mean((e / s[:, None]) ** 2) for e, s in zip(errors, stds, strict=True)]
        )
    assert (np.mean(after, axis=0) <= bound * np.mean(before, axis=0)).all()
    assert (np.mean(normalised, axis=0) > 0.3).all()
    assert (np.mean(normalised, axis=0) < 1.4).all()


def test_faults_of_the_sensors_are_found_and_said():
    truth, (p, q) = poses_of(stop_and_go, 1)
    _, notes, _ = fuse(fit_poses(truth.time, p, q), GRAVITY, *readings(stop_and_go, 1))
    gyroscope, accelerometer = (
        [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]\d+)?", note)]
        for note in notes
    )
    # 1,000 readings: spreads of the means 1.6e-4 rad/s and 1e-3 m/s², of place and
    # clock over seeds 0.4 mm and 0.2 ms
    np.testing.assert_allclose(
        gyroscope, [NOISE[0], *BIASES[0], 4.0], rtol=0.15, atol=5e-4
    )
    np.testing.assert_allclose(accelerometer[1:4], BIASES[1], atol=5e-3)
    np.testing.assert_allclose(accelerometer[4:7], 1e3 * LEVER, atol=1.5)
    assert accelerometer[7] == pytest.approx(4.0, abs=0.6)


def test_no_worse_than_without_where_they_are_poor():
    """A hundred times the noise: nothing is gained, and no more than 2 % lost."""
    truth, (p, q) = poses_of(random_smooth, 3)
    plain = fit_poses(truth.time, p, q)
    fused, *_ = fuse(plain, GRAVITY, *readings(random_smooth, 3, noise=(0.5, 3.0)))
    before = [rms(e) for e in deviations(plain.at(truth.time), truth)]
    after = [rms(e) for e in deviations(fused.at(truth.time), truth)]
    assert (np.array(after) <= 1.02 * np.array(before)).all()


@pytest.mark.parametrize("spoil", ["degrees", "other axes", "g", "gravity"])
def test_foreign_readings_are_left_out(spoil):
    truth, (p, q) = poses_of(random_smooth, 4)
    plain = fit_poses(truth.time, p, q)
    gyroscope, accelerometer = readings(random_smooth, 4)
    turned = Rotation.from_euler("x", 90, degrees=True)
    if spoil == "degrees":
        gyroscope = replace(gyroscope, values=np.rad2deg(gyroscope.values))
    elif spoil == "other axes":
        gyroscope = replace(gyroscope, values=gyroscope.values @ turned.as_matrix().T)
    elif spoil == "g":
        accelerometer = replace(accelerometer, values=accelerometer.values / 9.81)
    sensors = (None, accelerometer) if spoil.startswith("g") else (gyroscope, None)
    gravity = (
        Rotation.from_euler("x", 20, degrees=True).apply(GRAVITY)
        if spoil == "gravity"
        else GRAVITY
    )
    fused, notes, warnings = fuse(plain, gravity, *sensors)
    assert not notes
    assert "contradicts the poses: not used; is it in sensor axes" in warnings[0]
    assert fused is plain


def test_gravity_may_have_been_removed():
    """The two kinds of accelerometer give the same motion."""
    truth, (p, q) = poses_of(random_smooth, 5)
    plain = fit_poses(truth.time, p, q)
    _, force = readings(random_smooth, 5, noise=(0.0, 0.0))
    at = random_smooth(force.time - CLOCK, np.random.default_rng(5))
    linear = replace(force, values=force.values + at.gravity())
    one, *_ = fuse(plain, GRAVITY, None, force)
    two, *_ = fuse(plain, GRAVITY, None, linear, gravity_removed=True)
    difference = (
        one.at(truth.time).linear_acceleration - two.at(truth.time).linear_acceleration
    )
    gain = rms(plain.at(truth.time).linear_acceleration - truth.linear_acceleration)
    # they differ by how gravity turned with noisy orientation
    assert rms(difference) < 0.1 * gain


def test_a_recording_with_sensors_is_measured_with_them():
    truth, (p, q) = poses_of(random_smooth, 6)
    gyroscope, accelerometer = readings(random_smooth, 6)
    wrench = np.zeros((len(truth.time), 6))
    streams = {"position": p, "orientation": q, "wrench": wrench + 1.0}
    recording = Recording(
        {name: Stream(truth.time, values) for name, values in streams.items()}
        | {"gyroscope": gyroscope, "accelerometer": accelerometer}
    )
    measured = measure(recording, GRAVITY)
    assert measured.source == "inertial"
    assert len(measured.notes) == 2
    live = measure(recording, GRAVITY, "filter", smooth_poses(recording, GRAVITY))
    assert not live.notes, "the filter heeds no such sensor"
    without = Recording({k: s for k, s in recording.streams.items() if k in streams})
    error = rms(measured.measurements.linear_acceleration - truth.linear_acceleration)
    assert error < 0.75 * rms(
        measure(without, GRAVITY).measurements.linear_acceleration
        - truth.linear_acceleration
    )
    assert measure(without, GRAVITY).source == "smooth"


def test_a_gap_of_the_poses_is_no_reading():
    """Just before a gap there is no derivative of the motion: its NaN had stopped the
    calibration."""
    truth, (p, q) = poses_of(random_smooth, 2)
    held = (truth.time < 2.0) | (truth.time > 2.5)
    sensors = readings(random_smooth, 2)
    plain = fit_poses(truth.time[held], p[held], q[held])
    fused, notes, warnings = fuse(plain, GRAVITY, *sensors)
    assert len(notes) == 2
    assert not warnings
    # away from the gap, beside which neither is much worth
    seen = (truth.time < 1.8) | (truth.time > 2.7)
    before, after = (
        [rms(e[seen]) for e in deviations(motion.at(truth.time), truth)]
        for motion in (plain, fused)
    )
    assert (np.array(after) < before).all()
