"""Convergence: each instant is what the method says of the samples up to it."""

import numpy as np
import pytest

from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.identification import identify
from hefting.identification.convergence import INSTANTS, convergence, ten_of
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate
from hefting.simulation.demo import POSE

pytestmark = pytest.mark.usefixtures("same_recordings")


def log_of(seed=1, seconds=5.0):
    motion = UR5.motion(random_smooth(seconds, 100.0, 1.0, seed))
    held = hammer().parameters.moved(POSE)
    return simulate(motion, held, noise=Noise(0.1, 0.005), seed=seed)


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), pose=POSE)


@pytest.mark.parametrize("method", ["Bayes", "PMD", "GEO", "LMI", "OLS", "RTLS"])
def test_each_instant_is_the_estimate_of_the_samples_up_to_it(shape, method):
    found = identify(log_of(), shape, method=method)
    over = convergence(found.estimator, found.ingested, found.estimate)
    assert len(over.rows) == INSTANTS
    assert over.rows[-1] == len(found.measurements)
    assert (np.diff(over.rows) > 0).all()
    assert np.array_equal(over.values[-1], ten_of(found.estimate.parameters))
    z = found.measurements
    if found.estimator.depends_on_count:
        z = found.ingested.weighted_by_count
    # an estimate that starts at an earlier one ends where its passes end: Bayes stops
    # when variances change by 2 %, and then differs by far less than its intervals
    half = 0.5 * (over.high - over.low)
    tolerance = 0.1 * half if method == "Bayes" else 1e-6 * np.abs(half) + 1e-9
    for k in (5, 12, 18):
        alone = ten_of(found.estimator.fit(z[: over.rows[k]]).parameters)
        assert (np.abs(over.values[k] - alone) <= tolerance[k]).all()


def test_intervals_are_those_of_the_estimates_and_shrink(shape):
    found = identify(log_of(), shape)
    over = convergence(found.estimator, found.ingested, found.estimate)
    intervals = found.estimate.intervals
    assert (over.low[-1, 0], over.high[-1, 0]) == tuple(intervals["mass"])
    assert np.array_equal(over.low[-1, 1:4], intervals["center_of_mass"][0])
    assert np.array_equal(over.high[-1, 1:4], intervals["center_of_mass"][1])
    assert over.high[-1, 4] == intervals["inertia_at_com"][1][0, 0]
    width = over.high - over.low
    # of one parameter an interval may grow, as more noise is seen; on average not
    assert np.log(width[-1] / width[1]).mean() < 0.0


def test_static_poses_and_too_few_of_them():
    log = log_of(seconds=10.0)
    poses = {name: log[name][::100] for name in ("orientation", "wrench")}
    found = identify(Recording(poses, static=True), method="OLS")
    over = convergence(found.estimator, found.ingested, found.estimate)
    # of eleven poses at most eleven instants; those that tell nothing are left out
    assert 2 <= len(over.rows) <= 11
    assert over.rows[-1] == len(found.measurements)


def test_several_recordings_one_after_the_other():
    found = identify([log_of(1), log_of(2)], method="OLS")
    over = convergence(found.estimator, found.ingested, found.estimate)
    assert over.rows[-1] == len(found.measurements)
    first = len(found.ingested.recordings[0].measurements)
    k = int(np.flatnonzero(over.rows <= first)[-1])
    part = found.ingested.recordings[0].measurements
    alone = ten_of(found.estimator.fit(part[: over.rows[k]]).parameters)
    # least squares to rounding of the triangular factors
    assert over.values[k] == pytest.approx(alone, rel=1e-6, abs=1e-9)
