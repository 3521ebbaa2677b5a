"""A clock offset is applied where its whole profile speaks for it, and not where another
fault of the recording invents it.

The offset is the same whether or not changes of the object are looked for (see
`test_changes.py`): here they are not, which takes most of the time.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from disturbances import NOISE, body, disturbed, with_wrench
from hefting.core.messages import codes
from hefting.core.recording import Stream
from hefting.ingest import condition
from hefting.ingest.offset_profile import (
    LARGE_OFFSET,
    OFFSET_OF_UNIT_GAIN,
    OffsetProfile,
)
from hefting.logs import read_log
from hefting.simulation import UR5, simulate, sinusoids, trapezoids
from recordings import DATA, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")

HARMLESS = 0.025
"""[s] Offsets up to this may be invented: a sensor turned by 5° to 15° resembles them."""
DOUBTS = {
    "clock-offset-contradictory",
    "clock-several-offsets",
    "clock-offset-at-edge",
    "clock-offset-unknown",
}


LIGHT, HEAVY = 0.3, 1.5
"""[kg]"""


@cache
def recordings(mass):
    """Random motion, sinusoids and trapezoid moves of an object, each of 10 s."""
    return list(wielded(mass))


def wielded(mass):
    yield disturbed("clean", mass, 1).recording
    for joints in (
        sinusoids(10.4, 100.0, angular_speed=0.6),
        trapezoids(10.4, 100.0, seed=0),
    ):
        yield simulate(UR5.motion(joints), body(mass), noise=NOISE)


def turned(recording, degrees):
    wrench = recording["wrench"]
    axis = np.random.default_rng(5).normal(size=3)
    turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
    values = np.hstack([v @ turn.as_matrix().T for v in np.hsplit(wrench.values, 2)])
    return with_wrench(recording, wrench.time, values)


def torque_flipped(recording, axis):
    wrench = recording["wrench"]
    values = wrench.values.copy()
    values[:, 3 + int(axis)] *= -1.0
    return with_wrench(recording, wrench.time, values)


def in_contact(recording, force):
    """Pressed against something for half of the time, with a force that wanders."""
    wrench, rng = recording["wrench"], np.random.default_rng(6)
    time, values = wrench.time, wrench.values.copy()
    on = (time > 0.2 * time[-1]) & (time < 0.7 * time[-1])
    wander = np.sin(2.0 * np.pi * rng.uniform(0.1, 0.6, 3) * time[:, None])
    push = force * (rng.normal(size=3) / 1.7 + 0.5 * wander)
    values[on] += np.hstack((push, np.cross((0.05, 0.02, 0.1), push)))[on]
    return with_wrench(recording, time, values)


def quaternions_reordered(recording, _):
    q = recording["orientation"]
    scalar_first = Stream(q.time, q.values[:, [3, 0, 1, 2]])
    return replace(
        recording, streams={**recording.streams, "orientation": scalar_first}
    )


WRONG = [
    *((turned, degrees) for degrees in (5.0, 15.0, 60.0, 180.0)),
    *((torque_flipped, axis) for axis in range(3)),
    (in_contact, 5.0),
    (in_contact, 15.0),
    (quaternions_reordered, 0.0),
]


@pytest.mark.parametrize(("fault", "size"), WRONG)
def test_no_offset_is_invented(fault, size):
    """Before profiles were judged, a third of these got offsets of 28 to 550 ms: of the
    light object where of the heavy one, which comes nearer to the limit."""
    for recording in recordings(HEAVY):
        found = condition(fault(recording, size), changes=False)
        assert abs(found.offset) < HARMLESS


@pytest.mark.parametrize("late", [0.01, 0.4, -0.2])
def test_true_offsets_are_found(late):
    """To 3 ms: four standard deviations of the least certain, 0.3 kg on slow
    sinusoids. Of a heavy object they are more certain."""
    for recording in recordings(LIGHT):
        wrench = recording["wrench"]
        late_wrench = with_wrench(recording, wrench.time + late, wrench.values)
        found = condition(late_wrench, changes=False)
        assert found.offset == pytest.approx(late, abs=3e-3)
        assert not codes(found.warnings) & DOUBTS


@pytest.mark.parametrize("constant", [0.02, 0.1])
def test_a_filter_delays(constant):
    """A first-order filter delays slow motion by its time constant: that is an offset,
    to a quarter as the motion is not slow for it, and of a heavy object more clearly
    than of a light one."""
    for recording in recordings(LIGHT):
        wrench = recording["wrench"]
        a = float(np.exp(-0.01 / constant))
        values = lfilter(
            [1.0 - a], [1.0, -a], wrench.values, axis=0, zi=a * wrench.values[:1]
        )[0]
        filtered = with_wrench(recording, wrench.time, np.asarray(values))
        found = condition(filtered, changes=False)
        assert found.offset == pytest.approx(constant, rel=0.3)


@needs_recordings
@pytest.mark.parametrize("late", [-0.2, 0.2, 0.3])
def test_coloured_residuals_of_a_real_sensor_leave_enough_gain(late):
    """Its 18 ms are a filter's; the rest gains 500 to 980."""
    recording = read_log(DATA / "panda-optoforce" / "run3.csv")
    streams = dict(recording.streams)
    wrench = streams["wrench"]
    streams["wrench"] = Stream(wrench.time + late, wrench.values)
    found = condition(replace(recording, streams=streams), changes=False)
    assert found.offset == pytest.approx(late + 0.0175, abs=0.002)
    assert not codes(found.warnings) & DOUBTS


