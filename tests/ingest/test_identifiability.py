"""What a motion leaves open: the reasons given, and that they are those of the fit in
any sensor axes."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.measurements import Noise
from hefting.core.regressor import full_regressor
from hefting.core.spatial import PARAMETERS
from hefting.ingest.free_fit import fit_freely
from hefting.ingest.identifiability import identifiability
from random_problems import random_body, random_motion, with_wrench
from restricted_motions import INERTIA, SIZE, at_rest, judged, rotated, turning

# reasons: gravity


def test_one_pose_leaves_the_com_along_the_vertical_open():
    found = judged(at_rest((0, 0, -1)))
    assert found.open["mcz"] == "COM z not observable: sensor z never left the vertical"
    assert not {"m", "mcx", "mcy"} & set(found.open)
    oblique = judged(at_rest((1, 0, 1)))
    for name in ("mcx", "mcz"):
        assert (
            oblique.open[name]
            == "COM along (0.71, 0, 0.71) not observable: this direction never left the vertical"
        )
    assert oblique.summary[0] == oblique.open["mcx"]  # said once
    assert "mcy" not in oblique.open
    for f in (found, oblique):
        assert {f.open[name] for name in INERTIA} == {
            f"{name} not observable: no angular acceleration in poses taken as static"
            for name in INERTIA
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
        assert (
            found.open[name]
            == f"{name} not observable: no angular acceleration about x or y"
        )
    assert set(found.open) == {"mcz", "Jxx", "Jxy", "Jyy"}


def test_a_small_tilt_is_said_in_degrees():
    tilt = np.radians(3.0)
    z = at_rest(
        *(
            (np.sin(tilt) * np.cos(a), np.sin(tilt) * np.sin(a), -np.cos(tilt))
            for a in np.arange(4)
        )
    )
    found = judged(z, torque=0.5)  # std of COM z 0.5 Nm / (80^1/2 9.8 N sin 3°) = 0.1 m
    assert (
        found.open["mcz"]
        == "COM z not observable: sensor z stayed within about 3° of the vertical"
    )
    assert "mcx" not in found.open
    assert "mcz" not in judged(z).open  # less noise makes up for it


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_a_small_turn_beside_a_bias(degrees):
    tilt = np.radians(degrees)
    z = at_rest(
        *(
            (np.sin(tilt) * np.cos(a), np.sin(tilt) * np.sin(a), -np.cos(tilt))
            for a in np.arange(0.0, 6.28, 1.57)
        )
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
        assert re.match(
            r"COM along \((-0.71, 0.71|0.71, -0.71), 0\) .* changed along",
            along.open[name],
        )


def test_without_gravity():
    z = replace(
        at_rest((0, 0, -1)),
        gravity=np.zeros((20, 3)),
        linear_acceleration=np.tile((0, 0, 1.0), (20, 1)),
    )
    found = judged(z)
    assert found.open["mcz"].endswith(
        "without gravity only acceleration shows it, and there was too little"
    )


# reasons: inertia


@pytest.mark.parametrize("axis", "xyz")
def test_one_axis_of_rotation_shows_three_entries(axis):
    found = judged(turning(np.eye(3)["xyz".index(axis)], gravity=(1, 1, 1)))
    others = [a for a in "xyz" if a != axis]
    assert set(found.open) == {name for name in INERTIA if axis not in name}
    for name, sentence in found.open.items():
        assert (
            sentence
            == f"{name} not observable: no angular acceleration about {others[0]} or {others[1]}"
        )


def test_an_oblique_axis_of_rotation():
    found = judged(turning((1, 0, 1), gravity=(1, 2, 3)))
    assert set(found.open) == set(INERTIA)  # each is seen in sums with others only
    for name, sentence in found.open.items():
        assert (
            sentence
            == f"{name} not observable: angular acceleration about (0.71, 0, 0.71) only"
        )


def test_a_direction_without_angular_acceleration():
    rng = np.random.default_rng(3)
    z = random_motion(rng, 200)
    for direction, name, missing in (
        ((0, 1, 0), "y", {"Jyy"}),
        ((1, 1, 1), "(0.58, 0.58, 0.58)", set(INERTIA)),
    ):
        v = np.array(direction) / np.linalg.norm(direction)
        across = np.eye(3) - np.outer(v, v)
        planar = replace(
            z,
            angular_velocity=z.angular_velocity @ across,
            angular_acceleration=z.angular_acceleration @ across,
        )
        found = judged(planar)
        assert set(found.open) == missing
        for entry, sentence in found.open.items():
            assert (
                sentence
                == f"{entry} not observable: no angular acceleration about {name}"
            )


def test_noise_is_said_with_its_size():
    """The factor is that of the standard deviation by the normal equations of all
    samples, noise level as fitted."""
    rng = np.random.default_rng(4)
    z = with_wrench(
        random_motion(rng, 200, 0.1), random_body(rng), 0.0, rng, 0.05, 0.05
    )
    fit = fit_freely(z, False)
    found = identifiability(z, fit, SIZE)
    assert set(found.open) == set(INERTIA)
    rows = (
        full_regressor(z) / np.repeat((fit.noise.force, fit.noise.torque), 3)[:, None]
    )
    rows = rows.reshape(-1, 10)
    std = np.sqrt(np.linalg.inv(rows.T @ rows).diagonal() * fit.autocorrelation)
    for name, about in zip(
        INERTIA, ("x", "x or y", "x or z", "y", "y or z", "z"), strict=True
    ):
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
    """A sensor at rest whose angular acceleration is nothing but noise of a level that
    is known."""
    rng = np.random.default_rng(5)
    still = at_rest((0, 0, -1), (1, 0, 0), (0, 1, 0))
    noise = Noise(0.05, 0.0025, 0.0, 0.05)
    z = with_wrench(still, random_body(rng), 0.0, rng, 0.05, 0.02)
    z = replace(z, angular_acceleration=0.05 * rng.normal(size=(60, 3)), noise=noise)
    found = identifiability(z, fit_freely(z, False), SIZE)
    for name in INERTIA:
        assert (
            found.open[name]
            == f"{name} not observable: no angular acceleration about any axis"
        )


def test_nothing_in_hand():
    rng = np.random.default_rng(6)
    z = random_motion(rng, 60)
    z = replace(
        z, force=0.1 * rng.normal(size=(60, 3)), torque=0.005 * rng.normal(size=(60, 3))
    )
    found = identifiability(z, fit_freely(z, False), SIZE)
    assert set(found.open) == set(PARAMETERS)
    assert re.match(
        r"mass is lost in the noise: .* of the 0\.0\d+ kg found; is anything held\?",
        found.open["m"],
    )
    assert found.open["mcx"] == "COM x not observable: the mass itself is not known"
    assert found.open["Jyz"] == "Jyz not observable: the mass itself is not known"
    nothing = replace(z, force=np.zeros((60, 3)), torque=np.zeros((60, 3)))
    assert set(identifiability(nothing, fit_freely(nothing, True), SIZE).open) == set(
        PARAMETERS
    )


def test_few_moving_samples():
    """Six equations each, for ten unknowns and, beside a bias, six more."""
    rng = np.random.default_rng(7)
    found = judged(random_motion(rng, 1))
    assert found.rank_full == 6
    assert found.condition_full == np.inf
    assert (
        found.open["m"]
        == "mass not observable: in 1 sample other parameters explain the wrench as well"
    )
    found = judged(random_motion(rng, 2), bias=True)
    assert (
        found.open["m"]
        == "mass not observable: in 2 samples other parameters or a bias explain the wrench as well"
    )


# laws


@pytest.mark.parametrize("seed", range(8))
def test_reasons_turn_with_the_sensor(seed):
    """In any sensor axes the vertical and the one axis of rotation are named as they
    lie there."""
    rng = np.random.default_rng([8, seed])
    R = Rotation.random(rng=rng).as_matrix()
    found = judged(rotated(turning((0, 0, 1)), R), seed=seed)
    axis = R[:, 2] * np.sign(R[np.argmax(np.abs(R[:, 2])), 2])
    name = ", ".join(f"{round(x, 2) + 0.0:g}" for x in axis)
    assert np.abs(axis).max() < 0.995, "choose another seed: this one is nearly an axis"
    assert found.rank_reduced == 3
    for entry in ("mcx", "mcy", "mcz"):
        sentence = (
            f"COM along ({name}) not observable: this direction never left the vertical"
        )
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
    """Whatever the motion: each has a sentence, which names it or the direction it lies
    along."""
    for seed in range(40):
        rng = np.random.default_rng([10, seed])
        z = random_motion(rng, int(rng.choice([1, 2, 5, 50])), 10 ** rng.uniform(-4, 1))
        if rng.random() < 0.5:
            z = replace(
                z,
                gravity=z.gravity[:1]
                + 10 ** rng.uniform(-4, 0) * (z.gravity - z.gravity[:1]),
            )
        z = with_wrench(z, random_body(rng), 0.0, rng, *(10 ** rng.uniform(-4, 0, 2)))
        fit = fit_freely(z, bias)
        found = identifiability(z, fit, SIZE)
        assert tuple(found.open) == fit.open_parameters(SIZE)
        assert len(found.summary) <= len(found.open)
        for name, sentence in found.open.items():
            assert sentence.startswith(
                {"m": "mass ", "mc": "COM "}.get(name[:2], f"{name} ")
            )
        json.dumps(found.to_dict(), allow_nan=False)


def test_to_dict():
    data = judged(at_rest((0, 0, -1))).to_dict()
    assert list(data) == [
        "rank_full",
        "rank_reduced",
        "condition_full",
        "condition_reduced",
        "open",
    ]
    assert (data["rank_full"], data["rank_reduced"]) == (3, 3)
    assert data["condition_full"] is data["condition_reduced"] is None
    assert (
        data["open"]["mcz"] == "COM z not observable: sensor z never left the vertical"
    )
