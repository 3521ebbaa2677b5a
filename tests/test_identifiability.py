"""What a motion can tell: ranks and condition numbers, the reasons for what is open, and the paper's appendix."""

import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console
from scipy.linalg import null_space
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from hefting.calibration import fit_freely
from hefting.errors import InputError
from hefting.estimate import Estimate
from hefting.estimators import PMD
from hefting.estimators.blend import Blend
from hefting.identifiability import condition_number, identifiability, rank
from hefting.inertia import InertialParameters
from hefting.inspection import inspect
from hefting.measurements import Measurements, Noise
from hefting.moments import Moments
from hefting.recording import Recording, Stream
from hefting.regressor import full_regressor, reduced_regressor
from hefting.report import inspection_report
from hefting.shapes import PointMasses
from hefting.simulation import UR5, hammer, random_smooth, simulate, sinusoids, wield
from hefting.spatial import PARAMETERS
from random_problems import random_body, random_motion, with_wrench

SIZE = 0.2
INERTIA = PARAMETERS[4:]
G = 9.80665


def at_rest(*gravity_directions, each=20):
    """Samples at rest with gravity along each of the directions in turn."""
    g = np.repeat(G * np.array([np.array(d) / np.linalg.norm(d) for d in gravity_directions]), each, axis=0)
    return Measurements(0.01 * np.arange(len(g)), g, *np.zeros((5, len(g), 3)))


def turning(axis, gravity=(0.0, 0.0, -1.0), swing=1.0, K=300):
    """Swings of `swing` rad about an axis (3,) through the sensor's origin; `gravity` in sensor axes at angle 0."""
    t = 0.01 * np.arange(K)
    n, angular = np.array(axis) / np.linalg.norm(axis), 2.0 * np.pi * 0.7
    angle, speed, acceleration = (
        swing * np.sin(angular * t),
        swing * angular * np.cos(angular * t),
        -swing * angular**2 * np.sin(angular * t),
    )
    g = Rotation.from_rotvec(-angle[:, None] * n).apply(G * np.array(gravity) / np.linalg.norm(gravity))
    return Measurements(t, g, np.zeros((K, 3)), speed[:, None] * n, acceleration[:, None] * n, *np.zeros((2, K, 3)))


def judged(motion, bias=False, force=0.05, torque=0.0025, seed=0, mass=1.0, size=SIZE):
    """Identifiability of a random body in `motion`, with noise in the wrench."""
    rng = np.random.default_rng(seed)
    z = with_wrench(motion, random_body(rng, mass), 0.0, rng, force, torque)
    return identifiability(z, fit_freely(z, bias), size)


def rotated(z, R):
    """The motion in sensor axes turned by R (3, 3)."""
    pose = np.eye(4)
    pose[:3, :3] = R
    return z.moved(pose)


# ranks


@pytest.mark.parametrize("seed", range(5))
def test_rank_is_that_of_all_samples_stacked(seed):
    rng = np.random.default_rng(seed)
    R = Rotation.random(rng=rng).as_matrix()
    motions = {
        "one pose": at_rest((0, 0, -1)),
        "two": at_rest((0, 0, -1), (1, 0, -1)),
        "vertical": turning((0, 0, 1)),
        "horizontal": turning((0, 1, 0)),
        "one sample": random_motion(rng, 1),
        "two samples": random_motion(rng, 2),
        "any": random_motion(rng, 50),
    }
    for motion in motions.values():
        for z in (motion, rotated(motion, R)):
            for model, regressor in (("full", full_regressor), ("reduced", reduced_regressor)):
                rows = regressor(z).reshape(-1, 10)[:, : 10 if model == "full" else 4]
                expected = np.linalg.matrix_rank(rows, tol=1e-9 * np.linalg.norm(rows, 2))
                assert rank(Moments.of(z), model) == expected
                assert rank(Blend.of(z, 0.3), model) == expected  # the samples are divided, not lost
    assert rank(Moments.of(motions["any"])) == 10
    assert rank(Moments.of(motions["one sample"])) <= 6


