"""Rival explanations by what the wrench is: its units, axes, channels, gains, payload."""

import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.constants
from benchmarks.mistaken_wrenches import (
    RATE,
    compensated,
    gains,
    mapped,
    units,
)
from scipy.signal import lfilter

from given_cases import case_of, correct, mistake
from hefting.core.errors import InputError
from hefting.core.spatial import STANDARD_GRAVITY, WRENCH
from hefting.identification import identify
from hefting.ingest import condition
from hefting.ingest.filtering import Signal
from hefting.ingest.rivals import (
    axis_flipped,
    placement,
    timing,
)
from hefting.ingest.rivals import units as wrong_units
from hefting.ingest.rivals.consequence import doubt_of
from hefting.ingest.rivals.judge import judge_one
from hefting.logs import read_log, write_log
from hefting.logs.units import find_unit

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("seed", [0, 3, 6])
def test_errors_as_on_a_data_sheet_are_no_mistake(seed):
    """Gains that are 0.4 % apart: of the first recording they were said to be a payload
    that the controller takes away."""
    given = gains(0.004)(correct(seed), np.random.default_rng([77, seed]))
    assert doubt_of(case_of(given)) is None


@pytest.mark.parametrize(
    ("share", "code"), [(0.03, "gain-uneven"), (0.05, "gain-uneven")]
)
def test_gains_that_are_far_apart_are_told_as_such(share, code):
    """And not as cross-talk, which has thirty unknowns more."""
    given = gains(share)(correct(2), np.random.default_rng(1))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.code == code


CHANNELS = {
    "be 0.5 times what the other channels tell": (0, {0: 0.5}),
    "be 0.225 times what the other channels tell, as if in lbf": (
        2,
        {2: 1.0 / 4.4482216},
    ),
    "be 100 times what the other channels tell, as if in N cm": (
        3,
        {3: 100.0},
    ),
    "measure what fz should": (1, {2: 1.0}),
    "measure nothing but noise": (5, {}),
}
"""What is said of a channel that shows so many times what others, or itself, should."""


@pytest.mark.parametrize("said", CHANNELS)
def test_a_channel_that_is_wrong_by_itself_is_told_by_the_others(said):
    """Noise of 0.1 N and 5 mN m leaves gains some 0.3 %: numbers are compared to 2 %."""
    channel, shown = CHANNELS[said]
    given = correct(2)
    load = given.wrench_of(given.truth.vector)
    wrong = sum((gain * load[:, c] for c, gain in shown.items()), np.zeros(len(load)))
    extra = np.outer(wrong - load[:, channel], np.arange(6) == channel)
    doubt = doubt_of(case_of(given.wrench(lambda _, w: w + extra)))
    assert doubt is not None
    assert (doubt.message.code, doubt.message.severity) == ("channel-wrong", "error")
    number = re.compile(r"[\d.]+")
    name, found = str(doubt.message).split(":")[0].split(" seems to ")
    assert name == f"the channel {WRENCH[channel]}"
    assert number.sub("#", found) == number.sub("#", said)
    for one, other in zip(number.findall(found), number.findall(said), strict=True):
        assert float(one) == pytest.approx(float(other), rel=0.02)


def test_a_dead_channel_is_not_taken_for_another():
    """A function of the motion by which noise alone is explained best is below it."""
    doubt = doubt_of(
        case_of(
            mistake("dead channel", "tz").make(correct(0), np.random.default_rng(1))
        )
    )
    assert doubt is not None
    assert "channel tz seems to measure nothing but noise" in doubt.message


APART = {
    "force": np.kron(np.diag((1, 0)), np.eye(3)[[1, 2, 0]])
    + np.diag((0, 0, 0, 1, 1, 1)),
    "torque": np.diag((1, 1, 1, 0, 0, 0))
    + np.kron(np.diag((0, 1)), np.eye(3)[[2, 1, 0]]),
}
"""The force's axes in another order, and the torque's."""


