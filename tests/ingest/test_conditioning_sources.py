"""Conditioning of motion from other sources than whole poses: columns, orientations alone,
an accelerometer, and static poses."""

from dataclasses import replace

import numpy as np
import pytest

from conditioned import CLEAN, condition, exact_recording
from disturbances import NOISE, body, with_wrench
from hefting.core.recording import Recording, Stream
from hefting.motion import measure
from hefting.simulation import UR5, random_smooth, simulate, stop_and_go, wield

pytestmark = pytest.mark.usefixtures("same_poses")


def test_columns_may_be_late_too():
    found = condition(exact_recording(0.0237))
    # cubic interpolation of 100 Hz
    assert found.offset == pytest.approx(0.0237, abs=1e-5)


def test_orientation_alone_shows_a_late_wrench_when_slow():
    motion = UR5.motion(stop_and_go(60.0, 50.0, dwell=4.0, move=4.0, seed=1))
    recording = simulate(motion, body(1.5), noise=NOISE)
    streams = {"orientation": recording["orientation"], "wrench": recording["wrench"]}
    found = condition(
        with_wrench(
            replace(recording, streams=streams),
            motion.time + 0.5,
            recording["wrench"].values,
        )
    )
    assert found.offset == pytest.approx(0.5, abs=0.01)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)
    np.testing.assert_array_equal(np.isinf(found.std[4:]), True)


@pytest.mark.parametrize("seed", range(3))
def test_rests_alone_tell_no_clock(seed):
    """Rests cut together, with gaps between them: nothing moves while anything is
    measured, so that no clock is looked for, and accelerations are none."""
    motion = UR5.motion(stop_and_go(40.0, 125.0, dwell=0.8, move=0.8, seed=seed))
    whole = simulate(motion, body(1.5), noise=NOISE, seed=seed)
    speed = np.abs(np.gradient(motion.orientation, motion.time, axis=0)).max(axis=1)
    rests = np.flatnonzero(speed == 0.0)
    streams = {name: stream[rests] for name, stream in whole.streams.items()}
    recording = replace(whole, streams=streams)
    found = condition(recording)
    assert found.offset_std is None
    assert not found.warnings
    assert not measure(recording).measurements.linear_acceleration.any()
    # four of its standard deviations
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]


def test_orientation_alone_invents_no_offset_when_fast():
    """What accelerations do to the wrench is not modelled, and would look like 66
    ms."""
    found = condition(
        replace(
            CLEAN, streams={name: CLEAN[name] for name in ("orientation", "wrench")}
        )
    )
    assert found.offset == 0.0
    assert any("none assumed" in said for said in found.warnings)


def test_accelerometer_of_another_clock():
    motion = UR5.motion(random_smooth(8.0, 200.0, 2.0, 1))
    recording = simulate(motion, body(1.5), noise=NOISE)
    z = wield(motion, body(1.5))
    felt = (
        z.linear_acceleration
        - z.gravity
        + 0.02 * np.random.default_rng(0).normal(size=z.gravity.shape)
    )
    streams = {"orientation": recording["orientation"], "wrench": recording["wrench"]}
    streams["accelerometer"] = Stream(motion.time + 0.0065, felt)
    streams["orientation"] = Stream(
        motion.time + 0.0065, recording["orientation"].values
    )
    found = condition(replace(recording, streams=streams))
    assert found.offset == pytest.approx(-0.0065, abs=1e-3)
    assert found.parameters[0] == pytest.approx(1.5, rel=0.005)
    assert any("early" in said for said in found.findings)


def test_static_poses():
    slow = simulate(
        UR5.motion(stop_and_go(60.0, 1.0, dwell=1.0, move=1.0, seed=5)),
        body(1.5),
        noise=NOISE,
        on_sensor=True,
    )
    rows = np.arange(len(slow["wrench"]), dtype=float)
    poses = {
        name: Stream(rows, slow[name].values) for name in ("orientation", "wrench")
    }
    found = condition(Recording(poses, static=True))
    assert not found.sign.on_object
    assert found.offset_std is None
    assert not any("clock" in said for said in found.warnings)