def profile(found, square, at_zero=None):
    """A profile on a grid from -1 to 1 s, of a function of the offset."""
    offsets = np.round(np.arange(-1.0, 1.01, 0.02), 2)
    values = np.array([square(o) for o in offsets], dtype=float)
    zero = square(0.0) if at_zero is None else at_zero
    return OffsetProfile(offsets, values, found, zero, square(found))


def test_each_doubt_has_its_cause():
    """On profiles made up for the purpose."""

    def valley(at, depth, width):
        return lambda o: 5000.0 - depth * np.exp(-(((o - at) / width) ** 2))

    one, other = valley(0.3, 4000.0, 0.05), valley(-0.4, 3500.0, 0.05)
    assert profile(0.3, one).doubt() is None
    assert profile(0.3, lambda o: one(o) + other(o)).doubt() == "several"
    assert profile(0.3, lambda o: one(o) + other(o)).rival[0] == pytest.approx(-0.4)
    assert profile(1.0, valley(1.0, 4000.0, 0.05)).doubt() == "edge"
    weak = 0.5 * (0.05 / OFFSET_OF_UNIT_GAIN) ** 2
    assert profile(0.05, valley(0.05, weak, 0.02)).doubt() == "gain"
    assert profile(2.0 * LARGE_OFFSET, valley(0.2, 2000.0, 0.05)).doubt() == "share"


@pytest.mark.parametrize(
    ("offset", "rival", "least", "doubt"),
    [
        (0.5, 0.9, 400.0, None),
        (0.5, 0.2, 400.0, "several"),
        (0.5, -0.9, 400.0, "several"),
        (0.5, 0.9, 800.0, "several"),
    ],
)
def test_of_two_lags_that_explain_much_alike_the_earlier_is_taken(
    offset, rival, least, doubt
):
    """As in the rise of a single move. Of 1,000 at zero offset both leave about as much."""
    offsets = np.round(np.arange(-1.5, 1.51, 0.02), 2)
    square = np.full(len(offsets), 1000.0)
    square[np.argmin(np.abs(offsets - offset))] = least
    square[np.argmin(np.abs(offsets - rival))] = least + 10.0
    profile = OffsetProfile(offsets, square, offset, 1000.0, least)
    assert profile.doubt() == doubt
