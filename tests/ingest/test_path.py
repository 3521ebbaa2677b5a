"""A motion as a function of time: its derivatives, its ends, and its gaps."""

from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from disturbances import disturbed
from hefting.core.recording import Recording, Stream
from hefting.ingest.path import Path, _reading_rows, path_of, static_path

STEP = 2e-3
"""[s] to either side, of the numerical derivatives."""


def wave(time, spread):
    """21 sines, known but for a second in the middle."""
    speed, phase = np.linspace(1.0, 8.0, 21), np.linspace(0.0, 3.0, 21)
    rows = np.sin(speed * time[:, None] + phase)
    variances = np.full((2, len(time)), float(spread))
    return rows, variances, ~((time > 4.5) & (time < 5.5))


def path(kind: str = "smooth") -> Path:
    return Path(kind, 2.0, 8.0, wave, 100.0)


def test_derivatives_are_those_of_the_motion():
    """To the square of the step, of speeds of up to 8 rad/s; one-sided at the ends."""
    speed, phase = np.linspace(1.0, 8.0, 21), np.linspace(0.0, 3.0, 21)
    time = np.array((2.0, 2.0 + 0.4 * STEP, 3.0, 4.0, 7.0, 8.0 - 0.4 * STEP, 8.0))
    found = path().at(time, rates=True)
    angle = speed * time[:, None] + phase
    np.testing.assert_allclose(found.value, np.sin(angle))
    inner = slice(2, 5)
    expected = speed * np.cos(angle)
    np.testing.assert_allclose(found.rate[inner], expected[inner], atol=1e-3)
    np.testing.assert_allclose(found.rate, expected, atol=0.5 * 64.0 * STEP)
    curvature = -(speed**2) * np.sin(angle)
    np.testing.assert_allclose(found.curvature[inner], curvature[inner], atol=0.01)
    # where one side is too short there is none
    np.testing.assert_array_equal(found.curvature[[0, 1, 5, 6]], 0.0)
    near = path().at(np.array((2.0 + 0.6 * STEP,)), rates=True)
    assert near.curvature.any()
    np.testing.assert_array_equal(found.time, time)


def test_beyond_the_ends_the_motion_is_that_of_the_ends_and_unknown():
    time = np.array((1.0, 2.0, 5.0, 8.0, 9.0))
    found = path().at(time)
    np.testing.assert_array_equal(found.time, (2.0, 2.0, 5.0, 8.0, 8.0))
    np.testing.assert_array_equal(found.known, (False, True, False, True, False))
    np.testing.assert_array_equal(found.in_gap, (False, False, True, False, False))
    np.testing.assert_array_equal(found.variances, 1.0)
    np.testing.assert_array_equal(path().at(time, spread=False).variances, 0.0)
    np.testing.assert_array_equal(path().known_at(time), found.known)
    for each in (found, path("static").at(time, rates=True)):
        assert not each.rate.any()
        assert not each.curvature.any()
    # at the border of a gap nothing is derived
    border = path().at(np.array((4.5 - 0.5 * STEP, 4.5 - 2.0 * STEP)), rates=True)
    assert not border.rate[0].any()
    assert border.known.all()
    assert border.rate[1].any()


@pytest.mark.parametrize(
    ("kind", "smooth", "moves"),
    [
        ("smooth", True, True),
        ("orientation", True, True),
        ("accelerometer", False, True),
        ("columns", False, True),
        ("static", False, False),
    ],
)
def test_kinds_of_motion(kind, smooth, moves):
    assert path(kind).smooth is smooth
    assert path(kind).moves is moves


def test_rows_are_the_motion_in_sensor_axes_and_zero_where_it_is_not_finite():
    """a, alpha, the six products of w, and the rotation from world to sensor."""
    rng = np.random.default_rng(1)
    a, w, alpha = rng.normal(size=(3, 4, 3))
    R = Rotation.random(4, random_state=2)
    world = np.moveaxis(R.inv().as_matrix(), 0, 2)
    rows, known = _reading_rows(a.T, w.T, alpha.T, world)
    assert known.all()
    np.testing.assert_array_equal(rows[:, :6], np.hstack((a, alpha)))
    products = [w[:, i] * w[:, j] for i, j in zip(*np.triu_indices(3), strict=True)]
    found = np.sort(rows[:, 6:12], axis=1)
    np.testing.assert_allclose(found, np.sort(np.array(products).T, axis=1))
    matrices = rows[:, 12:].reshape(-1, 3, 3)
    np.testing.assert_allclose(matrices, R.inv().as_matrix(), atol=1e-12)
    gravity_alone, _ = _reading_rows(None, w.T, alpha.T, world)
    assert not gravity_alone[:, :12].any()
    np.testing.assert_array_equal(gravity_alone[:, 12:], rows[:, 12:])
    for given in (a.T, None):
        broken = alpha.copy()
        broken[2, 1] = np.nan
        rows, known = _reading_rows(given, w.T, broken.T, world)
        np.testing.assert_array_equal(known, (True, True, False, True))
        assert not rows[2].any()
        assert rows[3].any()


def without(recording: Recording, *names: str) -> Recording:
    kept = {n: s for n, s in recording.streams.items() if n not in names}
    return Recording(kept)


def test_a_motion_takes_eight_orientations():
    recording = disturbed("clean", 1.0, 0, duration=2.0).recording
    for count, found in ((7, False), (8, True)):
        streams = {
            n: Stream(s.time[: 4 * count : 4], s.values[: 4 * count : 4])
            for n, s in recording.streams.items()
        }
        assert (path_of(Recording(streams)) is not None) is found
    alone = path_of(without(recording, "position"))
    assert alone is not None
    assert alone.kind == "orientation"
    assert not alone.at(np.array((0.5, 1.0))).value[:, :12].any()
    still = {
        n: Stream(s.time, np.tile(s.values[:1], (len(s), 1)))
        for n, s in recording.streams.items()
    }
    assert path_of(Recording(still)) is None
    held = static_path(Recording(still))
    expected = Rotation.from_quat(np.array(still["orientation"].values[0])).inv()
    at = held.at(np.array((-5.0, 0.3, 99.0)))
    assert at.known.all()
    np.testing.assert_allclose(
        at.value[:, 12:].reshape(-1, 3, 3), np.tile(expected.as_matrix(), (3, 1, 1))
    )


def test_an_accelerometer_measures_gravity_and_has_the_noise_of_its_differences():
    recording = without(disturbed("clean", 1.0, 0, duration=2.0).recording, "position")
    time = recording["orientation"].time[5:-3]
    rng = np.random.default_rng(3)
    force = np.sin(3.0 * time)[:, None] + 0.2 * rng.normal(size=(len(time), 3))
    streams = {**recording.streams, "accelerometer": Stream(time, force)}
    found = path_of(Recording(streams))
    assert found is not None
    assert (found.kind, found.gravity_measured) == ("accelerometer", True)
    assert (found.first, found.last) == (time[0], time[-1])
    reading = found.at(time)
    np.testing.assert_allclose(reading.value[:, :3], force, atol=1e-12)
    std = np.std(np.diff(force, axis=0)) / 2.0**0.5
    np.testing.assert_allclose(reading.variances[0][reading.known], std**2)
    assert std == pytest.approx(0.2, rel=0.2)
    assert cast(Any, found.bandwidth) < np.inf
