"""Several recordings of one object, from logs to one estimate: what each keeps of its
own, what is said of which, and which contradict the others."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from disturbances import NOISE, body
from hefting import InputError, calibrate, identify
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.recording import Recording
from hefting.core.spatial import pose_matrix
from hefting.estimators import METHODS, OLS
from hefting.identification.compare import compare
from hefting.identification.contradictions import contradictions
from hefting.identification.estimator import known_of
from hefting.ingest.joint import JointIngested, ingest_all, names_of
from hefting.shapes import Shape
from hefting.simulation import UR5, random_smooth, simulate

pytestmark = pytest.mark.usefixtures("same_recordings")

MASS = 1.347
UNTIL = "mass=2%,com=5mm,inertia=200%"


@cache
def recording(
    seed: int, mass: float = MASS, sign: float = 1.0, noise: float = 1.0
) -> Recording:
    """Five seconds, with a bias of up to 20 N on each axis and a clock offset of its
    own."""
    rng = np.random.default_rng([16, 7, seed])
    motion = UR5.motion(random_smooth(5.0, 100.0, 1.2, seed=seed))
    levels = replace(NOISE, force=noise * NOISE.force, torque=noise * NOISE.torque)
    log = simulate(
        motion, body(mass), noise=levels, pose_noise=(1e-4, 3.5e-4), seed=seed
    )
    wrench, bias = log["wrench"], rng.uniform(-1.0, 1.0, 6) * np.repeat((20.0, 1.0), 3)
    wrench = replace(
        wrench,
        values=sign * (wrench.values + bias),
        time=wrench.time + 0.005 * (seed % 3),
    )
    return replace(
        log, streams={**log.streams, "wrench": wrench}, source=f"run{seed}.csv"
    )


def deviations(found: Estimate, mass: float = MASS) -> float:
    """Largest difference of mass and COM from the truth, over half of the interval that
    faces it, in standard deviations."""
    assert found.intervals is not None
    true = np.array((mass, *body(mass).center_of_mass))
    p = found.parameters
    own = np.array((p.mass, *p.center_of_mass))
    low, high = np.column_stack(
        (found.intervals["mass"], found.intervals["center_of_mass"])
    )
    half = np.where(true > own, high - own, own - low) / 1.96
    return float((np.abs(own - true) / half).max())


def test_each_recording_keeps_its_bias_clock_and_sign():
    logs = [recording(1), recording(2, sign=-1.0), recording(3)]
    found = identify(logs).estimate
    assert deviations(found) < 4.0
    assert found.verdict.level == "good"
    each = found.provenance["recordings"]
    assert [one["name"] for one in each] == ["run1.csv", "run2.csv", "run3.csv"]
    assert [one["wrench"] for one in each] == ["on-object", "on-sensor", "on-object"]
    for i, (one, log) in enumerate(zip(each, logs, strict=True), start=1):
        alone = identify(log).estimate
        # 1 % of the load moves a bias by 0.1 N; 0.3 ms is the deviation of an offset
        np.testing.assert_allclose(found.bias[i - 1], alone.bias, atol=0.15)
        assert one["clock_offset"] == alone.provenance["clock_offset"]
        assert one["clock_offset"] == pytest.approx(0.005 * (i % 3), abs=2e-3)
    assert found.samples == sum(one["samples"] for one in each)
    assert found.duration == pytest.approx(sum(one["duration"] for one in each))


def test_more_recordings_make_it_surer():
    """White noise: three times as much leaves at most 0.7 of the width that one has
    where no error of the sensor, which all share, is allowed for."""
    widths = [
        np.ptp(
            identify(logs, sensor_accuracy="0%").estimate.intervals["center_of_mass"],
            axis=0,
        )
        for logs in (recording(1), [recording(i) for i in (1, 2, 3)])
    ]
    assert (widths[1] < 0.8 * widths[0]).all()


def test_a_list_of_one_is_that_one():
    alone, listed = identify(recording(1)).estimate, identify([recording(1)]).estimate
    np.testing.assert_array_equal(alone.parameters.vector, listed.parameters.vector)
    assert alone.warnings == listed.warnings


def test_least_squares_is_that_of_each_weighed_by_its_information():
    found = ingest_all([recording(1), recording(2)])
    assert isinstance(found, JointIngested)
    estimator = OLS("estimate", found.fit.noise, intervals=False)
    parts = [estimator.fit(part.measurements) for part in found.parts]
    G = [np.linalg.inv(each.covariance) for each in parts]
    mean = np.linalg.solve(
        sum(G),
        sum(g @ each.parameters.vector for g, each in zip(G, parts, strict=True)),
    )
    std = np.sqrt(np.linalg.inv(sum(G)).diagonal())
    joint = identify([recording(1), recording(2)], method="OLS").estimate
    # 1e-6: rounding of inverses of information of condition 1e8
    np.testing.assert_allclose((joint.parameters.vector - mean) / std, 0.0, atol=1e-6)
    np.testing.assert_allclose((found.fit.vector - mean) / std, 0.0, atol=1e-6)


def test_a_noisier_recording_weighs_less():
    """Ten times the noise: a hundredth of the weight, within what five seconds tell of
    their noise and what errors of the motion add."""
    found = ingest_all([recording(1), recording(2, noise=10.0)])
    first, second = (part.measurements.weights.mean() for part in found.parts)
    assert 30.0 < first / second < 150.0
    rows = [len(part.measurements) for part in found.parts]
    assert np.average((first, second), weights=rows) == pytest.approx(1.0)
    even = ingest_all([recording(1), recording(3)])
    assert even.parts[0].measurements.weights.mean() == pytest.approx(1.0)


def test_all_methods_take_several():
    points = body(1.0).center_of_mass + np.random.default_rng(3).uniform(
        -0.08, 0.08, (80, 3)
    )
    shape = Shape(points, labels=np.digitize(points[:, 2], (0.06, 0.1)))
    found = compare([recording(1), recording(2)], shape)
    assert set(METHODS) - {"HPS"} <= set(found.results)
    for name, estimate in found.results.items():
        assert estimate.bias.shape == (2, 6), name
        if name in ("Bayes", "OLS", "LMI", "RTLS"):
            assert deviations(estimate) < 4.0, name
    assert found.recommended in found.results


def test_an_accuracy_asked_for_is_reached_in_as_many_recordings_as_it_takes():
    logs = [recording(1), recording(2)]
    quick = identify(logs, until=UNTIL).estimate
    assert quick.sufficient
    assert quick.provenance["used"] < 5.0 < quick.provenance["of"]
    logs = [log.slice(0.0, 2.0) for log in logs]
    alone = identify(logs[0], until="mass=0.001%").estimate
    never = identify(logs, until="mass=0.001%").estimate
    assert not never.sufficient
    assert never.provenance["used"] == never.provenance["of"]
    assert never.accuracy.mass < alone.accuracy.mass


def test_static_poses_and_a_motion_go_together():
    still = recording(4)
    rows = slice(0, None, 25)
    streams = {
        k: replace(
            s,
            time=None if s.time is None else s.time[rows],
            values=s.values[rows],
            rows=s.rows[rows],
        )
        for k, s in still.streams.items()
    }
    assert identify(
        [recording(1), replace(still, streams=streams)]
    ).estimate.bias.shape == (2, 6)


# which recording is meant


def test_the_one_that_contradicts_the_others_is_named_and_no_other():
    logs = [recording(1), recording(2), recording(3, mass=1.0), recording(4)]
    found = identify(logs).estimate
    said = [m for m in found.warnings if "recordings-contradict" in codes([m])]
    assert len(said) == 1
    assert said[0].startswith("run3.csv contradicts the others: mass 1.0")
    assert said[0].recordings == ("run3.csv",)
    assert found.verdict.level == "do not use"
    both = identify([recording(1), recording(3, mass=1.0)]).estimate
    (one,) = (m for m in both.warnings if "recordings-contradict" in codes([m]))
    assert set(one.recordings) == {"run1.csv", "run3.csv"}


def test_two_that_contradict_are_named_one_after_the_other():
    logs = [recording(i) for i in (1, 2, 4, 5)]
    logs += [recording(3, mass=1.0), recording(6, mass=2.0)]
    found = contradictions(ingest_all(logs))
    assert [each.name for each in found] == ["run6.csv", "run3.csv"]
    assert all(each.agreement.largest.deviations > 10.0 for each in found)


def test_recordings_of_one_object_do_not_contradict():
    """Ten recordings, in one of a thousand sets by chance."""
    assert not contradictions(ingest_all([recording(i) for i in range(1, 11)]))


def test_recordings_of_one_sensor_do_not_differ_by_its_gain():
    """Masses 1.5 % apart, some 4.5 standard deviations: with a gain of its own for each
    recording they would be 3 apart."""
    assert contradictions(ingest_all([recording(1), recording(3, mass=1.015 * MASS)]))
    logs = [recording(1), recording(3, mass=1.01 * MASS)]
    assert not contradictions(ingest_all(logs))
    found = identify(logs, method="OLS", sensor_accuracy="0.0001%")
    assert "recordings-contradict" in codes(found.warnings)


def test_one_that_is_turned_about_its_com_contradicts_the_shape():
    """A rod, once held across: mass and COM are the same, the inertia is not."""

    def rod(seed: int, sides: tuple[float, float, float]) -> Recording:
        square = np.square(sides)
        inertia = MASS / 12.0 * np.diag(square.sum() - square)
        held = InertialParameters.from_com(MASS, (0.0, 0.0, 0.1), inertia)
        motion = UR5.motion(random_smooth(5.0, 100.0, 0.9, seed=seed))
        log = simulate(motion, held, noise=NOISE, pose_noise=(1e-4, 3.5e-4), seed=seed)
        return replace(log, source=f"run{seed}.csv")

    sides = np.array((0.24, 0.03, 0.03))
    logs = [rod(1, tuple(sides)), rod(2, tuple(sides)), rod(3, tuple(sides[[1, 0, 2]]))]
    trimesh = pytest.importorskip("trimesh")
    shape = Shape.from_mesh(
        trimesh.creation.box(sides), pose=pose_matrix((0, 0, 0.1, 0, 0, 0, 1))
    )
    assert identify(logs[:2], shape).verdict.level == "good"
    found = identify(logs, shape)
    (said,) = (m for m in found.warnings if "alone contradicts the shape" in m)
    assert codes([said]) == {"recordings-contradict"}
    assert said.recordings == ("run3.csv",)


def test_messages_say_which_recording_they_are_about(tmp_path):
    stuck = recording(2)
    wrench = stuck["wrench"]
    values = wrench.values.copy()
    values[100:110] += 400.0
    streams = {**stuck.streams, "wrench": replace(wrench, values=values)}
    logs = [recording(1), replace(stuck, streams=streams), recording(3)]
    found = identify(logs).estimate
    notes = found.provenance["notes"]
    (spikes,) = (n for n in notes if n.code in ("spikes", "contact", "outliers"))
    assert spikes.startswith("run2.csv: ")
    assert spikes.recordings == ("run2.csv",)
    # the same of all is said once, without a name
    gone = [n for n in notes if n.code == "wrench-outside-poses"]
    assert all(not n.recordings or len(n.recordings) < 3 for n in gone)
    path = tmp_path / "found.json"
    found.save(path)
    again = Estimate.load(path)
    np.testing.assert_array_equal(again.bias, found.bias)
    kept = next(n for n in again.provenance["notes"] if n == spikes)
    assert kept.recordings == ("run2.csv",)
    assert again.common_bias is None


def test_names_tell_recordings_apart():
    assert names_of(["a/run.csv", "b/other.csv"]) == ["run.csv", "other.csv"]
    assert names_of(["a/run.csv", "b/run.csv"]) == ["a/run.csv", "b/run.csv"]
    assert names_of(["arrays", "arrays"]) == ["arrays (1)", "arrays (2)"]


# what one tells and another does not, and what is refused


def test_a_bias_for_each_or_one_for_all():
    logs = [recording(1), recording(2)]
    free = identify(logs, method="OLS").estimate
    signs = np.array([1.0, 1.0])
    given = identify(logs, method="OLS", bias=signs[:, None] * free.bias).estimate
    assert given.bias is None
    # the bias is its estimate: least squares stays where it was
    off = (given.parameters.vector - free.parameters.vector) / np.sqrt(
        free.covariance.diagonal()
    )
    assert np.abs(off).max() < 0.2
    with pytest.raises(InputError, match="3 biases for 2 recordings"):
        identify(logs, bias=np.zeros((3, 6)))


def test_of_those_that_fail_together_the_one_that_is_wrong_alone_is_named():
    right, *wrong = recording(1), recording(2, sign=-1.0), recording(3, sign=-1.0)
    said = ": no positive mass explains the wrench; check"
    with pytest.raises(InputError, match=f"^run2.csv{said}"):
        identify([right, *wrong], sign="on-object", bias="estimate")
    with pytest.raises(InputError, match=f"^run2.csv, run3.csv{said}"):
        identify(wrong, sign="on-object", bias="estimate")


def test_nothing_and_the_same_twice_are_refused(tmp_path):
    with pytest.raises(InputError, match="no recording is given"):
        identify([])
    with pytest.raises(
        InputError, match=r"same samples as .*; give each recording once$"
    ):
        identify([recording(1), recording(1)])
    path = tmp_path / "log.csv"
    path.write_text("")
    with pytest.raises(InputError, match=r"log.csv: is given twice; .* once$"):
        identify([path, tmp_path / "." / "log.csv"])
    copy = replace(recording(1), source="copy")
    same = "copy: holds the same samples as .*; give each recording once$"
    with pytest.raises(InputError, match=same):
        identify([recording(1), recording(2), copy])


def test_a_tool_is_subtracted_from_each():
    """A tool of 0.4 kg in each, measured in another recording."""
    tool = calibrate(recording(7, mass=0.4))
    found = identify([recording(1), recording(2)], tool=tool).estimate
    less = body(MASS).vector - body(0.4).vector
    off = (found.parameters.mass - less[0]) / (np.ptp(found.intervals["mass"]) / 3.92)
    assert abs(off) < 4.0
    known = known_of(ingest_all([recording(1), recording(2)], tool=tool), None)
    alone = [known_of(ingest_all(recording(i), tool=tool), None) for i in (1, 2)]
    # the tool's error is the same in all recordings: more of them do not lessen it
    assert known.systematic[0, 0] > 0.9 * tool.covariance[0, 0]
    assert known.systematic[0, 0] < max(each.systematic[0, 0] for each in alone)
