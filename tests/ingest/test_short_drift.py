"""A bias that drifts in a recording too short for it to be taken out: no other mistake
is named in its place, and a mistake is found beside it."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.clean import simulated

from given_cases import case_of, correct, mistake
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import identify
from hefting.ingest.rivals.consequence import doubt_of
from recordings import DATA, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")

WANDER = 0.03
"""Size of a drift over the object's weight."""


def drifting(recording: Recording, mass: float, seed: int) -> Recording:
    """With a bias that wanders by a random walk."""
    rng, wrench = np.random.default_rng([3, seed]), recording["wrench"]
    weight = -STANDARD_GRAVITY[2] * mass * np.repeat((1.0, 0.1), 3)
    size = np.abs(WANDER * weight * rng.normal(size=6))
    steps = rng.normal(size=wrench.values.shape)
    walk = np.cumsum(steps, axis=0) / np.sqrt(len(steps))
    streams = dict(recording.streams)
    streams["wrench"] = replace(wrench, values=wrench.values + size * walk)
    return replace(recording, streams=streams)


@pytest.mark.parametrize("number", [7, 23, 32, 38, 65, 71])
def test_a_bias_that_wanders_is_no_other_mistake(number):
    """A cable, a change of the object, a payload taken away and an elastic grip were
    named in these."""
    recording, *_, mass = simulated(number, 5.5)
    found = identify(drifting(recording, mass, number), None).estimate
    said = {w.code for w in found.warnings if w.severity == "error"}
    assert said <= {"drift-in-short", "unexplained"}


@needs_recordings
@pytest.mark.parametrize(
    ("run", "start", "duration"),
    [
        *(("run1", 8.0, 4.0), ("run1", 10.0, 4.0)),
        *(("run1", 6.0, 6.0), ("run3", 14.0, 4.0)),
    ],
)
def test_no_axes_are_turned_in_a_part_of_a_right_recording(run, start, duration):
    """Of a sensor that creeps: turns by 6 to 175° were named, and uneven gains. More
    parts: `identification/test_recorded.py`."""
    log = DATA / "panda-optoforce" / f"{run}.csv"
    found = identify(
        log, None, gravity=(0.0, 0.0, -9.81), start=start, duration=duration
    ).estimate
    said = {w.code for w in found.warnings if w.severity == "error"}
    assert said <= {"drift-in-short", "unexplained"}


@pytest.mark.parametrize(
    ("name", "strength"), [("turned about z", "30°"), ("axis flipped", "fx")]
)
def test_a_mistake_is_named_beside_a_drift(name, strength):
    given = mistake(name, strength).make(correct(1), np.random.default_rng(1))
    given = replace(given, recording=given.recording.slice(0.0, 5.5))
    right = doubt_of(case_of(given))
    wandering = replace(given, recording=drifting(given.recording, 0.5, 1))
    beside = doubt_of(case_of(wandering))
    assert right is not None
    assert beside is not None
    assert beside.message.code == right.message.code
    assert beside.is_fatal