def test_rank_of_nothing():
    assert rank(Moments.empty()) == rank(Blend.empty(), "reduced") == 0
    with pytest.raises(InputError, match="unknown model"):
        rank(Moments.empty(), "blended")  # type: ignore[arg-type]


# condition numbers


def test_condition_number_of_all_samples_stacked():
    z = random_motion(np.random.default_rng(1), 40)
    rows = full_regressor(z).copy()
    rows[:, 3:] /= SIZE
    scaled = rows.reshape(-1, 10) * np.repeat((1.0, SIZE, SIZE**2), (1, 3, 6))
    assert condition_number(Moments.of(z), SIZE) == pytest.approx(np.linalg.cond(scaled), rel=1e-9)  # rounding
    reduced = scaled.reshape(-1, 6, 10)[:, :, :4] * 0.0
    reduced[:] = reduced_regressor(z)[:, :, :4] * (1.0, SIZE, SIZE, SIZE)
    reduced[:, 3:] /= SIZE
    expected = np.linalg.cond(reduced.reshape(-1, 4))
    assert condition_number(Moments.of(z), SIZE, "reduced") == pytest.approx(expected, rel=1e-9)


def test_condition_number_is_the_same_in_another_unit_of_length_and_frame():
    rng = np.random.default_rng(2)
    z = random_motion(rng, 40)
    value = condition_number(Moments.of(z), SIZE)
    millimetres = replace(z, gravity=1e3 * z.gravity, linear_acceleration=1e3 * z.linear_acceleration)
    assert condition_number(Moments.of(millimetres), 1e3 * SIZE) == pytest.approx(value, rel=1e-9)
    # turning the axes turns m c, and the tensor's six entries but for a factor of two of its products
    turned = condition_number(Moments.of(rotated(z, Rotation.random(rng=rng).as_matrix())), SIZE)
    assert value / 2 <= turned <= 2 * value


def test_condition_number_where_the_rank_is_short():
    assert condition_number(Moments.of(at_rest((0, 0, -1))), SIZE, "reduced") == np.inf
    assert condition_number(Moments.of(at_rest((0, 0, -1), (1, 0, 0))), SIZE) == np.inf
    assert np.isfinite(condition_number(Moments.of(at_rest((0, 0, -1), (1, 0, 0))), SIZE, "reduced"))
    for size in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="size of a body"):
            condition_number(Moments.empty(), size)


def test_condition_numbers_of_the_papers_motion():
    """Published: 147, 68.4, 58.0 at 1, 1.5, 2 rad/s; the docstring's figures, and that they fall as the paper's do."""
    figures = {0.15: (258.0, 106.0, 59.5), 0.2: (193.0, 79.3, 44.3)}
    for size, expected in figures.items():
        found = [
            condition_number(Moments.of(wield(UR5.motion(sinusoids(35.0, 100.0, speed)), hammer().parameters)), size)
            for speed in (1.0, 1.5, 2.0)
        ]
        np.testing.assert_allclose(found, expected, rtol=5e-3)  # three digits are given
        # the object is 0.2 m x 0.3 m: a radius of gyration between 0.1 and 0.2 m about a point of it
        assert all(0.5 < one / other < 2.0 for one, other in zip(found, (147.0, 68.4, 58.0), strict=True))


# reasons: gravity


def test_one_pose_leaves_the_com_along_the_vertical_open():
    found = judged(at_rest((0, 0, -1)))
    assert found.open["mcz"] == "COM z not observable: sensor z never left the vertical"
    assert not {"m", "mcx", "mcy"} & set(found.open)
    oblique = judged(at_rest((1, 0, 1)))
    for name in ("mcx", "mcz"):
        assert oblique.open[name] == "COM along (0.71, 0, 0.71) not observable: this direction never left the vertical"
    assert oblique.summary[0] == oblique.open["mcx"]  # said once
    assert "mcy" not in oblique.open
    for f in (found, oblique):
        assert {f.open[name] for name in INERTIA} == {
            f"{name} not observable: no angular acceleration in poses taken as static" for name in INERTIA
        }
        assert f.summary[-1].startswith("Jxx, Jxy, Jxz, Jyy, Jyz, Jzz not observable: ")


