"""Two mistakes at once: both are named, one alone stays one, and a mistake that is undone
leaves the recording as it was without it."""

from dataclasses import replace

import numpy as np
import pytest

from given_cases import case_of, correct, mistake, undone_of
from hefting.core.errors import HeftingError
from hefting.core.messages import codes
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import identify
from hefting.ingest import condition
from hefting.ingest.rivals import (
    UNDONE,
    axis_flipped,
    base,
    bias,
    pose_forms,
    two_mistakes,
    units,
)
from hefting.ingest.rivals import explanation as undone_poses
from hefting.ingest.rivals.consequence import doubt_of
from hefting.ingest.rivals.explanation import INERTIAL, as_given
from hefting.ingest.rivals.judge import judge_one
from hefting.ingest.rivals.two_mistakes import judge

pytestmark = pytest.mark.usefixtures("same_poses")

TURNED, FLIPPED = ("turned about z", "30°"), ("axis flipped", "fx")
W_FIRST, TILTED = ("quaternion order", "w first"), ("base tilted", "15°")
PAIRS = {
    (TURNED, W_FIRST): {"quaternion-order", "axes-turned"},
    (TILTED, FLIPPED): {"axis-flipped", "base-tilted"},
    (W_FIRST, FLIPPED): {"quaternion-order", "axis-flipped"},
    (("turned about z", "90°"), ("unit of torque", "N mm")): {
        "force-unit",
        "axes-turned",
    },
    (("unit of position", "mm"), ("compensated wrench", "100%")): {
        "position-unit",
        "wrench-compensated",
    },
    (("bias none", "5 N"), TURNED): {"bias-wrong", "axes-turned"},
    (TURNED, ("wrench in base axes", "")): {"wrench-in-base-axes", "axes-turned"},
    (("inverse pose", "whole"), FLIPPED): {"pose-inverse", "axis-flipped"},
}
"""Two mistakes, and the codes that name them."""
BRIEF = {
    (W_FIRST, FLIPPED): pose_forms.undone,
    (("bias none", "5 N"), TURNED): bias.undone,
    (TURNED, ("wrench in base axes", "")): base.axes_undone,
    (("inverse pose", "whole"), FLIPPED): pose_forms.inverse_undone,
}
"""Pairs that are looked for among fewer, with how the first is undone."""


def made(*names, seed=0):
    """A recording with these mistakes in it."""
    given, rng = correct(seed), np.random.default_rng(1)
    for name in names:
        given = mistake(*name).make(given, rng)
    return given


def case_with(*names, seed=0):
    given = made(*names, seed=seed)
    gravity = given.options.get("gravity", STANDARD_GRAVITY)
    offset = condition(given.recording, gravity, changes=False).offset
    return case_of(given, offset)


def look_for_few(monkeypatch, first):
    """The mistake `first`, and those of a wrong sign or unit."""
    among = undone_of(axis_flipped.undone, units.force_undone, first)
    monkeypatch.setattr(two_mistakes, "UNDONE", among)


@pytest.mark.parametrize("names", PAIRS)
def test_both_are_named(names, monkeypatch):
    """Half of the pairs among all that are undone, the others among their own kind and
    those of a wrong sign or unit."""
    if names in BRIEF:
        look_for_few(monkeypatch, BRIEF[names])
    doubt = doubt_of(case_with(*names))
    assert doubt is not None
    assert {each.code for each in doubt.messages} == PAIRS[names]
    assert doubt.is_fatal
    assert doubt.needs_no_change
    first, second = doubt.messages
    assert first.startswith("first of two mistakes at once: ")
    assert second.startswith("second of two mistakes at once: ")
    assert first.severity == second.severity == "error"


@pytest.mark.parametrize(
    "name",
    [TURNED, FLIPPED, W_FIRST, ("cable", "20 N/m"), ("torque about the TCP", "150 mm")],
)
def test_one_mistake_is_one(name):
    """Also where it leaves more than noise, as those of the third recording."""
    found = judge(case_with(name, seed=2))
    assert found.named is not None
    assert found.named.code in mistake(*name).codes
    assert found.beside is None


def test_nothing_is_looked_for_where_free_channels_explain_nothing(monkeypatch):
    """They bound what any second mistake explains, so none is fitted."""
    case = case_with(TURNED, W_FIRST)

    def hopeless(case):
        fitted = as_given(case).fitted
        yield replace(fitted, likelihood=fitted.likelihood - 9.0), 0.0

    monkeypatch.setattr(two_mistakes, "explained_by_motion", hopeless)
    monkeypatch.setattr(two_mistakes, "BESIDE_ANOTHER", [pytest.fail])
    assert judge(case).beside is None


def test_a_vibration_is_no_mistake(monkeypatch):
    """No two are looked for where most of what is left is one tone."""
    given = mistake("vibration", "12 Hz").make(correct(0), np.random.default_rng(1))
    case = case_of(given)
    assert judge_one(case).unexplained > 0.1
    monkeypatch.setattr(two_mistakes, "_likeliest", pytest.fail)
    assert judge(case).named is None