@pytest.mark.parametrize("part", APART)
def test_axes_of_the_force_alone_in_another_order_are_put_right_by_the_columns(part):
    """Both change the answer by far more than the 1 % of the mass that is left."""
    given = mapped(APART[part])(correct(2), np.random.default_rng(1))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.severity == "error"
    undo = [WRENCH.index(name) for name in re.findall(r'"(\w+)"', str(doubt.message))]
    assert np.array_equal(APART[part][undo], np.eye(6))


@pytest.mark.parametrize("order", [1, 2])
def test_a_low_pass_filter_is_that_of_scipy(order):
    """At a fiftieth of the sampling rate the bilinear transform differs by
    (pi / 50)² / 3 = 0.13 %, and by as much again in phase over a few oscillations."""
    from scipy.signal import butter

    time = np.arange(0.0, 10.0, 0.01)
    values = np.column_stack([np.sin(f * time) for f in (2.0, 9.0)])
    b, a = butter(order, 2.0, fs=100.0)
    found = timing.low_passed(Signal(values, 100.0), order, 2.0)
    assert np.abs(found - lfilter(b, a, values, axis=0)).max() < 0.01


@pytest.mark.parametrize("seconds", [0.05, 0.08, 0.15])
def test_a_filter_is_no_liquid_and_is_corrected_whatever_noise_is_behind_it(seconds):
    """A filter of first order, between the bandwidths that are tried: its whole lag is
    the clock offset that was found. Noise of amplifiers and digits is behind it. The
    answer is corrected for such a filter, so that it makes nothing wrong."""
    given = correct(0)
    load = given.wrench_of(given.truth.vector)
    part = 1.0 / (1.0 + seconds * RATE)
    late = lfilter([part], [1.0, part - 1.0], load - load[0], axis=0) + load[0]
    late_given = given.wrench(lambda _, w: w + late - load)
    found = condition(late_given.recording, STANDARD_GRAVITY, changes=False)
    doubt = doubt_of(case_of(late_given, found.offset))
    assert doubt is not None
    assert (doubt.message.code, doubt.is_fatal) == ("wrench-filtered", False)


@pytest.mark.parametrize(
    ("name", "strength"),
    [
        ("gain by load", "0.6% per N"),
        ("soft end of range", "60 N"),
        ("soft mount", "4° per N m"),
    ],
)
def test_of_what_depends_on_the_load_the_mass_is_known(name, strength):
    """To a percent: noise alone leaves 0.1 %, and what the laws leave out the same."""
    given = mistake(name, strength).make(correct(3), np.random.default_rng(1))
    offset = condition(given.recording, STANDARD_GRAVITY, changes=False).offset
    judged = judge_one(case_of(given, offset))
    assert judged.named is not None
    assert judged.given is not None
    mass = given.truth.mass
    assert judged.named.vector[0] == pytest.approx(mass, rel=0.01)
    assert abs(judged.given.vector[0] - mass) > abs(judged.named.vector[0] - mass)


def test_torque_many_times_its_noise_is_told():
    """A spinning rotor in the object: 12 % of the wrench's changes, the least that is
    told by itself, and 13 times the noise of the torque."""
    given = correct(3)
    assert given.exact is not None
    torque = np.cross(given.exact.angular_velocity, (0.0, 0.1, 0.0))
    given = given.wrench(lambda _, w: w + np.hstack((np.zeros_like(torque), torque)))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.code == "unexplained"
    assert not doubt.is_fatal


@pytest.mark.parametrize(
    ("share", "code"),
    [(1.0, "wrench-compensated"), (0.97, "wrench-compensated"), (0.75, "time-unit")],
)
def test_a_payload_that_is_taken_away_is_no_unit_of_time(share, code):
    """It is the same as time that runs too fast: of 75 %, as of time twice as fast, both
    are said; more is a payload, as no sensor is sampled so rarely."""
    doubt = doubt_of(case_of(compensated(share)(correct(1), np.random.default_rng(1))))
    assert doubt is not None
    assert doubt.message.code == code
    assert f"{share:.0%}".replace("%", " %") in doubt.message


