"""The simulated arm, its motions, the wrench of a wielded body and the log: against
laws of mechanics."""

import json

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Noise
from hefting.estimators import OLS
from hefting.logs import read_log, write_log
from hefting.motion import measure
from hefting.simulation import (
    UR5,
    Part,
    hammer,
    random_smooth,
    simulate,
    sinusoids,
    stop_and_go,
    truth,
    wield,
)
from hefting.simulation.arm import JointMotion
from recordings import DATA, needs_recordings

BODY = InertialParameters.from_com(
    1.3,
    (0.05, -0.12, 0.2),
    ((0.020, 0.003, -0.001), (0.003, 0.025, 0.002), (-0.001, 0.002, 0.012)),
)
MOTIONS = {
    "sinusoids": lambda rate: sinusoids(4.0, rate, 1.5),
    "random": lambda rate: random_smooth(4.0, rate, 1.5, seed=1),
    "stop and go": lambda rate: stop_and_go(4.0, rate, dwell=0.5, move=0.8, seed=2),
}


def slope(values: np.ndarray, step: float) -> np.ndarray:
    """Central differences of fourth order, without the two instants at either end."""
    return (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (
        12.0 * step
    )


# the arm and its joints


def test_ur5_at_zero_is_as_its_maker_says():
    """Stretched out along -x: x = a2 + a3, y = -(d4 + d6), z = d1 - d5."""
    zero = np.zeros((1, 6))
    motion = UR5.motion(JointMotion([0.0], zero, zero, zero))
    np.testing.assert_allclose(
        motion.position[0], (-0.81725, -0.19145, -0.005491), atol=1e-15
    )
    np.testing.assert_allclose(
        motion.rotation[0], ((1, 0, 0), (0, 0, -1), (0, 1, 0)), atol=1e-15
    )


@pytest.mark.parametrize("name", MOTIONS)
def test_joint_derivatives(name):
    rate = 1000.0
    joints = MOTIONS[name](rate)
    # error of the differences: step^4 / 30 times the fifth derivative, infinite only
    # where the jerk jumps
    for value, derivative in (
        (joints.position, joints.velocity),
        (joints.velocity, joints.acceleration),
    ):
        error = np.abs(slope(value, 1.0 / rate) - derivative[2:-2])
        assert np.quantile(error, 0.95) < 1e-7
        assert error.max() < 0.01 * np.abs(derivative).max()


@pytest.mark.parametrize("name", MOTIONS)
def test_sensor_motion_is_the_derivative_of_its_pose(name):
    rate = 1000.0
    motion = UR5.motion(MOTIONS[name](rate))
    step = 1.0 / rate
    spin = slope(motion.rotation, step) @ np.swapaxes(motion.rotation[2:-2], 1, 2)
    pairs = (
        (slope(motion.position, step), motion.linear_velocity),
        (slope(motion.linear_velocity, step), motion.linear_acceleration),
        (slope(motion.angular_velocity, step), motion.angular_acceleration),
        (
            np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]), axis=1),
            motion.angular_velocity,
        ),
    )
    for difference, exact in pairs:
        error = np.abs(difference - exact[2:-2])
        # the same, times the arm's Jacobian and its derivatives
        assert np.quantile(error, 0.95) < 1e-6
        assert error.max() < 0.01 * np.abs(exact).max()


@pytest.mark.parametrize("speed", [1.0, 1.5, 2.0, 3.0, 4.0])
def test_sinusoids_have_the_papers_speeds(speed):
    joints = sinusoids(35.0, 60.0, speed)
    assert UR5.motion(joints).mean_speeds[0] == pytest.approx(speed, rel=1e-9)
    np.testing.assert_array_equal(joints.position[0], UR5.start)
    np.testing.assert_array_equal(
        joints.position[:, :3], np.tile(UR5.start[:3], (len(joints.time), 1))
    )
    swing = np.degrees(np.abs(joints.position - UR5.start).max(axis=0)[3:])
    assert (swing <= 45.0 + 1e-9).all()
    assert (swing > 44.0).all()
    # frequencies in the ratio 10 : 13 : 16 at the start, where the speed of sin is its
    # frequency
    np.testing.assert_allclose(
        joints.velocity[0, 3:] / joints.velocity[0, 3], (1.0, 1.3, 1.6), rtol=1e-12
    )


def test_random_motion_starts_from_rest_and_repeats():
    joints = random_smooth(5.0, 100.0, 0.8, seed=7)
    np.testing.assert_array_equal(joints.position[0], UR5.start)
    assert not joints.velocity[0].any()
    assert not joints.acceleration[0].any()
    assert UR5.motion(joints).mean_speeds[0] == pytest.approx(0.8, rel=1e-9)
    np.testing.assert_array_equal(
        joints.position, random_smooth(5.0, 100.0, 0.8, seed=7).position
    )
    assert (
        np.abs(joints.position - random_smooth(5.0, 100.0, 0.8, seed=8).position).max()
        > 0.01
    )