def test_one_pose_beside_a_bias_leaves_mass_and_com_open():
    found = judged(at_rest((0.3, 0.4, -1)), bias=True)
    reason = "gravity kept its direction in sensor axes, so a bias cannot be told from weight"
    assert found.open["m"] == f"mass not observable: {reason}"
    for axis in "xyz":
        assert found.open[f"mc{axis}"] == f"COM {axis} not observable: {reason}"
    assert found.summary[0] == f"mass, COM x, COM y, COM z not observable: {reason}"


def test_turning_about_the_vertical():
    found = judged(turning((0, 0, 1)))
    assert found.rank_reduced == 3
    assert found.open["mcz"] == "COM z not observable: sensor z never left the vertical"
    for name in ("Jxx", "Jxy", "Jyy"):
        assert found.open[name] == f"{name} not observable: no angular acceleration about x or y"
    assert set(found.open) == {"mcz", "Jxx", "Jxy", "Jyy"}


def test_a_small_tilt_is_said_in_degrees():
    tilt = np.radians(3.0)
    z = at_rest(*((np.sin(tilt) * np.cos(a), np.sin(tilt) * np.sin(a), -np.cos(tilt)) for a in np.arange(4)))
    found = judged(z, torque=0.5)  # std of COM z 0.5 Nm / (80^1/2 9.8 N sin 3°) = 0.1 m
    assert found.open["mcz"] == "COM z not observable: sensor z stayed within about 3° of the vertical"
    assert "mcx" not in found.open
    assert "mcz" not in judged(z).open  # less noise makes up for it


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_a_small_turn_beside_a_bias(degrees):
    tilt = np.radians(degrees)
    z = at_rest(
        *((np.sin(tilt) * np.cos(a), np.sin(tilt) * np.sin(a), -np.cos(tilt)) for a in np.arange(0.0, 6.28, 1.57))
    )
    assert "m" not in judged(z, bias=True).open
    found = judged(z, bias=True, force=1.5 * degrees, torque=0.5 * degrees)
    for name in ("m", "mcx"):
        assert found.open[name].endswith(
            f"gravity turned by only about {degrees:g}° in sensor axes, so a bias can hardly be told from weight"
        )


def test_two_poses_beside_a_bias_leave_one_direction_open():
    found = judged(at_rest((0.5, 0, -1), (-0.5, 0, -1)), bias=True)
    assert found.open["mcx"] == (
        "COM x not observable: gravity in sensor axes changed along x only, and a constant torque may be bias"
    )
    assert not {"m", "mcy", "mcz"} & set(found.open)
    assert "mcx" not in judged(at_rest((0.5, 0, -1), (-0.5, 0, -1))).open
    along = judged(at_rest((1, 0, 0), (0, 1, 0)), bias=True)
    for name in ("mcx", "mcy"):
        assert re.match(r"COM along \((-0.71, 0.71|0.71, -0.71), 0\) .* changed along", along.open[name])


def test_without_gravity():
    z = replace(at_rest((0, 0, -1)), gravity=np.zeros((20, 3)), linear_acceleration=np.tile((0, 0, 1.0), (20, 1)))
    found = judged(z)
    assert found.open["mcz"].endswith("without gravity only acceleration shows it, and there was too little")


# reasons: inertia


@pytest.mark.parametrize("axis", "xyz")
def test_one_axis_of_rotation_shows_three_entries(axis):
    found = judged(turning(np.eye(3)["xyz".index(axis)], gravity=(1, 1, 1)))
    others = [a for a in "xyz" if a != axis]
    assert set(found.open) == {name for name in INERTIA if axis not in name}
    for name, sentence in found.open.items():
        assert sentence == f"{name} not observable: no angular acceleration about {others[0]} or {others[1]}"


def test_an_oblique_axis_of_rotation():
    found = judged(turning((1, 0, 1), gravity=(1, 2, 3)))
    assert set(found.open) == set(INERTIA)  # each is seen in sums with others only
    for name, sentence in found.open.items():
        assert sentence == f"{name} not observable: angular acceleration about (0.71, 0, 0.71) only"


