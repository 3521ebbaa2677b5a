"""A scale's reading through `identify` and `compare`: tool, sensor gain, doubts."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.core.recording import Recording
from hefting.core.sensor_accuracy import Z95
from hefting.identification import calibrate, identify
from hefting.identification.compare import MISFIT, compare, misfit
from hefting.ingest.ingest import ingest
from hefting.simulation import UR5, hammer, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_recordings")

BODY = hammer().parameters
TOOL = InertialParameters.from_com(0.9, (0.0, 0.01, 0.04), 1e-3 * np.eye(3))


def recorded(body: InertialParameters, seed: int, gain: float = 0.0) -> Recording:
    motion = UR5.motion(random_smooth(6.0, 100.0, 1.2, seed=seed))
    found = simulate(motion, body, noise=Noise(0.05, 0.0025), seed=seed)
    wrench = found["wrench"]
    louder = replace(wrench, values=(1.0 + gain) * wrench.values)
    return replace(found, streams=found.streams | {"wrench": louder})


@pytest.fixture(scope="module")
def loud() -> Recording:
    """Of a sensor that shows 2 % too much."""
    return recorded(BODY, 1, 0.02)


@pytest.mark.parametrize("method", ["Bayes", "OLS", "LMI"])
def test_a_gain_that_the_scale_tells_is_no_misfit(loud, method):
    """The object's mass is right, the gain is told, and what the sensor shows beside it
    is neither unexplained nor a reason to choose another method."""
    settings = {"method": method, "sensor_accuracy": "2%"}
    alone = identify(loud, **settings).estimate
    estimate = identify(loud, mass=(BODY.mass, 3e-4), **settings).estimate
    assert estimate.parameters.mass == pytest.approx(BODY.mass, abs=6e-4)
    assert alone.parameters.mass > 1.005 * BODY.mass
    # a part of the difference is put down to gains of single channels
    assert 0.004 < estimate.provenance["sensor_gain"] < 0.021
    low, high = estimate.intervals["mass"]
    assert high - low == pytest.approx(2.0 * Z95 * 3e-4, rel=0.1)
    assert estimate.verdict.level == alone.verdict.level == "good", estimate.warnings
    np.testing.assert_allclose(estimate.residual, alone.residual, rtol=0.5)
    found = ingest(loud)
    assert misfit(estimate, found) < misfit(alone, found) + 0.1 * MISFIT
    # its standard deviation, which OLS has of its own, is that of the interval
    assert estimate.std["mass"] == pytest.approx(3e-4, rel=0.1)


def test_with_a_tool_the_scale_weighs_the_object_alone():
    tool = calibrate(recorded(TOOL, 2))
    both = InertialParameters(TOOL.vector + BODY.vector)
    recording = recorded(both, 3)
    for method in ("Bayes", "LMI", "OLS"):
        found = identify(
            recording, method=method, tool=tool, mass=(BODY.mass, 1e-3)
        ).estimate
        low, high = found.intervals["mass"]
        assert low <= BODY.mass <= high
        assert high - low == pytest.approx(2.0 * Z95 * 1e-3, rel=0.1)
        assert not codes(found.warnings) & {"mass-contradicts-wrench"}


def test_a_gripper_that_is_not_mentioned_is_asked_for():
    recording = recorded(InertialParameters(TOOL.vector + BODY.vector), 3)
    found = identify(recording, mass=(BODY.mass, 1e-3)).estimate
    message = next(
        w for w in found.warnings if codes([w]) & {"mass-contradicts-wrench"}
    )
    assert "gripper" in message
    assert found.verdict.level == "do not use"
    # by the wrench alone: the body that the sensor carries
    assert found.parameters.mass == pytest.approx(BODY.mass + TOOL.mass, rel=0.01)


def test_a_reading_with_the_tool_on_the_scale_is_told_from_other_wrong_ones():
    both = InertialParameters(TOOL.vector + BODY.vector)
    tool, recording = calibrate(recorded(TOOL, 2)), recorded(both, 3)
    for mass, asked in ((both.mass, True), (0.9 * both.mass, False)):
        found = identify(recording, tool=tool, mass=(mass, 1e-3)).estimate
        (message,) = (
            w for w in found.warnings if codes([w]) & {"mass-contradicts-wrench"}
        )
        assert ("with the tool of" in message) is asked
        assert ("is its unit right" in message) is not asked


def test_the_last_digit_is_said_aloud_and_gives_no_doubt(loud):
    found = identify(loud, mass="0.670kg", sensor_accuracy="2%").estimate
    assert codes(found.warnings) & {"mass-deviation-assumed"}
    assert found.verdict.level == "good"
    found = identify(loud, mass="0.670kg±1g", sensor_accuracy="2%").estimate
    assert not codes(found.warnings) & {"mass-deviation-assumed"}


def test_all_methods_of_a_comparison_take_it(loud):
    settings = {"mass": "0.6704kg±0.3g", "sensor_accuracy": "2%"}
    found = compare(loud, None, "all", hyperparameters=settings)
    assert found.recommended == "Bayes"
    masses = [estimate.parameters.mass for estimate in found.results.values()]
    assert len(masses) > 3
    np.testing.assert_allclose(masses, BODY.mass, atol=1e-3)


def test_it_is_sure_sooner(loud):
    """What gain leaves open for good, a scale tells: an accuracy of the mass that no
    recording reaches alone."""
    asked = {"until": "mass=0.3%,com=10mm,inertia=200%", "sensor_accuracy": "2%"}
    assert not identify(loud, **asked).estimate.sufficient
    found = identify(loud, mass=(BODY.mass, 3e-4), **asked).estimate
    assert found.sufficient
    doubtful = identify(loud, mass=(0.5 * BODY.mass, 3e-4), **asked).estimate
    assert not doubtful.sufficient