@pytest.mark.parametrize("factor", [0.75, 1.25, 1.5])
def test_time_that_runs_a_little_fast_or_slow_is_said_beside_a_payload(factor):
    """As of 125 Hz taken for 100 Hz; accelerations are then weaker by its square."""
    given = correct(1)
    streams = {
        name: replace(stream, time=factor * stream.time)
        for name, stream in given.recording.streams.items()
    }
    recording = replace(given.recording, streams=streams)
    doubt = doubt_of(case_of(replace(given, recording=recording)))
    assert doubt is not None
    assert doubt.message.code == "wrench-compensated"
    found = re.search(r"or time runs ([\d.]+) times too (fast|slow)", doubt.message)
    assert found is not None
    assert found[2] == ("fast" if factor > 1.0 else "slow")
    assert float(found[1]) == pytest.approx(max(factor, 1.0 / factor), rel=0.02)


@pytest.mark.parametrize(
    ("share", "code"),
    [
        (-0.4, "wrench-compensated"),
        (-1.0, "wrench-compensated"),
        (1.3, "wrench-compensated"),
        (1.6, "wrench-compensated"),
        (2.0, "gravity-reversed"),
        (2.5, "wrench-compensated"),
        (6.0, "wrench-compensated"),
        (30.0, "wrench-compensated"),
    ],
)
def test_a_payload_that_is_heavier_than_the_object_or_added_is_named(share, code):
    """And is gravity the wrong way round where it is twice as heavy alone."""
    for seed in (0, 1):
        given = compensated(share)(correct(seed), np.random.default_rng(1))
        doubt = doubt_of(case_of(given))
        assert doubt is not None
        assert doubt.message.code == code
        assert doubt.is_fatal


def test_a_wrong_sign_is_put_right_as_advised(tmp_path):
    """By the columns that the advice gives, of the log as it is."""
    given = mistake("axis flipped", "fz").make(correct(0), np.random.default_rng(1))
    log = tmp_path / "log.csv"
    write_log(given.recording, log)
    (reason,) = (r for r in identify(log).verdict.reasons if r.code == "axis-flipped")
    columns = re.findall(r"\[.*?\]", reason)[0]
    assert columns == '["fx", "fy", "-fz", "tx", "ty", "tz"]'
    (tmp_path / "map.toml").write_text(
        f'time = "time"\nwrench = {columns}\nposition = ["px", "py", "pz"]\n'
        'orientation = ["qx", "qy", "qz", "qw"]\n'
    )
    assert (
        identify(read_log(log, column_map=tmp_path / "map.toml")).verdict.level
        == "good"
    )


def test_no_wrong_sign_is_half_a_turn_with_the_other_sign():
    """About an axis of the sensor: of 7 such turns 2 had been wrong signs of z."""
    for what, matrix, _ in axis_flipped._changes():
        for axis in range(3):
            turn = -np.eye(3)
            turn[axis, axis] = 1.0
            assert not np.array_equal(matrix, -np.kron(np.eye(2), turn)), what


def test_a_torque_is_mirrored_as_a_pseudovector():
    """In the axes of a left-handed system. Where these are the poses', other columns of the
    wrench would give the mirrored body, and had been advised for it."""
    mirrored = [m for m in axis_flipped._changes() if "left-handed" in m[0]]
    assert len(mirrored) == 3
    for what, matrix, _ in mirrored:
        assert "in the poses (then correct these) or" in what
        force, torque = matrix[:3, :3], matrix[3:, 3:]
        assert np.linalg.det(force) == -1.0
        np.testing.assert_array_equal(torque, -force)
        assert not matrix[:3, 3:].any()


SI = {
    "kgf": (scipy.constants.kilogram_force, 1.0),
    "lbf": (scipy.constants.pound_force, 1.0),
    "grams-force": (1e-3 * scipy.constants.kilogram_force, 1.0),
    "N mm": (1.0, scipy.constants.milli),
    "N cm": (1.0, scipy.constants.centi),
    "lbf in": (1.0, scipy.constants.pound_force * scipy.constants.inch),
    "lbf ft": (1.0, scipy.constants.pound_force * scipy.constants.foot),
    "kgf m": (1.0, scipy.constants.kilogram_force),
    "kgf cm": (1.0, scipy.constants.kilogram_force * scipy.constants.centi),
    "ozf in": (1.0, scipy.constants.pound_force / 16.0 * scipy.constants.inch),
    "daN": (10.0, 1.0),
    "kgf and the torque in kgf cm": (
        scipy.constants.kilogram_force,
        scipy.constants.kilogram_force * scipy.constants.centi,
    ),
    "lbf and the torque in lbf in": (
        scipy.constants.pound_force,
        scipy.constants.pound_force * scipy.constants.inch,
    ),
    "lbf and the torque in lbf ft": (
        scipy.constants.pound_force,
        scipy.constants.pound_force * scipy.constants.foot,
    ),
}
"""Units of force and torque in N and N m."""