def test_a_direction_without_angular_acceleration():
    rng = np.random.default_rng(3)
    z = random_motion(rng, 200)
    for direction, name, missing in (((0, 1, 0), "y", {"Jyy"}), ((1, 1, 1), "(0.58, 0.58, 0.58)", set(INERTIA))):
        v = np.array(direction) / np.linalg.norm(direction)
        across = np.eye(3) - np.outer(v, v)
        planar = replace(
            z, angular_velocity=z.angular_velocity @ across, angular_acceleration=z.angular_acceleration @ across
        )
        found = judged(planar)
        assert set(found.open) == missing
        for entry, sentence in found.open.items():
            assert sentence == f"{entry} not observable: no angular acceleration about {name}"


def test_noise_is_said_with_its_size():
    """The factor is that of the standard deviation by the normal equations of all samples, noise level as fitted."""
    rng = np.random.default_rng(4)
    z = with_wrench(random_motion(rng, 200, 0.1), random_body(rng), 0.0, rng, 0.05, 0.05)
    fit = fit_freely(z, False)
    found = identifiability(z, fit, SIZE)
    assert set(found.open) == set(INERTIA)
    rows = full_regressor(z) / np.repeat((fit.noise.force, fit.noise.torque), 3)[:, None]
    rows = rows.reshape(-1, 10)
    std = np.sqrt(np.linalg.inv(rows.T @ rows).diagonal() * fit.autocorrelation)
    for name, about in zip(INERTIA, ("x", "x or y", "x or z", "y", "y or z", "z"), strict=True):
        excess = std[PARAMETERS.index(name)] / (fit.vector[0] * SIZE**2 / 12)
        assert found.open[name] == (
            f"{name} is lost in the noise: its standard deviation is {excess:.2g} times what a body of 0.2 m would "
            f"have; turn faster or longer about {about}"
        )
    assert found.summary == (
        f"Jxx, Jxy, Jxz, Jyy, Jyz, Jzz are lost in the noise: the largest standard deviation is "
        f"{max(std[4:]) / (fit.vector[0] * SIZE**2 / 12):.2g} times what a body of 0.2 m would have; turn faster or "
        "longer about x, y and z",
    )
    # as it says: as many times faster or longer does it
    assert not judged(random_motion(rng, 200, 1.0), torque=0.05).open


def test_com_lost_in_noise():
    z = at_rest((0, 0, -1), (0.5, 0, -1), (0, 0.5, -1), each=5)
    found = judged(z, torque=8.0)
    assert re.fullmatch(
        r"COM z is lost in the noise: its standard deviation is \d[\d.]* times half of 0.2 m; turn sensor z further "
        r"from the vertical, or record longer",
        found.open["mcz"],
    )


def test_accelerations_within_their_known_noise_are_none():
    """A sensor at rest whose angular acceleration is nothing but noise of a level that is known."""
    rng = np.random.default_rng(5)
    still = at_rest((0, 0, -1), (1, 0, 0), (0, 1, 0))
    noise = Noise(0.05, 0.0025, 0.0, 0.05)
    z = with_wrench(still, random_body(rng), 0.0, rng, 0.05, 0.02)
    z = replace(z, angular_acceleration=0.05 * rng.normal(size=(60, 3)), noise=noise)
    found = identifiability(z, fit_freely(z, False), SIZE)
    for name in INERTIA:
        assert found.open[name] == f"{name} not observable: no angular acceleration about any axis"


def test_nothing_in_hand():
    rng = np.random.default_rng(6)
    z = random_motion(rng, 60)
    z = replace(z, force=0.1 * rng.normal(size=(60, 3)), torque=0.005 * rng.normal(size=(60, 3)))
    found = identifiability(z, fit_freely(z, False), SIZE)
    assert set(found.open) == set(PARAMETERS)
    assert re.match(r"mass is lost in the noise: .* of the 0\.0\d+ kg found; is anything held\?", found.open["m"])
    assert found.open["mcx"] == "COM x not observable: the mass itself is not known"
    assert found.open["Jyz"] == "Jyz not observable: the mass itself is not known"
    nothing = replace(z, force=np.zeros((60, 3)), torque=np.zeros((60, 3)))
    assert set(identifiability(nothing, fit_freely(nothing, True), SIZE).open) == set(PARAMETERS)