def test_an_answer_and_a_refusal_tell_both(monkeypatch):
    """The two messages, in this order and before any other."""
    look_for_few(monkeypatch, pose_forms.undone)
    given = made(TURNED, W_FIRST)
    try:
        said = identify(given.recording).estimate.warnings
    except HeftingError as refusal:
        text = str(refusal)
    else:
        assert {"quaternion-order", "axes-turned"} <= codes(said)
        text = "; ".join(said)
    first, second = text.index("first of two"), text.index("second of two")
    assert first < text.index("w, x, y, z") < second < text.index("turned by 30.0°")


def test_the_fit_to_the_right_recording_is_that_of_the_pair(monkeypatch):
    """What is said of the second mistake is what is said of it alone, and the object is
    the one that is found with it."""
    look_for_few(monkeypatch, pose_forms.undone)
    pair, alone = judge(case_with(TURNED, W_FIRST)), judge(case_with(TURNED))
    assert pair.beside is not None
    assert pair.named is not None
    assert alone.named is not None
    # clock offsets are found to a fraction of a millisecond
    assert np.allclose(pair.named.vector[0], alone.named.vector[0], rtol=1e-3)
    assert pair.beside.fix == alone.named.fix


@pytest.mark.parametrize(
    ("name", "undone", "what"),
    [
        (FLIPPED, axis_flipped.undone, "force x seems"),
        (
            ("axis flipped", "all torques"),
            axis_flipped.undone,
            "the torque seems to have",
        ),
        (
            ("columns swapped", "force and torque"),
            axis_flipped.undone,
            "force and torque",
        ),
        (
            ("unit of torque", "N mm"),
            units.force_undone,
            "the torque seems to be in N mm",
        ),
        (
            ("unit of position", "mm"),
            units.position_undone,
            "the positions seem to be in m",
        ),
        (
            ("time", "half as fast"),
            units.time_undone,
            "time seems to run 2 times too slow",
        ),
        (W_FIRST, pose_forms.undone, "the quaternions"),
        (("inverse pose", "whole"), pose_forms.inverse_undone, "the logged pose"),
        (
            ("inverse pose", "orientation"),
            pose_forms.inverse_undone,
            "the logged orientation",
        ),
        (("wrench in base axes", ""), base.axes_undone, "the wrench"),
        (("bias none", "5 N"), bias.undone, "the wrench seems to have another"),
    ],
)
def test_undone_it_is_the_recording_without_it(name, undone, what):
    right, wrong = case_of(correct(1)), case_of(made(name, seed=1))
    found = next(each for each in undone(wrong) if each.what.startswith(what))
    assert found.code in mistake(*name).codes
    case = found.case
    assert case.biased is right.biased
    # by the right bias, or with time of its own, other samples are averaged
    if name[0] not in ("bias none", "time"):
        assert np.allclose(case.wrench, right.wrench, rtol=1e-3, atol=0.02)
        assert np.allclose(case.floor, right.floor, rtol=0.05)
    times = right.time[None, 20:-20]
    expected = right.motion_at(times)
    motion = case.motion_at(0.5 * times if name[0] == "time" else times)
    # what is inverted, or in millimetres, is smoothed by its own noise
    size = np.abs(expected.a).max()
    assert np.sqrt(np.mean((motion.a - expected.a) ** 2)) < 0.1 * size
    assert np.allclose(motion.axes, expected.axes, atol=0.01)


def test_forces_in_another_unit_are_as_likely_as_in_newtons():
    """The likelihood of a wrench in another unit, by how its volumes are scaled."""
    case = case_of(correct(1))
    likelihoods = [
        undone.explanation().likelihood + undone.log_scale
        for undone in units.force_undone(case)
    ]
    # of force and torque in the same ratio as in newtons and newton-metres
    matrix = np.diag(np.full(6, 9.80665))
    scaled = as_given(case.with_wrench(matrix)).likelihood + 6.0 * np.log(9.80665)
    assert np.isclose(scaled, as_given(case).likelihood, atol=1e-6)
    assert max(likelihoods) < scaled - 0.5


def test_every_mistake_that_is_undone_says_what_to_do():
    case = case_of(made(W_FIRST))
    each = [undone for kind, _ in UNDONE for undone in kind(case)]
    assert len({undone.what for undone in each}) == len(each) > 25
    assert all(undone.fix and undone.code for undone in each)


def test_poses_are_read_once_by_all_searches_and_without_inertial_sensors(monkeypatch):
    """Of which the path of the poses is the same."""
    read = []

    def path_of(recording, source, gravity):
        read.append(recording)
        return real(recording, source, gravity)

    real = undone_poses.path_of
    monkeypatch.setattr(undone_poses, "path_of", path_of)
    given = correct(1, imu=True)
    assert given.recording.has("gyroscope")
    case = case_of(given)
    first = list(pose_forms.inverse_undone(case))
    again = list(pose_forms.inverse_undone(case.with_drift(1)))
    assert len(read) == len(first) == len(again) == 2
    assert not any(name in each.streams for each in read for name in INERTIAL)
    for one, other in zip(first, again, strict=True):
        assert one.case.path is other.case.path
        times = case.time[None, 20:-20]
        motion = real(one.case.recording, "auto", case.gravity)
        assert motion is not None
        expected = replace(one.case, path=motion).motion_at(times)
        np.testing.assert_array_equal(one.case.motion_at(times).a, expected.a)
