"""Rival explanations by what poses, time and gravity were taken for."""

import re
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import orientation
from benchmarks.mistaken import mistakes
from benchmarks.mistaken_poses import lever, position_axes, positions, time_scaled
from benchmarks.mistaken_wrenches import (
    low_passed,
    tcp,
    turned,
)
from scipy.spatial.transform import Rotation

from given_cases import case_of, correct, mistake, with_coloured_noise
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.spatial import WRENCH
from hefting.identification import identify
from hefting.ingest import condition
from hefting.ingest.ingest import ingest
from hefting.ingest.rivals import (
    axes_turned,
    placement,
    units,
)
from hefting.ingest.rivals.consequence import doubt_of
from hefting.ingest.rivals.explanation import as_given
from hefting.ingest.rivals.judge import evidence, judge_one
from hefting.logs import read_log
from hefting.logs.orientations import with_sensor_pose
from hefting.logs.units import find_unit
from hefting.simulation import UR5, hammer, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("ratio", [2.5, 4.0])
def test_rates_that_are_mistaken_are_told(ratio):
    given = time_scaled(1.0 / ratio)(correct(1), np.random.default_rng(1))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.code == "time-unit"


@pytest.mark.parametrize("ratio", [2.5, 4.0])
def test_time_that_is_as_likely_as_a_payload_is_told_beside_it(ratio):
    """As of 500 Hz taken for 125: what is left of mass and first moment is alike."""
    given = time_scaled(ratio)(correct(1), np.random.default_rng(1))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.code == "wrench-compensated"
    assert f"time runs {ratio:.2g}" in doubt.message


def test_a_lever_is_found_beside_a_filter(monkeypatch):
    """Of 0.8 Hz and before the noise, whose lag is found as that of a clock: neither
    explains enough alone."""
    monkeypatch.setattr("hefting.ingest.rivals.judge.EXPLANATIONS", ())
    rng = np.random.default_rng(1)
    given = tcp(0.15)(low_passed(0.8)(correct(1), rng), rng)
    noise = rng.normal(size=(1000, 6)) * np.repeat((0.1, 0.005), 3)
    given = given.wrench(lambda _, w: w + noise)
    named = judge_one(case_of(given, 0.2)).named
    assert named is not None
    assert named.code == "lever-arm"
    assert judge_one(case_of(given)).named is None


def test_a_lever_is_named_beside_coloured_noise():
    """It explains half of what is no noise, though not of what is no white noise."""
    moved = tcp(0.15)(correct(0), np.random.default_rng(1))
    doubt = doubt_of(case_of(with_coloured_noise(moved, 0.5)))
    assert doubt is not None
    assert doubt.message.code == "lever-arm"
    assert doubt.is_fatal


def test_what_was_given_for_nothing_is_to_be_left_out():

    for given in ({"sensor_turned": "z:90"}, {"sensor_pose_in_log": "0,0,0.1,0,0,0,1"}):
        found = identify(correct(0).recording, **given).estimate
        (reason,) = found.verdict.reasons
        assert reason.code in ("axes-turned", "lever-arm")
        assert "leave out the pose of the sensor that was given" in reason


def test_an_accelerometer_is_not_moved_by_a_pose_of_the_sensor():
    """It stays where it is, so no pose is advised."""
    clean = correct(1, imu=True)
    streams = dict(clean.recording.streams)
    del streams["position"]
    alone = replace(clean, recording=replace(clean.recording, streams=streams))
    z = np.array((0.0, 0.0, 1.0))
    said = turned(z, 30.0)(alone, np.random.default_rng(1))
    doubt = doubt_of(case_of(said))
    assert doubt is not None
    assert doubt.message.code == "axes-turned"
    assert "in the same axes" in doubt.message
    assert "sensor_" not in doubt.message


def test_axes_of_positions_are_told_as_what_was_logged():
    """Logged (y, z, x): x, y and z are the third, first and second of them."""
    change = position_axes((0, 1, 0), (0, 0, 1), (1, 0, 0))
    doubt = doubt_of(case_of(change(correct(1), np.random.default_rng(1))))
    assert doubt is not None
    assert doubt.message.code == "position-axes"
    assert "(z, x, y) of those logged" in doubt.message


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_time_in_another_unit_makes_the_answer_wrong(seed):
    """Also where mass and COM are right: the inertia is four times too large."""
    given = time_scaled(2.0)(correct(seed), np.random.default_rng(1))
    offset = condition(given.recording, changes=False).offset
    doubt = doubt_of(case_of(given, offset))
    assert doubt is not None
    assert doubt.message.code == "time-unit"
    assert doubt.is_fatal
    assert "2 times too fast" in doubt.message


