"""One odd pose among a few static ones is named by its number and left out."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import f as F

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import identify
from hefting.ingest.samples import FEWEST_POSES, ODD, _oddness
from hefting.inspection import inspect
from hefting.logs import read_log
from recordings import DATA, needs_recordings

MASS, COM = 1.2, np.array((0.02, -0.03, 0.06))
COUNTS = range(FEWEST_POSES, 12)


def specific_force(turns):
    return np.asarray(-turns.inv().apply(STANDARD_GRAVITY))


def poses(seed, count, error=0.01):
    """Orientations and wrenches of a body, with a bias, noise, and gains and cross-talk of
    a share `error` of the wrench."""
    rng = np.random.default_rng([seed, count])
    turns = Rotation.random(count, rng=rng)
    force = MASS * specific_force(turns)
    wrench = np.hstack((force, np.cross(COM, force)))
    unit = np.repeat((1.0, 0.05), 3)
    wrench += wrench / unit @ (error * rng.normal(size=(6, 6))) * unit
    wrench += rng.normal(size=6) * np.repeat((5.0, 0.3), 3)
    wrench += rng.normal(size=wrench.shape) * np.repeat((0.03, 0.002), 3)
    return turns, wrench


def identified(turns, wrench):
    return identify(orientation=turns.as_quat(), wrench=wrench)


def odd(found):
    """The message of an odd pose, if any."""
    told = [each for each in found.verdict.reasons if each.code == "odd-pose"]
    return told[0] if told else None


@pytest.mark.parametrize("count", COUNTS)
def test_oddness_has_the_f_distribution_where_all_poses_are_right(count):
    """Of white noise, of which the others tell the variance with so many freedoms."""
    drawn = []
    for seed in range(40):
        turns, wrench = poses(seed, count, error=0.0)
        drawn += [_oddness(specific_force(turns), wrench)[0]]
    expected = F(6, 6 * (count - 1) - 10)
    # force and torque are weighted by what is found of each: up to a tenth more of it; the
    # standard error of 40 draws' mean is 0.1 to 0.2
    assert np.mean(drawn) == pytest.approx(expected.mean(), abs=0.5)
    assert max(drawn) < ODD


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("seed", range(5))
def test_right_poses_have_none(seed, count):
    found = identified(*poses(seed, count))
    assert odd(found) is None
    assert not found.ingested.conditioned.rejected.any()


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("which", [0, 3, 5])
@pytest.mark.parametrize("what", ["touched", "turned"])
def test_a_pose_that_was_touched_or_turned_is_left_out_by_its_number(
    what, which, count
):
    """Without it the answer is that of the others: it had been *good*, with a COM 10 to
    30 mm off."""
    turns, wrench = poses(which, count)
    if what == "touched":
        wrench[which] += (3.0, 8.0, 4.0, 0.5, 0.0, 0.2)
    else:
        quaternions = turns.as_quat()
        more = Rotation.from_euler("y", 40.0, degrees=True)
        quaternions[which] = (more * turns[which]).as_quat()
        turns = Rotation.from_quat(quaternions)
    found = identified(turns, wrench)
    told = odd(found)
    assert told is not None
    assert f"pose {which + 1} of {count} contradicts the others" in told
    assert found.verdict.level == "usable with care"
    assert found.ingested.conditioned.rejected.nonzero()[0].tolist() == [which]
    others = np.arange(count) != which
    alone = identified(turns[others], wrench[others]).estimate
    assert found.estimate.mass == pytest.approx(alone.mass, rel=1e-6)
    # of a sensor that is wrong by 1 %, in few poses
    assert found.estimate.mass == pytest.approx(MASS, rel=0.05)
    assert np.linalg.norm(found.estimate.center_of_mass - COM) < 0.01


def test_a_trifle_is_not_odd_however_small_the_noise():
    """Up to the accuracy of a sensor: 0.3 % of the wrench's changes."""
    turns, _ = poses(0, 8)
    exact = MASS * specific_force(turns)
    exact = np.hstack((exact, np.cross(COM, exact)))
    for touch, is_odd in ((0.02, False), (2.0, True)):
        touched = exact.copy()
        touched[4, 0] += touch
        oddness = _oddness(specific_force(turns), touched)
        assert bool(oddness.max() > ODD) is is_odd
    assert np.argmax(oddness) == 4


def test_of_fewer_poses_it_is_said_that_none_is_looked_for():
    turns, wrench = poses(1, FEWEST_POSES - 1)
    found = identified(turns, wrench)
    told = "too few poses to tell whether one of them is odd: none left out"
    assert told in [str(each) for each in found.warnings]


def test_inspect_tells_it_too():
    turns, wrench = poses(3, 7)
    wrench[2, :3] += 8.0
    index = np.arange(7.0)
    streams = {
        "wrench": Stream(index, wrench),
        "orientation": Stream(index, turns.as_quat()),
    }
    recording = Recording(streams, static=True, source="poses")
    assert "pose 3 of 7 contradicts the others" in str(inspect(recording))


@needs_recordings
def test_poses_of_real_sensors():
    """None of those as recorded; of 24 some, one of which was touched."""
    rng = np.random.default_rng(0)
    seven = read_log(DATA / "axia80" / "poses7.csv")
    kuka = read_log(DATA / "kuka-ati" / "static_poses.csv")
    own = Rotation.from_quat(seven["orientation"].values)
    assert _oddness(specific_force(own), seven["wrench"].values).max() < 10.0
    for count in COUNTS:
        rows = rng.choice(24, count, replace=False)
        turns = Rotation.from_quat(kuka["orientation"].values[rows])
        wrench = kuka["wrench"].values[rows].copy()
        assert odd(identified(turns, wrench)) is None
        wrench[1, :3] += (4.0, 2.0, 2.0)
        told = odd(identified(turns, wrench))
        assert told is not None
        assert f"pose 2 of {count}" in told


def test_numbers_of_odd_poses_are_told_of_many():
    turns, wrench = poses(4, 24, error=0.0)
    wrench[[6, 17], :3] += 6.0
    found = identified(turns, wrench)
    notes = [str(each) for each in found.ingested.conditioned.findings]
    assert any(each.endswith("left out: 7, 18") for each in notes)
