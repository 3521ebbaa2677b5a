"""Tool subtraction: what is left is the object's, with the tool's uncertainty in its
own."""

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hefting import Shape
from hefting import identify as front
from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import codes
from hefting.identification import calibrate, identify
from hefting.identification.identify import _is_within_noise
from hefting.ingest.tool import load_tool, with_tool
from hefting.simulation import UR5, simulate
from hefting.simulation.joints import random_smooth

pytestmark = pytest.mark.usefixtures("same_recordings")

NOISE = Noise(0.1, 0.005)
BIAS = (3.0, -2.0, 5.0, 0.1, -0.2, 0.05)


def block(mass, com, sides):
    x, y, z = np.square(sides)
    return InertialParameters.from_com(
        mass, com, mass / 12 * np.diag([y + z, x + z, x + y])
    )


GRIPPER = block(1.0, (0.0, 0.005, 0.05), (0.1, 0.06, 0.1))
OBJECT = block(0.25, (0.01, 0.0, 0.14), (0.06, 0.05, 0.12))
NEAR = (-0.05, 0.05, -0.05, 0.05, 0.0, 0.2)
"""[m] Box about the sensor."""
BOTH = InertialParameters(GRIPPER.vector + OBJECT.vector)


@cache
def motion(duration, seed):
    return UR5.motion(random_smooth(duration, 100.0, 1.0, seed=seed))


def log(body, duration, seed, noise=NOISE, **others):
    return simulate(
        motion(duration, seed), body, noise=noise, bias=BIAS, seed=seed, **others
    )


def errors(body):
    """Of mass [kg], COM [m] and inertia about the sensor [kg m²]."""
    return (
        body.mass - OBJECT.mass,
        np.linalg.norm(body.center_of_mass - OBJECT.center_of_mass),
        np.linalg.norm(body.inertia_at_origin - OBJECT.inertia_at_origin),
    )


def beside_a_gripper(seed):
    """Estimates of the object alone, and with a gripper that has a recording of its
    own, four times as long."""
    tool = calibrate(log(GRIPPER, 40.0, 3000 + seed))
    settings = {"method": "OLS", "bias": "estimate", "sensor_accuracy": "0%"}
    alone = identify(log(OBJECT, 10.0, seed), **settings).estimate
    both = identify(log(BOTH, 10.0, 1000 + seed), tool=tool, **settings)
    return alone, both.estimate


@pytest.mark.usefixtures("nothing_looked_for")
def test_object_beside_a_gripper_is_nearly_as_well_known_as_alone():
    """At most 1.7 times the errors; two hundred seeds: `python -m benchmarks.tool`.

    Of 5 seeds an RMS ratio scatters by a factor of 1.5 or so, and |z| < 1.96 in 85 to
    100 % of 50 parameters that are correlated within a seed.
    """
    pairs = [beside_a_gripper(seed) for seed in range(5)]
    alone, beside = (
        np.sqrt(np.mean([np.square(errors(pair[i].parameters)) for pair in pairs], 0))
        for i in (0, 1)
    )
    z = [
        (two.parameters.vector - OBJECT.vector) / np.sqrt(two.covariance.diagonal())
        for _, two in pairs
    ]
    print(
        f"ratio {(beside / alone).round(2)}, rms z {np.sqrt(np.mean(np.square(z))):.2f}"
    )
    assert (beside <= 1.7 * alone).all()
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.35
    assert np.mean(np.abs(z) < 1.96) > 0.85


def test_subtraction_is_exact_without_noise():
    exact = {"noise": Noise(), "pose_noise": (0.0, 0.0), "exact": True}
    tool = calibrate(log(GRIPPER, 5.0, 1, **exact))
    found = identify(log(BOTH, 5.0, 2, **exact), method="OLS", tool=tool).estimate
    # rounding over 1 kg and 20 N
    np.testing.assert_allclose(found.parameters.vector, OBJECT.vector, atol=1e-9)
    np.testing.assert_allclose(found.bias, BIAS, atol=1e-8)


def test_the_sign_of_the_log_does_not_matter():
    """Gripper and object may even be recorded with different signs: the tool is known
    in the project's."""
    tool = calibrate(log(GRIPPER, 5.0, 1, on_sensor=True))
    one = identify(log(BOTH, 5.0, 2), method="OLS", tool=tool).estimate
    recording = log(BOTH, 5.0, 2)
    wrench = recording["wrench"]
    flipped = replace(
        recording,
        streams={**recording.streams, "wrench": replace(wrench, values=-wrench.values)},
    )
    two = identify(flipped, method="OLS", tool=tool).estimate
    # the same equations
    np.testing.assert_allclose(two.parameters.vector, one.parameters.vector, atol=1e-9)
    assert one.parameters.mass == pytest.approx(0.25, abs=0.01)