def test_a_real_part_read_as_the_first_is_told():
    """Columns q1 to q4 are read as of ABB, but many a program logs x, y, z, w so."""
    given = correct(1)
    streams = given.recording.streams
    logged = streams["orientation"]
    read = replace(logged, values=np.roll(logged.values, -1, axis=1))
    recording = replace(given.recording, streams={**streams, "orientation": read})
    doubt = doubt_of(case_of(replace(given, recording=recording)))
    assert doubt is not None
    assert doubt.message.code == "quaternion-order"
    assert doubt.is_fatal
    assert "logged as x, y, z, w" in doubt.message
    assert 'form = "xyzw"' in doubt.message


@pytest.mark.parametrize("column", range(3))
def test_an_angle_in_radians_beside_degrees_is_told_by_its_number(column):
    given = correct(1)
    read, streams = orientation(given).as_euler("xyz"), given.recording.streams
    read[:, column] = np.radians(read[:, column])
    first = streams["orientation"]
    q = replace(first, values=Rotation.from_euler("xyz", read).as_quat())
    recording = replace(
        given.recording,
        angles=replace(first, values=read),
        streams={**streams, "orientation": q},
    )
    doubt = doubt_of(case_of(replace(given, recording=recording)))
    assert doubt is not None
    assert doubt.is_fatal
    assert f"but number {column + 1} in radians" in doubt.message


@pytest.mark.parametrize(
    ("names", "form", "order"),
    [
        ("a,b,c", "rpy", "xyz"),
        ("RX,RY,RZ", "euler", "XYZ"),
        ("a,b,c", "euler", "ZYZ"),
    ],
)
def test_the_form_of_angles_is_told_and_put_right_as_advised(
    tmp_path, names, form, order
):
    """Read as KUKA's angles, and as a rotation vector. They wrap, so that poses were left
    out as glitches."""
    given, columns = correct(1), names.split(",")
    streams = given.recording.streams
    angles = orientation(given).as_euler(order, degrees=True)
    log = tmp_path / "log.csv"
    np.savetxt(
        log,
        np.hstack(
            (
                streams["wrench"].time[:, None],
                1e3 * streams["position"].values,
                angles,
                streams["wrench"].values,
            )
        ),
        delimiter=",",
        header=f"Time,X,Y,Z,{names},Fx,Fy,Fz,Mx,My,Mz",
        comments="",
    )
    found = identify(log)
    (reason,) = (r for r in found.verdict.reasons if r.code == "orientation-form")
    said = f'form = "{form}"' + (f', order = "{order}"' if form == "euler" else "")
    assert f"give {said} of the orientation" in reason
    (tmp_path / "map.toml").write_text(
        'time = "Time"\nwrench = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]\n'
        'position = { columns = ["X", "Y", "Z"], unit = "mm" }\n'
        f'orientation = {{ columns = {columns}, {said}, unit = "deg" }}\n'
    )
    assert (
        identify(read_log(log, column_map=tmp_path / "map.toml")).verdict.level
        == "good"
    )


def test_the_form_of_angles_is_told_where_most_poses_are_in_doubt():
    """Roll, pitch, yaw read as a rotation vector, which wraps: what is left of the motion
    is so wrong that next to none of its samples counts."""
    (mistake,) = (m for m in mistakes() if m.strength == "roll, pitch, yaw")
    found = identify(mistake.make(correct(2), np.random.default_rng([16, 2])).recording)
    assert found.verdict.level == "do not use"
    assert found.verdict.reasons[0].code == "orientation-form"