@pytest.mark.parametrize("unit", SI)
def test_a_unit_is_told_and_gives_the_object_in_newtons(unit):
    force, torque = SI[unit]
    given = units(1.0 / force, 1.0 / torque)(correct(2), np.random.default_rng(1))
    case = case_of(given)
    doubt, found = doubt_of(case), wrong_units.explain_force(case)
    assert doubt is not None
    assert doubt.message.code == "force-unit"
    # beside those that it cannot be told from, as kgf from daN
    assert f" in {unit}" in doubt.message
    assert found is not None
    told = re.search(rf" in {unit} \(then ([\d.]+) kg\)", doubt.message)
    if told is not None:  # by their masses alone
        assert float(told[1]) == pytest.approx(given.truth.mass, rel=0.03)
    else:
        assert "(then" not in doubt.message
        said = re.findall(r'"([\d.e-]+ N(?: m)?)"', doubt.message)
        for text, kind, size in zip(
            said, ("force", "torque"), (force, torque), strict=True
        ):
            size_of = find_unit(text, kind, "here").to_si(np.ones(1))[0]
            assert size_of == pytest.approx(size, rel=1e-5)
    if f" in {unit}" not in found.what.split(",")[0]:
        return
    vector = found.vector / np.sign(found.vector[0])
    # noise of 0.1 N of some 5 N in 1,000 samples, and motion that is not exact
    assert vector[0] == pytest.approx(given.truth.mass, rel=0.02)
    assert vector[1:4] == pytest.approx(given.truth.vector[1:4], abs=0.01)


def test_a_bias_is_composed_of_functions_only_where_it_is_possible():
    """Those of a bias that may drift add up to a constant one."""
    case = case_of(correct(0))
    functions = case.bias_functions
    assert functions.shape[1] >= 1
    np.testing.assert_allclose(functions.sum(axis=1), 1.0, rtol=1e-12)
    none = replace(case, biased=False).bias_functions
    assert none.shape == (len(case.time), 0)


@pytest.mark.parametrize("gain", [0.8, 1.2])
def test_a_gain_of_the_torques_is_told_beside_the_lever_arm_that_does_the_same(gain):
    """A lever arm that is no part of the way to the COM says nothing of a gain."""
    doubt = doubt_of(case_of(units(1.0, gain)(correct(4), np.random.default_rng(1))))
    assert doubt is not None
    assert doubt.is_fatal
    found = re.search(r"or to be ([\d.]+) times what it is", doubt.message)
    assert found is not None
    # the point is known to 1 mm, the COM is 90 mm away
    assert float(found[1]) == pytest.approx(gain, abs=0.03)
    lever = mistake("torque about the TCP", "150 mm")
    doubt = doubt_of(case_of(lever.make(correct(4), np.random.default_rng(1))))
    assert doubt is not None
    assert "times what it is" not in doubt.message


def test_a_lever_arm_to_twice_the_com_is_told_to_be_a_sign_too():
    found = placement.explain_lever(
        case_of(units(1.0, -1.0)(correct(4), np.random.default_rng(1)))
    )
    assert found is not None
    gain = re.search(r"or to be (-[\d.]+) times what it is", found.what)
    assert gain is not None
    assert float(gain[1]) == pytest.approx(-1.0, abs=0.1)


def test_a_force_in_millinewtons_is_told_by_the_mass_that_it_would_need():
    """A lever to the COM explains it as well, and leaves the object as heavy."""

    given = correct(0).wrench(lambda _, w: w * np.repeat((1e3, 1.0), 3))
    with pytest.raises(InputError, match=r"the force would need .* give it in newtons"):
        identify(given.recording)