def test_few_moving_samples():
    """Six equations each, for ten unknowns and, beside a bias, six more."""
    rng = np.random.default_rng(7)
    found = judged(random_motion(rng, 1))
    assert found.rank_full == 6
    assert found.condition_full == np.inf
    assert found.open["m"] == "mass not observable: in 1 sample other parameters explain the wrench as well"
    found = judged(random_motion(rng, 2), bias=True)
    assert found.open["m"] == "mass not observable: in 2 samples other parameters or a bias explain the wrench as well"


# laws


@pytest.mark.parametrize("seed", range(8))
def test_reasons_turn_with_the_sensor(seed):
    """In any sensor axes the vertical and the one axis of rotation are named as they lie there."""
    rng = np.random.default_rng([8, seed])
    R = Rotation.random(rng=rng).as_matrix()
    found = judged(rotated(turning((0, 0, 1)), R), seed=seed)
    axis = R[:, 2] * np.sign(R[np.argmax(np.abs(R[:, 2])), 2])
    name = ", ".join(f"{round(x, 2) + 0.0:g}" for x in axis)
    assert np.abs(axis).max() < 0.995, "choose another seed: this one is nearly an axis"
    assert found.rank_reduced == 3
    for entry in ("mcx", "mcy", "mcz"):
        sentence = f"COM along ({name}) not observable: this direction never left the vertical"
        assert entry not in found.open or found.open[entry] == sentence
    assert any(entry in found.open for entry in ("mcx", "mcy", "mcz"))
    for entry in INERTIA:
        sentence = f"{entry} not observable: angular acceleration about ({name}) only"
        assert entry not in found.open or found.open[entry] == sentence
    assert any(entry in found.open for entry in INERTIA)


@pytest.mark.parametrize("bias", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_good_motion_leaves_nothing_open(seed, bias):
    rng = np.random.default_rng([9, seed])
    found = judged(random_motion(rng, 300, 1.0), bias, seed=seed)
    assert found.open == {}
    assert found.summary == ()
    assert (found.rank_full, found.rank_reduced) == (10, 4)
    assert found.condition_reduced < 5.0 < found.condition_full < 500.0


@pytest.mark.parametrize("bias", [False, True])
def test_open_are_those_of_the_fit(bias):
    """Whatever the motion: each has a sentence, which names it or the direction it lies along."""
    for seed in range(40):
        rng = np.random.default_rng([10, seed])
        z = random_motion(rng, int(rng.choice([1, 2, 5, 50])), 10 ** rng.uniform(-4, 1))
        if rng.random() < 0.5:
            z = replace(z, gravity=z.gravity[:1] + 10 ** rng.uniform(-4, 0) * (z.gravity - z.gravity[:1]))
        z = with_wrench(z, random_body(rng), 0.0, rng, *(10 ** rng.uniform(-4, 0, 2)))
        fit = fit_freely(z, bias)
        found = identifiability(z, fit, SIZE)
        assert tuple(found.open) == fit.open_parameters(SIZE)
        assert len(found.summary) <= len(found.open)
        for name, sentence in found.open.items():
            assert sentence.startswith({"m": "mass ", "mc": "COM "}.get(name[:2], f"{name} "))
        json.dumps(found.to_dict(), allow_nan=False)


def test_to_dict():
    data = judged(at_rest((0, 0, -1))).to_dict()
    assert list(data) == ["rank_full", "rank_reduced", "condition_full", "condition_reduced", "open"]
    assert (data["rank_full"], data["rank_reduced"]) == (3, 3)
    assert data["condition_full"] is data["condition_reduced"] is None
    assert data["open"]["mcz"] == "COM z not observable: sensor z never left the vertical"


# inspection


def printed(found) -> str:
    page = io.StringIO()
    Console(width=300, file=page).print(inspection_report(found))
    return page.getvalue()


def test_inspection_of_a_good_recording():
    log = simulate(UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=1)), hammer().parameters, noise=Noise(0.05, 0.0025))
    found = inspect(log)
    assert found.undetermined == ()
    assert found.to_dict()["identifiability"] == found.identifiability.to_dict()
    assert found.to_dict()["undetermined"] == []
    text = printed(found)
    assert (
        f"rank 10 of 10, condition number {found.identifiability.condition_full:.3g}; by gravity alone 4 of 4" in text
    )
    assert "all ten determined" in text
    assert "ready" in found.advice[0]