@pytest.mark.parametrize("seed", range(3))
def test_a_turn_is_found_with_its_deviation(seed):
    """About a random axis, from 2° to 180°; off by less than 3.86 deviations, which all
    of three Gaussian vectors of three are but for one time in 180."""
    rng = np.random.default_rng([3, seed])
    axis = rng.normal(size=3)
    angle = np.radians(rng.uniform(2.0, 180.0))
    R = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    given = correct(seed).wrench(
        lambda _, w: np.hstack((R.apply(w[:, :3]), R.apply(w[:, 3:])))
    )
    case = case_of(given)
    found = axes_turned.rotation_of(case)
    # the wrench was turned by R, so its axes were turned by the inverse
    apart = (Rotation.from_matrix(found.R) * R).as_rotvec()
    distance = apart @ np.linalg.solve(found.covariance, apart)
    assert distance < 14.9
    assert np.degrees(np.linalg.norm(apart)) < 3.0
    judged = judge_one(case)
    assert judged.named is not None
    assert judged.named.code == "axes-turned"


def test_what_is_proposed_for_a_turn_puts_it_right():
    """The COM after `sensor_turned` as without the mistake, to a millimetre."""
    from hefting.core.quantity import turned_about

    clean = correct(0)
    turned = mistake("turned about z", "30°").make(clean, np.random.default_rng(1))
    said = doubt_of(case_of(turned))
    assert said is not None
    assert "`sensor_turned`='z:-30'" in said.message
    mended = with_sensor_pose(turned.recording, turned_about("z:-30"))
    # what the mistake turned were the axes the COM is given in
    there = Rotation.from_euler("z", np.radians(30.0)).apply(clean.truth.center_of_mass)
    found = identify(mended).estimate
    assert not any(getattr(m, "code", "") == "axes-turned" for m in found.warnings)
    np.testing.assert_allclose(found.parameters.center_of_mass, there, atol=1e-3)


def test_nothing_is_advised_about_a_shape_beside_a_mistake_that_explains_it():
    """The shape's pose and unit had been doubted, which were right."""
    given = mistake("turned about z", "90°").make(correct(1), np.random.default_rng(1))
    found = identify(given.recording, given.shape).estimate
    assert [reason.code for reason in found.verdict.reasons] == ["axes-turned"]


def test_a_gripper_that_nobody_mentioned_may_put_the_com_outside_a_shape():
    make = mistake("gripper not mentioned", "0.8 kg").make
    given = make(correct(1), np.random.default_rng(1))
    reasons = identify(given.recording, given.shape).estimate.verdict.reasons
    assert {r.code for r in reasons} == {
        "com-outside-shape",
        "shape-contradicts-wrench",
    }
    assert all("`tool`" in reason for reason in reasons)


MIRRORED = {
    "an axis": np.diag((1.0, -1.0, 1.0)),
    "two swapped": np.eye(3)[[1, 0, 2]],
}


@pytest.mark.parametrize("what", MIRRORED)
@pytest.mark.parametrize("on_object", [True, False])
def test_half_a_turn_is_told_beside_mirrored_axes_of_the_other_sign(what, on_object):
    """Of both the wrench is the same: with the columns as advised the COM is the true
    one, and with the turn it is another, in answers called good."""
    clean = correct(1)
    axes = np.kron(np.eye(2), MIRRORED[what])
    sign = 1.0 if on_object else -1.0  # as recorded it is on the object
    given = clean.wrench(lambda _, w: sign * w @ axes.T)
    said = doubt_of(case_of(given))
    assert said is not None
    assert said.message.code == "axes-turned"
    told = re.search(
        r"if the wrench acts on the (\w+), its columns as \[(.*?)\]", said.message
    )
    assert told is not None
    acts, names = told.groups()
    assert acts == ("object" if on_object else "sensor")
    columns = np.zeros((6, 6))
    for row, name in enumerate(names.replace('"', "").split(", ")):
        columns[row, WRENCH.index(name.lstrip("-"))] = -1.0 if "-" in name else 1.0
    mended = given.wrench(lambda _, w: w @ columns.T).recording
    found = identify(mended, sign=f"on-{acts}").estimate
    assert found.verdict.level == "good"
    np.testing.assert_allclose(
        found.parameters.center_of_mass, clean.truth.center_of_mass, atol=1e-3
    )


def test_a_turn_that_is_no_half_one_is_told_alone():
    turn = mistake("turned about z", "90°").make(correct(0), np.random.default_rng(1))
    said = doubt_of(case_of(turn))
    assert said is not None
    assert "acts on" not in said.message


TURNED_AND_MOVED = [("z", -90.0, 0.12), ("x", 30.0, 0.05), ("y", 180.0, 0.04)]