def test_covariances_add():
    """Parameters in one frame add, and their errors are independent."""
    tool, recording = calibrate(log(GRIPPER, 10.0, 1)), log(BOTH, 10.0, 2)
    sure = replace(tool, covariance=np.zeros((10, 10)))
    one = identify(recording, method="OLS", tool=tool).estimate
    two = identify(recording, method="OLS", tool=sure).estimate
    std = np.sqrt(one.covariance.diagonal())
    added = two.covariance + tool.covariance
    # rounding of either
    np.testing.assert_allclose(
        (one.covariance - added) / np.outer(std, std), 0.0, atol=1e-12
    )
    assert (one.std["mass"] ** 2) == pytest.approx(
        two.std["mass"] ** 2 + tool.std["mass"] ** 2
    )


@pytest.mark.parametrize("without", [(True, False), (False, True), (True, True)])
def test_a_tool_without_a_covariance_adds_none(without):
    """Nor does an object without one get the tool's."""
    each = [
        Estimate(
            "OLS", body, 100, covariance=None if bare else np.diag(np.arange(1.0, 11.0))
        )
        for body, bare in zip((OBJECT, GRIPPER), without, strict=True)
    ]
    found = with_tool(*each)
    np.testing.assert_allclose(found.parameters.vector, BOTH.vector)
    if without[0]:
        assert found.covariance is None
    else:
        np.testing.assert_array_equal(found.covariance, each[0].covariance)


def test_every_method_takes_it():
    tool, recording = calibrate(log(GRIPPER, 20.0, 1)), log(BOTH, 10.0, 2)
    shape = Shape.from_box(-0.02, 0.04, -0.025, 0.025, 0.08, 0.2)
    for method in ("Bayes", "PMD", "GEO", "LMI", "RTLS"):
        found = identify(recording, shape, method=method, tool=tool).estimate
        # ten times what noise makes
        assert found.parameters.mass == pytest.approx(OBJECT.mass, abs=0.01), method
        assert (
            np.linalg.norm(found.parameters.center_of_mass - OBJECT.center_of_mass)
            < 0.006
        ), method


def test_what_calibrate_keeps(tmp_path):
    tool = calibrate(log(GRIPPER, 10.0, 1))
    tool.save(tmp_path / "tool.json")
    again = load_tool(tmp_path / "tool.json")
    np.testing.assert_array_equal(again.covariance, tool.covariance)
    np.testing.assert_allclose(again.bias, BIAS, atol=0.15)  # ten times its spread
    # with what the motion adds
    assert again.provenance["noise"]["force"] == pytest.approx(NOISE.force, rel=0.2)
    assert again.provenance["noise"]["torque"] == pytest.approx(NOISE.torque, rel=0.2)


def test_one_recording_of_a_pick_and_a_placing_shows_gripper_and_object():
    """15 s, of which it holds 1 kg beside the gripper for 5 s."""
    heavy = InertialParameters(GRIPPER.vector + 4.0 * OBJECT.vector)
    empty, both = (log(body, 15.0, 5).streams["wrench"] for body in (GRIPPER, heavy))
    held = (empty.time > 5.0) & (empty.time < 10.0)
    wrench = np.where(held[:, None], both.values, empty.values)
    whole = log(GRIPPER, 15.0, 5)
    streams = whole.streams | {"wrench": replace(empty, values=wrench)}
    whole = replace(whole, streams=streams)
    tool = calibrate(whole)
    low, high = tool.interval("mass")
    assert low < GRIPPER.mass < high
    assert high - low < 0.05
    (said,) = (m for m in tool.warnings if "where the gripper is empty" in m)
    assert said.code == "change-gripper-used"
    found = identify(whole, tool=tool, bias="estimate", method="OLS").estimate
    low, high = found.interval("mass")
    assert low < 1.0 < high
    assert high - low < 0.1


