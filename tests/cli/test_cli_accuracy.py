"""--sensor-accuracy, --latitude and --altitude of the commands that take them."""

import json

import numpy as np
import pytest

from commands import refused
from hefting.core.gravity import WORLD_STD, Gravity
from hefting.core.measurements import Noise
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("accuracy")
    motion = UR5.motion(random_smooth(4.0, 50.0, 1.0, seed=3))
    log = simulate(motion, hammer().parameters, noise=Noise(0.05, 0.0025), seed=3)
    write_log(log, folder / "log.csv")
    return folder


def found(run, folder, *words) -> dict:
    status, out, err = run("identify", folder / "log.csv", "--json", *words)
    assert status in (0, 3), err  # 3: the mass is not determined by a bad sensor
    return json.loads(out)


def width(estimate: dict) -> float:
    return float(np.ptp(estimate["intervals"]["mass"]))


def test_a_sensor_that_is_said_to_be_worse_widens_the_intervals(run, folder):
    texts = ("0%", "0.5%", "0.5% 0.3N 0.01Nm", "UR10e")
    each = [found(run, folder, "--sensor-accuracy", text) for text in texts]
    widths = [width(estimate) for estimate in each]
    assert sorted(widths) == widths
    assert each[2]["provenance"]["sensor_accuracy"] == texts[2]
    assert width(found(run, folder)) == pytest.approx(widths[1])


def test_a_place_narrows_them(run, folder):
    nothing = found(run, folder, "--sensor-accuracy", "0%")
    place = ("--latitude", "-33.5", "--altitude", "600")
    there = found(run, folder, "--sensor-accuracy", "0%", *place)
    assert nothing["provenance"]["gravity_std"] == WORLD_STD
    known = Gravity.at(-33.5, 600.0)
    assert there["provenance"]["gravity"] == pytest.approx(known.vector)
    assert there["provenance"]["gravity_std"] == known.std
    assert width(there) < 0.8 * width(nothing)
    tilted = found(run, folder, "--gravity", "estimate", *place)
    size = np.linalg.norm(tilted["provenance"]["gravity"])
    assert size == pytest.approx(-known.vector[2])
    assert tilted["provenance"]["gravity_found"]


def test_other_commands_take_them(run, folder):
    log, tool = folder / "log.csv", folder / "tool.json"
    words = ("--latitude", "48", "--sensor-accuracy", "1%")
    assert run("calibrate", log, "--output", tool, *words)[0] == 0
    made = json.loads(tool.read_text())["provenance"]
    assert made["gravity"] == pytest.approx(Gravity.at(48.0).vector)
    assert made["sensor_accuracy"] == "1%"
    status, out, _ = run("inspect", log, "--latitude", "48", "--json")
    assert status == 0
    assert json.loads(out)["gravity"] == pytest.approx(Gravity.at(48.0).vector)
    bands = [
        json.loads(run("predict", tool, log, "--json", "--latitude", "48", *more)[1])
        for more in ((), ("--sensor-accuracy", "2%"))
    ]
    peaks = [np.subtract(b["high"], b["low"]).max() for b in bands]
    assert peaks[1] > peaks[0] > 0.0


def test_what_makes_no_sense_is_refused(run, folder):
    log = folder / "log.csv"
    for words, said in (
        (("--latitude", "91"), ("--latitude", "degrees")),
        (("--altitude", "100"), ("--altitude", "--latitude")),
        (("--latitude", "4", "--altitude", "1e9"), ("--altitude", "metres")),
        (("--latitude", "4", "--gravity", "0,0,-9.8"), ("--latitude", "leave one")),
        (("--sensor-accuracy", "5kg"), ("--sensor-accuracy", "as in")),
        (("--sensor-accuracy", "gamma"), ("--sensor-accuracy", "certificate")),
        (("--sensor-accuracy", "gama"), ("--sensor-accuracy", "did you mean 'gamma'")),
    ):
        assert refused(run("identify", log, *words), *said)
