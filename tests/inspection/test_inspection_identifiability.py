"""Inspection of a recording says what its motion determines, and why it does not the
rest."""

import io

import numpy as np
from rich.console import Console
from scipy.spatial.transform import Rotation

from hefting.cli.report.inspection import inspection_report
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.inspection import inspect
from hefting.simulation import UR5, hammer, random_smooth, simulate


def printed(found) -> str:
    page = io.StringIO()
    Console(width=300, file=page).print(inspection_report(found, verbose=True))
    return page.getvalue()


def test_inspection_of_a_good_recording():
    log = simulate(
        UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=1)),
        hammer().parameters,
        noise=Noise(0.05, 0.0025),
    )
    found = inspect(log)
    assert found.undetermined == ()
    assert found.to_dict()["identifiability"] == found.identifiability.to_dict()
    assert found.to_dict()["undetermined"] == []
    text = printed(found)
    assert (
        f"rank 10 of 10, condition number {found.identifiability.condition_full:.3g}; by gravity alone 4 of 4"
        in text
    )
    assert "all ten parameters can be found" in text
    assert "ready" in found.advice[0]


def test_inspection_says_why():
    """Static poses that turn about the vertical only."""
    rng = np.random.default_rng(11)
    turns = Rotation.from_euler("z", np.linspace(0.0, 3.0, 12)[:, None])
    wrench = np.tile((0.0, 0.0, 10.0, 0.5, -0.2, 0.0), (12, 1)) + np.repeat(
        (0.05, 0.0025), 3
    ) * rng.normal(size=(12, 6))
    time = np.arange(12.0)
    streams = {
        "orientation": Stream(time, turns.as_quat()),
        "wrench": Stream(time, wrench),
    }
    found = inspect(Recording(streams, static=True, source="poses"))
    assert "COM z not observable: sensor z never left the vertical" in found.advice
    assert found.advice[0].startswith("record other orientations")
    assert found.to_dict()["identifiability"]["rank_reduced"] == 3
    assert found.to_dict()["undetermined"] == list(found.identifiability.open)
    text = printed(found)
    assert "rank 3 of 10, condition number inf; by gravity alone 3 of 4, inf" in text
    assert "next: COM z not observable: sensor z never left the vertical" in text
    assert "not determined by the motion: mcz, Jxx" in text