def test_warnings_and_refusals(tmp_path):
    tool = calibrate(log(GRIPPER, 10.0, 1))
    vague = replace(tool, covariance=None, method="PMD")
    found = identify(log(BOTH, 10.0, 2), method="OLS", tool=vague).estimate
    assert any("make it with hefting calibrate" in line for line in found.warnings)
    with pytest.raises(
        NotIdentifiableError, match="beside the tool; check `tool`: was it in the hand"
    ):
        identify(log(OBJECT, 10.0, 2), method="OLS", tool=tool)
    # some grams less that are a metre away: of the tool, and of no unit
    less = block(0.98, (0.0, 0.03, 0.05), (0.1, 0.06, 0.1))
    with pytest.raises(NotIdentifiableError, match="beside the tool; check `tool`"):
        identify(log(less, 10.0, 2), Shape.from_box(*NEAR), method="OLS", tool=tool)
    with pytest.raises(
        NotIdentifiableError, match="beside the tool; nothing is held"
    ) as nothing:
        identify(log(GRIPPER, 10.0, 2), method="OLS", tool=tool)
    mass, std = re.findall(r"there is (\S+) ± (\S+) kg", str(nothing.value))[0]
    assert len(mass.lstrip("-").partition(".")[2]) <= len(std.partition(".")[2])
    data = tool.to_dict()
    empty = {"vector": [0.0] * 10, "mass": 0.0, "center_of_mass": None}
    (tmp_path / "empty.json").write_text(json.dumps(data | empty))
    with pytest.raises(InputError, match="float is no estimate; give what"):
        front(log(BOTH, 10.0, 2), tool=0.5)  # type: ignore[arg-type]
    tool.save(tmp_path / "tool.json")
    (tmp_path / "tool.json").rename(tmp_path / "tool.txt")  # a name that logs have
    assert load_tool(tmp_path / "tool.txt").mass == tool.mass
    for text in ("0.9kg", "900g"):
        with pytest.raises(InputError, match=r"mass alone .* --tool gripper\.json"):
            load_tool(text)
    with pytest.raises(
        InputError,
        match=r"hefting calibrate 'an empty\.csv' -o gripper\.json makes one",
    ):
        load_tool("an empty.csv")
    with pytest.raises(InputError, match="the tool has a mass of 0 kg; leave it out"):
        load_tool(tmp_path / "empty.json")
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(InputError, match="is not an estimate"):
        load_tool(tmp_path / "other.json")
    assert isinstance(Estimate.load(tmp_path / "empty.json"), Estimate)


def test_a_tool_that_noise_alone_makes_no_body_is_good():
    """Least squares of a thin rod has a negative moment in every second recording."""
    rod = block(0.5, (0.0, 0.0, 0.1), (0.005, 0.005, 0.2))
    found = [calibrate(log(rod, 10.0, seed)) for seed in range(1, 5)]
    assert not all(each.physically_consistent for each in found)
    assert {each.verdict.level for each in found} == {"good"}
    C = np.diag((0.01, *np.full(9, np.inf)))
    # four standard deviations and five of the mass, beside what is open
    for size, within in ((0.4, True), (0.5, False)):
        assert _is_within_noise(np.array((size, *np.ones(9))), C) is within


def test_a_tool_that_was_not_on_the_sensor():
    """What is left has a mass, but no body is like it: not to be used, and named."""
    alone = block(1.4, (0.02, -0.01, 0.11), (0.05, 0.05, 0.1))
    tool = calibrate(log(GRIPPER, 10.0, 4))
    found = identify(log(alone, 10.0, 3), tool=tool).estimate
    assert found.verdict.level == "do not use"
    assert found.verdict.reasons[0].code == "tool-contradicts-wrench"
    assert "shape-contradicts-wrench" not in codes(found.warnings)


@pytest.mark.parametrize("shape", [None, Shape.from_box(*NEAR)])
def test_an_inertia_that_the_tools_own_recording_left_open_is_named(shape):
    """As of a gripper at rest, of which any inertia stands: not the motion of this
    recording, nor the shape."""
    heavy = InertialParameters(4.0 * GRIPPER.vector)
    C = np.diag(np.repeat((1e-8, np.inf), (4, 6)))
    none = InertialParameters(np.where(np.isinf(C.diagonal()), 0.0, heavy.vector))
    tool = Estimate("OLS", none, 100, covariance=C)
    both = InertialParameters(heavy.vector + OBJECT.vector)
    found = identify(log(both, 10.0, 2), shape, tool=tool).estimate
    assert "misfit" not in codes(found.warnings)
    code = "not-identifiable" if shape is None else "open-without-shape"
    [said] = [own for own in found.warnings if own.code == code]
    assert "the tool's" in said
    assert "record the gripper empty in motion" in said
    assert "motion leaves" not in said
    assert found.verdict.level == "good"
    assert found.undetermined.inertia