def test_stop_and_go_rests_between_its_moves():
    joints = stop_and_go(7.0, 100.0, dwell=1.0, move=0.75, seed=3)
    resting = np.mod(joints.time, 1.75) < 1.0
    assert not joints.velocity[resting].any()
    assert not joints.acceleration[resting].any()
    assert np.abs(joints.velocity[~resting]).max() > 0.5
    assert len(np.unique(joints.position[resting].round(9), axis=0)) == 4


@pytest.mark.parametrize("generator", [sinusoids, random_smooth])
@pytest.mark.parametrize(
    "arguments",
    [(0.0, 100.0, 1.0), (1.0, -1.0, 1.0), (1.0, 100.0, 0.0), (np.inf, 1.0, 1.0)],
)
def test_impossible_motions_are_refused(generator, arguments):
    with pytest.raises(InputError, match="must be positive"):
        generator(*arguments)


def test_too_short_to_get_going():
    """Starting from rest, one sample has no speed."""
    with pytest.raises(
        InputError, match="1 samples up to 0 s are too few to reach a mean of 1 rad/s"
    ):
        random_smooth(0.01, 100.0, 1.0)


def test_joints_must_fit_the_arm():
    five = np.zeros((3, 5))
    with pytest.raises(InputError, match="5 joints, but the arm has 6"):
        UR5.motion(JointMotion(np.arange(3.0), five, five, five))
    with pytest.raises(InputError, match="do not agree"):
        JointMotion(np.arange(2.0), five, five, five)


# the wrench


@pytest.mark.parametrize("name", MOTIONS)
def test_power_of_the_wrench_changes_the_energy(name):
    """What the sensor does on the body, f.v + tau.w, is the rate of kinetic plus
    potential energy."""
    rate, gravity = 1000.0, np.array((1.0, -2.0, -9.0))
    motion = UR5.motion(MOTIONS[name](rate))
    z = wield(motion, BODY, gravity)
    turned = motion.rotation
    c = np.einsum("kij,j->ki", turned, BODY.center_of_mass)
    w = motion.angular_velocity
    v = motion.linear_velocity + np.cross(w, c)
    local = z.angular_velocity
    kinetic = 0.5 * BODY.mass * (v * v).sum(1) + 0.5 * np.einsum(
        "ki,ij,kj->k", local, BODY.inertia_at_com, local
    )
    energy = kinetic - BODY.mass * (motion.position + c) @ gravity
    force, torque = (
        np.einsum("kij,kj->ki", turned, part) for part in (z.force, z.torque)
    )
    power = (force * motion.linear_velocity).sum(1) + (torque * w).sum(1)
    error = np.abs(slope(energy, 1.0 / rate) - power[2:-2])
    assert np.abs(power).max() > 1.0
    assert np.quantile(error, 0.95) < 1e-6  # differences of fourth order over 1 ms
    assert error.max() < 0.01 * np.abs(power).max()  # where the jerk jumps


def test_at_rest_the_wrench_is_the_weight():
    z = wield(UR5.motion(stop_and_go(0.5, 10.0)), BODY)
    np.testing.assert_allclose(z.force, -BODY.mass * z.gravity, atol=1e-14)
    np.testing.assert_allclose(
        z.torque, np.cross(BODY.center_of_mass, z.force), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.norm(z.gravity, axis=1), 9.80665, atol=1e-14)


def test_nothing_cannot_be_wielded():
    with pytest.raises(InputError, match="mass"):
        wield(UR5.motion(stop_and_go(0.5, 10.0)), InertialParameters(np.zeros(10)))


# the log


def test_noise_has_its_stated_size():
    motion = UR5.motion(random_smooth(40.0, 100.0, 1.0, seed=9))
    noise = Noise(
        force=0.3, torque=0.02, linear_acceleration=0.05, angular_acceleration=0.5
    )
    log = simulate(
        motion, BODY, noise=noise, pose_noise=(1e-3, 2e-3), seed=10, exact=True
    )
    z = wield(motion, BODY)
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(motion.rotation).inv() * Rotation.from_quat(
        log["orientation"].values
    )
    spreads = (
        (log["wrench"].values[:, :3] - z.force, noise.force),
        (log["wrench"].values[:, 3:] - z.torque, noise.torque),
        (log["position"].values - motion.position, 1e-3),
        (turns.as_rotvec(), 2e-3),
        (
            log["linear_acceleration"].values - motion.linear_acceleration,
            noise.linear_acceleration,
        ),
        (
            log["angular_acceleration"].values - motion.angular_acceleration,
            noise.angular_acceleration,
        ),
    )
    for error, level in spreads:
        # 4,000 normal samples an axis: deviation known to 1.1 %, mean to 1.6 % of it;
        # five times that
        np.testing.assert_allclose(error.std(axis=0), level, rtol=0.056)
        assert (np.abs(error.mean(axis=0)) < 0.08 * level).all()
    np.testing.assert_array_equal(
        log["angular_velocity"].values, motion.angular_velocity
    )