@pytest.mark.parametrize("said", [None, "z:45"])
@pytest.mark.parametrize(("axis", "degrees", "behind"), TURNED_AND_MOVED)
def test_a_sensor_that_is_turned_and_moved_takes_one_advice(
    axis, degrees, behind, said
):
    """`sensor_pose_in_log` as advised, also beside a wrong pose that was given, leaves
    nothing to be said, and mass and COM as without the mistake."""

    clean = correct(1)
    rng = np.random.default_rng(1)
    unit = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[axis]
    given = lever(behind)(turned(np.array(unit), degrees)(clean, rng), rng)
    found = identify(given.recording, sensor_turned=said).estimate
    assert found.verdict.level == "do not use"
    (reason,) = (r for r in found.verdict.reasons if r.code == "axes-turned")
    pose = str(reason).split("`sensor_pose_in_log`='")[1].split("'")[0]
    mended = identify(given.recording, sensor_pose_in_log=pose).estimate
    assert mended.verdict.level == "good"
    R = Rotation.from_euler(axis, np.radians(degrees))
    there = R.apply(clean.truth.center_of_mass)
    # of a lever that is known to some millimetres, a turn to some tenths of a degree
    np.testing.assert_allclose(mended.parameters.center_of_mass, there, atol=3e-3)
    assert mended.parameters.mass == pytest.approx(clean.truth.mass, rel=0.01)


@pytest.mark.parametrize("axis", np.eye(3))
def test_a_turn_that_explains_too_little_alone_is_tried_beside_a_lever(axis):
    """By 20° and 0.4 m, of which either explains less than half: nothing was named."""
    rng = np.random.default_rng(1)
    judged = judge_one(case_of(lever(0.4)(turned(axis, 20.0)(correct(0), rng), rng)))
    assert judged.named is not None
    assert judged.named.code == "axes-turned"
    assert "sensor_pose_in_log" in judged.named.fix


def test_a_lever_is_found_with_its_deviation():
    """5 cm along z; its deviation there is a few millimetres."""
    given = mistake("flange behind sensor", "50 mm").make(
        correct(2), np.random.default_rng(1)
    )
    case = case_of(given)
    found = placement.explain_lever(case)
    assert found is not None
    assert evidence(case, as_given(case), found) > 12.0
    point = np.array(found.fix.split("'")[1].split(",")[:3], dtype=float)
    np.testing.assert_allclose(point, (0.0, 0.0, 0.05), atol=0.015)


@pytest.mark.parametrize(
    ("unit", "metres"),
    [
        ("millimetres", 0.001),
        ("centimetres", 0.01),
        ("inches", 0.0254),
        ("feet", 0.3048),
    ],
)
def test_positions_in_another_unit_are_named_by_it(unit, metres):
    given = positions(1.0 / metres)(correct(2), np.random.default_rng(1))
    found = units.explain_position(case_of(given))
    assert found is not None
    assert found.what == f"the positions seem to be in {unit}"
    said = re.search(r'unit = "(.*?)"', found.fix)
    assert said is not None
    size = find_unit(said[1], "length", "here").to_si(np.ones(1))[0]
    assert size == pytest.approx(metres)


@pytest.mark.parametrize(
    ("gravity", "told"),
    [
        ((0.0, -9.80665, 0.0), "`gravity`='0,-9.80665,0'"),
        ((9.80665, 0.0, 0.0), "`gravity`='9.80665,0,0'"),
    ],
)
def test_gravity_far_from_the_one_given_is_told_in_numbers(gravity, told):
    """Looked for from the one given it may be found the other way round. Near an axis
    of the world it is along it."""
    motion = UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=3))
    noise = NOISE_LEVELS["moderate"]
    recording = simulate(motion, hammer().parameters, gravity, noise=noise, seed=3)
    (said,) = (m for m in ingest(recording).warnings if m.code == "base-tilted")
    assert f"give {told}" in said
    found = ingest(recording, gravity=gravity)
    assert not [m for m in found.warnings if m.severity == "error"]


def test_a_sensor_is_not_found_half_a_metre_from_the_logged_frame():
    """As in force in kgf: the first moments by force and torque are then apart by a
    factor."""
    given = mistake("unit of force", "kgf").make(correct(0), np.random.default_rng(1))
    doubt = doubt_of(case_of(given))
    assert doubt is not None
    assert doubt.message.code == "force-unit"
