"""Conditioning: it finds what was done to a recording, whatever its begin, sign and world,
and what is known of real ones."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from conditioned import CLEAN, condition
from disturbances import GRAVITY, NOISE, disturbed, with_wrench
from hefting.core.recording import Stream
from hefting.core.spatial import angle_between
from hefting.logs import read_log
from hefting.motion import measure
from recordings import DATA, TOOL_FOLDERS, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.fixture(scope="module")
def late():
    d = disturbed("all", 1.5, 1)
    return d, condition(d.recording, tilt=True)


def test_it_finds_what_was_done(late):
    d, found = late
    assert abs(found.offset - d.offset) < 1e-3
    assert not found.sign.on_object
    assert found.sign.certain
    angle = np.arccos(found.gravity @ d.gravity / (GRAVITY @ GRAVITY))
    assert angle < np.radians(0.3)
    assert found.bias.kind == "linear"
    assert np.mean(found.rejected[d.bad]) > 0.97
    assert np.mean(found.rejected[~d.bad]) < 0.2
    assert found.reasons["contact"] > 200
    assert found.reasons["spike"] > 20
    assert found.noise.force == pytest.approx(NOISE.force, rel=0.2)
    assert found.noise.torque == pytest.approx(NOISE.torque, rel=0.2)
    said = " ".join(found.findings)
    for word in ("late", "on-sensor", "drifts", "gravity", "contact", "spikes"):
        assert word in said


def test_corrected_is_what_was_found(late):
    d, found = late
    wrench, corrected = d.recording["wrench"], found.corrected(d.recording)["wrench"]
    kept = ~found.rejected
    np.testing.assert_allclose(corrected.time, wrench.time[kept] - found.offset)
    drift = found.bias(wrench.time) - found.bias.mean
    np.testing.assert_allclose(corrected.values, (wrench.values - drift)[kept])
    np.testing.assert_array_equal(corrected.rows, wrench.rows[kept])
    assert found.corrected(d.recording)["position"] is d.recording["position"]


def test_shifts_signs_and_biases_pass_through():
    """The wrench 50 ms later, of the other sign, and with another bias: the same
    object, all else moved along."""
    d = disturbed("clean", 1.5, 2)
    time = d.recording["wrench"].time
    values = d.recording["wrench"].values
    bias = np.array((7, -3, 2, 0.1, 0.2, -0.3))
    one = condition(with_wrench(d.recording, time + 0.03, values))
    other = condition(with_wrench(d.recording, time + 0.08, bias - values))
    # five samples fewer, of a thousand
    assert other.offset - one.offset == pytest.approx(0.05, abs=one.offset_std)
    assert one.sign.on_object
    assert not other.sign.on_object
    assert np.all(np.abs(other.parameters - one.parameters) < one.std)
    np.testing.assert_allclose(other.bias.mean, bias - one.bias.mean, atol=0.05)


@pytest.mark.parametrize("late", [0.5, -0.7])
def test_an_offset_may_be_large(late):
    wrench = CLEAN["wrench"]
    found = condition(with_wrench(CLEAN, wrench.time + late, wrench.values))
    assert found.offset == pytest.approx(late, abs=1e-3)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)


def test_time_begins_anywhere():
    d = disturbed("offset", 1.5, 3)
    moved = replace(
        d.recording,
        streams={
            n: Stream(s.time + 5e8, s.values) for n, s in d.recording.streams.items()
        },
    )
    one, other = condition(d.recording), condition(moved)
    # such times are known to 0.1 µs
    assert other.offset == pytest.approx(one.offset, abs=1e-5)
    np.testing.assert_allclose(
        other.parameters, one.parameters, atol=1e-3 * one.parameters[0]
    )


@pytest.mark.parametrize(
    ("kind", "degrees"), [("clean", 0.0), ("contact", 0.0), ("tilt", 15.0)]
)
def test_gravity_is_estimated_for_information(kind, degrees):
    """What touches the object is left out, and the rest explained."""
    recording = disturbed(kind, 1.5, 1).recording
    assert condition(recording).tilted is None
    found = condition(recording, hint=True)
    assert (found.rejected.mean() > 0.1) == (kind == "contact")
    assert found.tilted is not None
    # a thousand samples of 0.1 N, at 15 N: a hundredth of a degree, and the poses'
    # errors
    angle = angle_between(np.array(GRAVITY), found.tilted.gravity)
    assert np.degrees(angle) == pytest.approx(degrees, abs=0.1)


TURNED_WORLDS = [
    (90.0, 0.0, 0.0),
    (-90.0, 0.0, 0.0),
    (0.0, 180.0, 0.0),
    (78.0, 104.0, 0.0),
]


@pytest.mark.parametrize("degrees", TURNED_WORLDS)
def test_gravity_is_found_however_the_world_is_turned(degrees):
    """From the default, 90, 180 and 130° off: the opposite direction with the other sign
    of the wrench differs by what accelerations show alone."""
    recording = disturbed("clean", 1.5, 1).recording
    turn = Rotation.from_rotvec(np.radians(degrees))
    q = (turn * Rotation.from_quat(np.array(recording["orientation"].values))).as_quat()
    p = turn.apply(np.array(recording["position"].values))
    streams = {
        **recording.streams,
        "orientation": replace(recording["orientation"], values=q),
        "position": replace(recording["position"], values=p),
    }
    found = condition(replace(recording, streams=streams), tilt=True)
    right = condition(recording, tilt=True)
    # of some tenth of a degree by noise; both start and end elsewhere within it
    np.testing.assert_allclose(
        found.gravity, turn.apply(np.array(right.gravity)), atol=0.01
    )
    assert found.parameters[0] == pytest.approx(right.parameters[0], rel=1e-3)
    assert found.sign.on_object == right.sign.on_object


def test_outliers_of_a_long_recording_are_those_of_all_its_samples(monkeypatch):
    monkeypatch.setattr(
        import_module("hefting.ingest.condition"), "MOST_FITTED_SAMPLES", 800
    )
    monkeypatch.setattr(
        import_module("hefting.ingest.condition"), "MOST_FITTED_BLOCKS", 400
    )
    d = disturbed("contact", 1.5, 0)
    found = condition(d.recording)
    assert len(found.rejected) == len(d.bad)
    assert np.mean(found.rejected[d.bad]) > 0.9
    assert np.mean(found.rejected[~d.bad]) < 0.2
    assert found.parameters[0] == pytest.approx(1.5, rel=0.01)


@needs_recordings
def test_exact_logs_of_tools_are_left_alone():
    for folder in TOOL_FOLDERS[:4]:
        recording = read_log(folder / "log.csv")
        found = condition(recording, (0.0, 0.0, 9.81))
        assert found.corrected(recording) is recording, folder.name


@needs_recordings
@pytest.mark.parametrize(
    ("log", "g", "offset", "within", "mass"),
    [
        ("panda-optoforce/run1", 9.81, 0.017, 0.001, (1.09, 1.17)),
        ("panda-optoforce/run3", 9.81, 0.017, 0.001, (1.09, 1.17)),
        ("kuka-ati/baseline", 9.82085, -0.0066, 0.0005, (0.9323 * 0.99, 0.9323 * 1.01)),
        (
            "kuka-ati/vibrations",
            9.82085,
            -0.0064,
            0.0005,
            (0.9323 * 0.98, 0.9323 * 1.02),
        ),
        ("axia80/dwells", 9.80665, 0.513, 0.010, (1.14, 1.18)),
        ("kuka-ati/static_poses", 9.82085, 0.0, 0.0, (0.929, 0.936)),
        ("axia80/poses7", 9.80665, 0.0, 0.0, (1.09, 1.11)),
    ],
)
def test_real_recordings(log, g, offset, within, mass):
    recording = read_log(DATA / f"{log}.csv")
    found = condition(recording, (0.0, 0.0, -g))
    print(f"{log}: {1e3 * found.offset:.2f} ms, {found.parameters[0]:.4f} kg")
    assert found.offset == pytest.approx(offset, abs=within)
    assert mass[0] <= found.parameters[0] <= mass[1]
    assert found.sign.certain
    assert found.sign.on_object == log.startswith("panda")
    assert len(
        measure(found.corrected(recording), found.gravity).measurements
    ) > 0.9 * len(recording["wrench"])


@pytest.mark.parametrize("mass", [0.5, 1.5, 5.0])
def test_the_noise_of_the_wrench_is_told_from_that_of_the_motion(mass):
    """The same noise of wrench and poses, whatever the mass: of 5 kg the errors of the
    motion are a third of the force's residuals and half of the torque's. White
    residuals count as such."""
    found = condition(disturbed("clean", mass, 0, duration=6.0).recording, GRAVITY)
    assert found.noise.force == pytest.approx(NOISE.force, rel=0.1)
    assert found.noise.torque == pytest.approx(NOISE.torque, rel=0.25)
    assert 0.4 < found.autocorrelation < 1.5  # smoothed motion takes some of it