def test_inspection_says_why():
    """Static poses that turn about the vertical only."""
    rng = np.random.default_rng(11)
    turns = Rotation.from_euler("z", np.linspace(0.0, 3.0, 12)[:, None])
    wrench = np.tile((0.0, 0.0, 10.0, 0.5, -0.2, 0.0), (12, 1)) + np.repeat((0.05, 0.0025), 3) * rng.normal(
        size=(12, 6)
    )
    time = np.arange(12.0)
    streams = {"orientation": Stream(time, turns.as_quat()), "wrench": Stream(time, wrench)}
    found = inspect(Recording(streams, static=True, source="poses"))
    assert "COM z not observable: sensor z never left the vertical" in found.advice
    assert found.advice[0].startswith("record other orientations")
    assert found.to_dict()["identifiability"]["rank_reduced"] == 3
    assert found.to_dict()["undetermined"] == list(found.identifiability.open)
    text = printed(found)
    assert "rank 3 of 10, condition number inf; by gravity alone 3 of 4, inf" in text
    assert "next: COM z not observable: sensor z never left the vertical" in text
    assert "not determined by the motion: mcz, Jxx" in text


# the paper's appendix: observability of the reduced model (Nadeau et al. 2022, appendix A), with its force rows


def point_matrix(points):
    """(4, n) of 1 and the coordinates: masses to m and m c."""
    return np.vstack((np.ones(len(points)), points.T))


@pytest.mark.parametrize("seed", range(5))
def test_rank_of_the_reduced_model(seed):
    """4 once gravity takes two directions that are not parallel; 3 for one pose, or turning about the vertical.

    In sensor axes about the sensor's origin the force rows see m, and the torque rows m c across gravity.
    """
    rng = np.random.default_rng([12, seed])
    one, other = rng.normal(size=(2, 3))
    assert rank(Moments.of(at_rest(one)), "reduced") == 3
    assert rank(Moments.of(at_rest(one, -one, 2.0 * one)), "reduced") == 3
    assert rank(Moments.of(at_rest(one, other)), "reduced") == 4
    assert rank(Moments.of(at_rest(one, other, *rng.normal(size=(9, 3)))), "reduced") == 4
    R = Rotation.random(rng=rng).as_matrix()
    assert rank(Moments.of(rotated(turning((0, 0, 1)), R)), "reduced") == 3
    assert rank(Moments.of(rotated(turning((0, 1, 0)), R)), "reduced") == 4
    torques = reduced_regressor(at_rest(one, other))[:, 3:, :4].reshape(-1, 4)
    assert np.linalg.matrix_rank(torques) == 3  # which say nothing of the mass


@pytest.mark.parametrize("seed", range(5))
def test_the_kernel_in_point_masses_keeps_mass_and_com(seed):
    """Of n points the reduced model leaves n - 4 directions open; none changes sum m or sum m p, and they are all."""
    rng = np.random.default_rng([13, seed])
    n = int(rng.integers(8, 60))
    points = 0.1 * rng.normal(size=(n, 3)) + 0.2 * rng.normal(size=3)
    z = at_rest(*rng.normal(size=(5, 3)))
    AM = reduced_regressor(z).reshape(-1, 10) @ PointMasses(points).matrix
    kernel = null_space(AM)
    assert kernel.shape == (n, n - 4)
    np.testing.assert_allclose(point_matrix(points) @ kernel, 0.0, atol=1e-12)  # rounding of unit vectors
    masses = rng.exponential(size=n)
    changed = masses + kernel @ rng.normal(size=n - 4)
    assert np.linalg.norm(changed - masses) > 1.0
    body, other = (InertialParameters.from_points(points, m) for m in (masses, changed))
    np.testing.assert_allclose(other.vector[:4], body.vector[:4], atol=1e-12)
    assert np.abs(other.vector[4:] - body.vector[4:]).max() > 1e-4  # but the inertia is not kept
    np.testing.assert_allclose(AM @ null_space(point_matrix(points)), 0.0, atol=1e-11)
    short = null_space(reduced_regressor(at_rest((0, 0, -1))).reshape(-1, 10) @ PointMasses(points).matrix)
    assert short.shape == (n, n - 3)  # of one pose the kernel moves the COM up and down
    moved = point_matrix(points) @ short
    np.testing.assert_allclose(moved[:3], 0.0, atol=1e-12)
    assert np.abs(moved[3]).max() > 0.01