def test_sign_and_bias_are_those_of_the_sensor():
    motion = UR5.motion(sinusoids(1.0, 50.0, 1.0))
    bias = (1.0, 2.0, 3.0, 0.1, 0.2, 0.3)
    exact = wield(motion, BODY).wrench
    log = simulate(motion, BODY, pose_noise=(0.0, 0.0), bias=bias, on_sensor=True)
    np.testing.assert_array_equal(log["wrench"].values, -exact + bias)
    assert not log.has("linear_acceleration")


def test_seeds_decide():
    motion = UR5.motion(sinusoids(1.0, 50.0, 1.0))
    first, again, other = (
        simulate(motion, BODY, noise=NOISE_LEVELS["low"], seed=s) for s in (1, 1, 2)
    )
    for name in first.streams:
        np.testing.assert_array_equal(first[name].values, again[name].values)
        assert (first[name].values != other[name].values).all()


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_least_squares_finds_the_body_in_an_exact_log(tmp_path, suffix):
    """Simulation, log, reader, measurements and least squares agree about frames, signs
    and orders."""
    gravity = (2.0, 1.0, -9.4)
    motion = UR5.motion(random_smooth(5.0, 100.0, 1.5, seed=11))
    write_log(
        simulate(motion, BODY, gravity, pose_noise=(0.0, 0.0), exact=True),
        tmp_path / f"log{suffix}",
    )
    z = measure(read_log(tmp_path / f"log{suffix}"), gravity).measurements
    # rounding of the data, 1e-15, times the condition of the regressor, below 1e3, with
    # room
    np.testing.assert_allclose(OLS().fit(z).parameters.vector, BODY.vector, atol=1e-10)


# objects


@pytest.mark.parametrize(
    "part", hammer().parts, ids=lambda part: f"{part.solid} {part.size}"
)
def test_closed_forms_equal_integrals_over_the_mesh(part):
    mesh = part.mesh(sections=2000)
    mesh.density = part.density
    ours = part.parameters
    # a prism of n = 2,000 sides lacks 2 pi²/(3 n²) = 1.6e-6 of a circle's area, twice
    # that of its inertia
    assert ours.mass == pytest.approx(mesh.mass, rel=2e-6)
    np.testing.assert_allclose(ours.center_of_mass, mesh.center_mass, atol=1e-9)
    scale = np.abs(ours.inertia_at_com).max()
    np.testing.assert_allclose(
        ours.inertia_at_com, mesh.moment_inertia, atol=5e-6 * scale
    )


def test_a_turned_part_turns_its_inertia():
    turn = np.linalg.qr(np.random.default_rng(12).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    straight = Part("box", (0.1, 0.2, 0.3), 1000.0, (0.0, 0.0, 0.0))
    turned = Part("box", (0.1, 0.2, 0.3), 1000.0, (0.0, 0.0, 0.0), turn)
    pose = np.eye(4)
    pose[:3, :3] = turn
    np.testing.assert_allclose(
        turned.parameters.vector, straight.parameters.moved(pose).vector, atol=1e-15
    )


def test_hammer():
    """One watertight surface; its parts do not overlap; it is far from homogeneous."""
    tool = hammer()
    mesh = tool.mesh()
    assert mesh.is_watertight
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(
        sum(part.mesh().volume for part in tool.parts), rel=1e-6
    )
    np.testing.assert_allclose(mesh.extents, (0.125, 0.028, 0.292), atol=1e-6)
    body = tool.parameters
    assert body.consistency().is_consistent
    assert body.mass == pytest.approx(0.670, abs=1e-3)
    assert body.center_of_mass[2] - mesh.center_mass[2] > 0.07


def test_truth_has_the_keys_of_the_recordings():
    pose = np.eye(4)
    pose[:3, 3] = (0.1, 0.2, 0.3)
    body = hammer().parameters.moved(pose)
    facts = json.loads(
        json.dumps(
            truth(body, (0.125, 0.028, 0.292), pose, mesh_unit="mm", name="hammer")
        )
    )
    found = InertialParameters.from_origin(
        facts["mass"], facts["center_of_mass_sensor"], facts["inertia_at_sensor"]
    )
    np.testing.assert_allclose(found.vector, body.vector, atol=1e-16)
    np.testing.assert_allclose(
        facts["inertia_at_com_sensor_axes"], body.inertia_at_com, atol=1e-16
    )


@needs_recordings
def test_the_truth_of_an_object_has_the_keys_of_the_workshop_tools():
    facts = truth(
        hammer().parameters,
        (0.125, 0.028, 0.292),
        np.eye(4),
        mesh_unit="mm",
        name="hammer",
    )
    file = DATA / "workshop-tools" / "file" / "truth.json"
    assert set(facts) == set(json.loads(file.read_text())) - {"mesh_watertight"}
