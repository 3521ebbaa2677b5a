"""What happens to a recording happens once: counted on one `identify`."""

import sys
from collections import Counter
from pathlib import Path

import pytest

import hefting
from hefting.core.measurements import Noise
from hefting.identification import identify
from hefting.inspection import inspect
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate

ROOT = Path(hefting.__file__).parent


def calls(work) -> Counter:
    """How often each function of the package is called, as ``file.py:name``."""
    counted: Counter = Counter()

    def profile(frame, event, argument):
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(str(ROOT)):
            counted[
                f"{Path(code.co_filename).relative_to(ROOT)}:{code.co_qualname}"
            ] += 1

    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(None)
    return counted


@pytest.fixture(scope="module")
def recording():
    return simulate(
        UR5.motion(random_smooth(6.0, 100.0, 1.0, 3)),
        hammer().parameters,
        noise=Noise(0.1, 0.005),
        seed=3,
    )


@pytest.mark.parametrize("method", ["Bayes", "OLS", "PMD"])
def test_one_identify(recording, method):
    shape = Shape.from_mesh(hammer().mesh(), points=56)
    counted = calls(lambda: identify(recording, shape, method=method))
    for once in (
        "ingest/ingest.py:ingest",
        "ingest/condition.py:condition",
        "ingest/robust_fit.py:fit_from_scratch",
        "ingest/offset.py:scan_offsets",
        "motion/inertial.py:smooth_poses",
        "motion/measure.py:measure",
        "ingest/sign_and_bias.py:choose_sign",
        "ingest/condition.py:_estimate_noise",
        "ingest/weights.py:weights_of",
    ):
        assert counted[once] == 1, once
    # PMD's intervals are over the bodies that Bayes takes for possible
    assert counted["estimators/bayes/prior.py:Prior.of"] == (method in ("Bayes", "PMD"))
    assert counted["estimators/bayes/__init__.py:Bayes.posterior"] == (
        method == "Bayes"
    )
    # with a bias, without, and with gravity reversed
    assert counted["ingest/free_fit.py:free_fit"] <= 3


def test_inspect_is_a_view_of_the_same(recording):
    counted = calls(lambda: inspect(recording))
    assert counted["ingest/ingest.py:ingest"] == 1
    assert counted["ingest/robust_fit.py:fit_from_scratch"] == 1
