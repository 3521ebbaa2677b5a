"""Conditioning of recordings with nothing to correct, or too little to find it."""

from dataclasses import replace

import numpy as np
import pytest

from conditioned import CLEAN, condition, exact_recording
from disturbances import body, disturbed, with_wrench
from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream

pytestmark = pytest.mark.usefixtures("same_poses")


def test_what_is_right_is_left_alone():
    recording = exact_recording()
    found = condition(recording)
    assert found.offset == 0.0
    assert not found.rejected.any()
    assert found.bias.kind == "constant"
    assert found.corrected(recording) is recording
    np.testing.assert_allclose(found.parameters, body(1.5).vector, atol=1e-8)


def held(noise):
    rng, time = np.random.default_rng(0), np.arange(300) * 0.01
    q = np.array((0.0, 0.0, 0.0, 1.0)) + noise * rng.normal(size=(300, 4))
    streams = {
        "position": Stream(time, noise * rng.normal(size=(300, 3))),
        "orientation": Stream(time, q / np.linalg.norm(q, axis=1, keepdims=True)),
        "wrench": Stream(
            time, (0.0, 0.0, 9.8, 0.0, 0.0, 0.0) + 0.1 * rng.normal(size=(300, 6))
        ),
    }
    return Recording(streams)


POOR = {
    "three samples": CLEAN.slice(1.0, 0.03),
    "a tenth of a second": CLEAN.slice(1.0, 0.1),
    "half a second": CLEAN.slice(1.0, 0.5),
    "one wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time[:1], CLEAN["wrench"].values[:1]
    ),
    "another time": with_wrench(
        CLEAN, CLEAN["wrench"].time + 100.0, CLEAN["wrench"].values
    ),
    "no wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time, np.zeros((len(CLEAN["wrench"]), 6))
    ),
    "a constant wrench": with_wrench(
        CLEAN, CLEAN["wrench"].time, np.ones((len(CLEAN["wrench"]), 6))
    ),
    "noise": with_wrench(
        CLEAN,
        CLEAN["wrench"].time,
        np.random.default_rng(0).normal(size=(len(CLEAN["wrench"]), 6)),
    ),
    "held exactly": held(0.0),
    "held": held(1e-4),
    "few poses": replace(
        CLEAN,
        streams={n: s if n == "wrench" else s[:5] for n, s in CLEAN.streams.items()},
    ),
}


@pytest.mark.parametrize("tilt", [False, True])
@pytest.mark.parametrize("name", POOR)
def test_what_cannot_be_found_counts_as_absent(name, tilt):
    found = condition(POOR[name], tilt=tilt)
    assert found.offset == 0.0
    assert not found.sign.certain or name == "half a second"
    assert found.warnings
    assert np.isfinite(found.parameters).all()
    assert len(found.rejected) == len(POOR[name]["wrench"])


def test_no_clock_asked_for_none_looked_for():
    d = disturbed("offset", 1.5, 0)
    found = condition(d.recording, clock=False)
    assert found.offset == 0.0
    assert found.offset_std is None


def test_wrong_gravity_is_refused():
    for gravity in ((0.0, 0.0, 0.0), (0.0, 9.81), (0.0, 0.0, np.nan)):
        with pytest.raises(InputError, match="gravity"):
            condition(CLEAN, gravity)


def test_a_gap_in_the_poses():
    kept = np.ones(len(CLEAN["position"]), dtype=bool)
    kept[300:500] = False
    streams = {n: s if n == "wrench" else s[kept] for n, s in CLEAN.streams.items()}
    found = condition(replace(CLEAN, streams=streams))
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]
    assert not found.rejected.any()


def test_a_sensor_at_its_limit():
    wrench = CLEAN["wrench"].values.copy()
    limit = np.quantile(wrench[:, 2], 0.85)
    clipped = wrench[:, 2] > limit
    wrench[:, 2] = np.minimum(wrench[:, 2], limit)
    found = condition(with_wrench(CLEAN, CLEAN["wrench"].time, wrench))
    assert found.rejected[clipped].all()
    assert found.reasons["saturation"] < 1.5 * clipped.sum()
    assert abs(found.parameters[0] - 1.5) < 4.0 * found.std[0]