def reduced_problem(seed, regularization):
    """PMD on the reduced model alone, static poses, noise, more points than data can tell apart."""
    rng = np.random.default_rng([14, seed])
    points = rng.uniform(-0.1, 0.1, (30, 3)) + np.array((0.0, 0.0, 0.1))
    body = InertialParameters.from_points(points, rng.exponential(size=30) / 30)
    z = with_wrench(at_rest(*rng.normal(size=(6, 3)), each=3), body, 0.0, rng, 0.1, 0.01)
    pmd = PMD(PointMasses(points), regularization=regularization, model="reduced")
    return pmd, pmd.update(pmd.start(), z), z, rng


@pytest.mark.parametrize("regularization", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("seed", range(3))
def test_any_regularization_makes_the_solution_unique(seed, regularization):
    """Two starts at the shape's opposite ends lead to the same masses.

    Between any two masses of lengths at most L, |m| at the middle is (|d|² - e²) / 8 L or more below its mean, d their
    difference and e that of their lengths: so |d|² <= e² + 8 L (mean objective - lower bound) / lambda.
    """
    pmd, state, z, _ = reduced_problem(seed, regularization)
    points = pmd.shape.positions
    ends = []
    for index in (np.argmin(points[:, 0]), np.argmax(points[:, 0])):
        masses = np.full(30, 1e-6)
        masses[index] = 5.0
        start = Estimate("PMD", InertialParameters.from_points(points, masses), 1, point_masses=masses)
        ends.append(pmd.estimate(state, start=start))
    one, other = (e.point_masses for e in ends)
    lengths = np.linalg.norm(one), np.linalg.norm(other)
    objectives = np.array([e.certificate.objective for e in ends])
    slack = objectives.mean() - max(e.certificate.bound for e in ends)
    bound = (lengths[0] - lengths[1]) ** 2 + 8.0 * max(lengths) * max(slack, 0.0) / regularization
    difference = np.linalg.norm(one - other)
    assert difference**2 <= bound + 1e-20
    # the starts are 7 kg apart; the law leaves 5e-4 of the length at gaps of 5e-12 to 2e-7 N
    assert difference < 1e-3 * max(lengths)
    AM = reduced_regressor(z).reshape(-1, 10) @ pmd.shape.matrix
    plain = np.linalg.eigvalsh(AM.T @ AM)
    assert np.sum(plain > 1e-9 * plain[-1]) == 4  # semidefinite
    curved = np.linalg.eigvalsh(AM.T @ AM + regularization * np.eye(30))
    assert curved[0] >= 0.99 * regularization  # rounding: 1e-13 of the largest


@pytest.mark.parametrize("seed", range(3))
def test_without_regularization_the_solution_is_not_unique(seed):
    """Two non-negative masses far apart with one objective, which is the optimum: PMD's own and another corner."""
    pmd, state, z, rng = reduced_problem(seed, 0.0)
    found = pmd.estimate(state)
    P = point_matrix(pmd.shape.positions)
    corner = linprog(rng.normal(size=30), A_eq=P, b_eq=P @ found.point_masses, bounds=(0, None), method="highs").x
    A, b = reduced_regressor(z).reshape(-1, 10), z.wrench.ravel()
    objectives = [np.linalg.norm(A @ pmd.shape.matrix @ m - b) for m in (found.point_masses, corner)]
    assert np.linalg.norm(corner - found.point_masses) > 0.1 * found.parameters.mass
    assert corner.min() >= 0.0
    assert objectives[1] == pytest.approx(objectives[0], rel=1e-7)  # the linear program's tolerance
    assert found.certificate.gap <= 1e-5 * objectives[0]
