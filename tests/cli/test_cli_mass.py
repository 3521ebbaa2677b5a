"""--mass of hefting identify."""

import json

import numpy as np
import pytest

from commands import refused
from hefting.core.measurements import Noise
from hefting.core.sensor_accuracy import Z95
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    motion = UR5.motion(random_smooth(4.0, 50.0, 1.0, seed=3))
    recording = simulate(motion, hammer().parameters, noise=Noise(0.05, 0.0025), seed=3)
    path = tmp_path_factory.mktemp("mass") / "log.csv"
    write_log(recording, path)
    return path


def test_a_scale_s_reading_counts_and_is_told(run, log):
    for method in ("Bayes", "LMI"):
        words = ("--method", method, "--mass", "670.4g+-0.2g")
        status, out, _ = run("identify", log, "--json", *words)
        found = json.loads(out)
        assert status == 0
        assert np.ptp(found["intervals"]["mass"]) == pytest.approx(4e-4 * Z95, rel=0.1)
        assert found["provenance"]["mass"] == "0.6704kg±0.2g"
    status, out, _ = run("identify", log, "--mass", "0.6704kg±0.2g")
    assert status == 0
    assert "the scale's 0.6704kg±0.2g was used" in out


def test_a_reading_that_cannot_be_stops_at_the_verdict(run, log):
    status, out, _ = run("identify", log, "--mass", "670kg±1kg")
    assert status == 3
    assert out.startswith("verdict: do not use\n- the scale shows 670 kg")


def test_without_a_deviation_the_last_digit_is_named(run, log):
    _, out, _ = run("identify", log, "--mass", "0.670kg")
    assert "accurate to 1 g" in " ".join(out.split())
    assert "as in --mass 0.512kg±1g" in " ".join(out.split())


@pytest.mark.parametrize("text", ["heavy", "1kg", "0.5kg±1kg", "-1kg±1g"])
def test_what_is_no_reading_is_refused(run, log, text):
    assert refused(run("identify", log, f"--mass={text}"), "--mass", "0.512kg±1g")
