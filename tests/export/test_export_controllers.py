"""Each controller's text read by a parser of its own, back to mass, COM and tensor in
flange axes."""

import ast
import json
import re

import numpy as np
import pytest
import yaml
from test_export_bodies import (
    CASES,
    CONTROLLERS,
    DOUBLE,
    POSE,
    PRINCIPAL_STEPS,
    SINGLE,
    check,
    from_principal,
    groups,
    make,
    symmetric,
)

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import pose_matrix
from hefting.export import export
from hefting.export.kuka import zyx_angles


def read_ur(text):
    call = ast.literal_eval(*groups(r"^set_target_payload(\(.*\))$", text))
    mass, com, *inertia = call
    return mass, com, symmetric(*inertia[0]) if inertia else None


def read_xarm(text):
    mass, com = ast.literal_eval(*groups(r"^arm\.set_tcp_load(\(.*\))$", text))
    return mass, np.array(com) / 1000, None


def read_franka(text):
    call = groups(r"^robot\.setLoad\((.*), \{\{(.*)\}\}, \{\{(.*)\}\}\);$", text)
    mass, com, nine = (np.fromstring(part, sep=",") for part in call)
    (request,) = groups(r"^// (\{mass.*\})$", text)
    request = ast.literal_eval(re.sub(r"(\w+):", r"'\1':", request))
    assert list(request) == ["mass", "center_of_mass", "load_inertia"]
    assert [request["mass"]] == list(mass)
    assert request["center_of_mass"] == list(com)
    assert request["load_inertia"] == list(nine)
    return mass[0], com, np.column_stack((nine[:3], nine[3:6], nine[6:]))


def read_kuka(text):
    number = r"(-?[\d.]+)"
    com, angles, moments = (
        ", ".join(f"{k} {number}" for k in keys) for keys in ("XYZ", "ABC", "XYZ")
    )
    call = groups(
        rf"^\{{M {number}, CM \{{{com}, {angles}\}}, J \{{{moments}\}}\}}$", text
    )
    mass, x, y, z, a, b, c, *j = (float(v) for v in call)
    (sa, sb, sc), (ca, cb, cc) = (
        np.sin(np.radians((a, b, c))),
        np.cos(np.radians((a, b, c))),
    )
    about_z = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
    about_y = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    about_x = np.array([[1, 0, 0], [0, cc, -sc], [0, sc, cc]])
    # each turn about an axis already turned: to the right
    axes = about_z @ about_y @ about_x
    return mass, np.array((x, y, z)) / 1000, axes @ np.diag(j) @ axes.T


def read_abb(text):
    mass, com, aom, *moments = ast.literal_eval(
        *groups(r"^PERS loaddata [A-Za-z]\w{0,31} := (\[.*\]);$", text)
    )
    assert len(moments) == 3
    assert min(moments) > 0 or not any(moments)  # all zero: a point mass
    return mass, np.array(com) / 1000, from_principal(moments, aom)


def read_fanuc(text):
    value = {}
    for label, unit, number in re.findall(
        r"^(PAYLOAD.*?) *\[(.*)\] *: ([-\d.]+)$", text, re.MULTILINE
    ):
        value[label] = (
            float(number) * {"kg": 1, "cm": 0.01, "kgfcms^2": 1 / 10.1971621}[unit]
        )
    com = [value[f"PAYLOAD CENTER {axis}"] for axis in "XYZ"]
    return (
        value["PAYLOAD"],
        com,
        np.diag([value[f"PAYLOAD INERTIA {axis}"] for axis in "XYZ"]),
    )


def read_ur_ros(text):
    """PyYAML, as ``ros2 service call`` reads it, and the later forms in the
    comments."""
    request = yaml.safe_load(text)
    assert set(request) == {"mass", "center_of_gravity"}
    mass, com = request["mass"], request["center_of_gravity"]
    later = [yaml.safe_load(line) for line in re.findall(r"^# (\{.*\})$", text, re.M)]
    if not later:
        return mass, [com[a] for a in "xyz"], None
    entries = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    with_inertia, rolling = later
    body = {k: v for k, v in rolling["payload"].items() if k not in ("m", "com")}
    assert body == {k: with_inertia[k] for k in entries}
    assert (rolling["payload"]["m"], rolling["payload"]["com"]) == (mass, com)
    assert (with_inertia["mass"], with_inertia["center_of_gravity"]) == (mass, com)
    return mass, [com[a] for a in "xyz"], symmetric(*(body[k] for k in entries))


def read_franka_desk(text):
    config = json.loads(text)
    assert set(config) == {"mass", "centerOfMass", "transformation", "inertia"}
    pose = np.reshape(config["transformation"], (4, 4), order="F")
    assert np.array_equal(pose, np.eye(4))
    tensor = np.reshape(config["inertia"], (3, 3), order="F")
    return config["mass"], config["centerOfMass"], tensor


def read_kinova(text):
    (mass,) = groups(r"^payload\.payload_mass = (.*)$", text)
    com = [
        groups(rf"^payload\.payload_mass_center\.{a} = (.*)$", text)[0] for a in "xyz"
    ]
    compile(text, "kinova", "exec")  # Python
    return float(mass), np.array(com, dtype=float), None


def read_doosan(text):
    (com,) = groups(r"^float cog\[3\] = \{(.*)\};$", text)
    (zeros,) = groups(r"^float inertia\[6\] = \{(.*)\};$", text)
    name, mass = groups(r'^drfl\.add_tool\("(\w+)", (.*), cog, inertia\);$', text)
    assert groups(r'^drfl\.set_tool\("(.*)"\);$', text) == (name,)
    request = yaml.safe_load(groups(r"^// (\{.*\})$", text)[0])
    com = np.fromstring(com, sep=",")
    assert request["weight"] == float(mass)
    assert request["cog"] == com.tolist()
    assert request["inertia"] == [0.0] * 6 == np.fromstring(zeros, sep=",").tolist()
    said = re.findall(r"it is \[(.*)\]$", text, re.MULTILINE)
    tensor = symmetric(*np.fromstring(said[0], sep=",")) if said else None
    return float(mass), com / 1000, tensor


READERS = {name: globals()[f"read_{name.replace('-', '_')}"] for name in CONTROLLERS}
# ABB, KUKA and Fanuc hold single precision: 6e-8 a number. KUKA's angles near 180 deg
# are 1.5e-5 deg apart,
# half of that is 1.3e-7 rad, three of them turn a tensor by up to 8e-7.
PRECISION = {
    "ur": DOUBLE,
    "xarm": DOUBLE,
    "franka": DOUBLE,
    "kuka": 1e-6,
    "abb": SINGLE,
    "fanuc": SINGLE,
    "ur-ros": DOUBLE,
    "franka-desk": DOUBLE,
    "kinova": SINGLE,
    "doosan": SINGLE,
}
STEPS = {"kuka": PRINCIPAL_STEPS, "abb": PRINCIPAL_STEPS, "fanuc": 1.1}
"""Rounding steps of the tensor where they are more than half of one; Fanuc's unit is
0.098 kg m², and its digits are as many as those of kg m² less one."""
WITHOUT_INERTIA = ("xarm", "kinova")
WITHOUT_COMMENTS = ("franka-desk",)


@pytest.mark.parametrize("target", CONTROLLERS)
@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_controllers_in_flange_axes(kind, seed, target):
    estimate, truth = make(kind, seed)
    exported = export(estimate, target, POSE)
    assert exported.frame == "flange"
    assert ("flange axes" in exported.text) == (target not in WITHOUT_COMMENTS)
    assert "NOT" not in exported.text
    assert not any("sensor" in warning for warning in exported.warnings)
    assert exported.text.isascii()
    mass, com, tensor = READERS[target](exported.text)
    if target in WITHOUT_INERTIA:
        assert tensor is None
        tensor = truth.tensor
    if target == "fanuc":
        truth.tensor = np.diag(np.diag(truth.tensor))
    check(truth, mass, com, tensor, PRECISION[target], kind, STEPS.get(target, 0.5))


@pytest.mark.parametrize("target", CONTROLLERS)
def test_controllers_without_the_pose_warn_and_are_in_sensor_axes(target):
    estimate, truth = make("box", 1, np.eye(4))
    exported = export(estimate, target)
    assert exported.frame == "sensor"
    assert ("sensor axes" in exported.text) == (target not in WITHOUT_COMMENTS)
    assert ("NOT flange axes" in exported.text) == (target not in WITHOUT_COMMENTS)
    assert any(
        "sensor axes" in w and "`sensor_pose_in_flange`" in w for w in exported.warnings
    )
    mass, com, tensor = READERS[target](exported.text)
    if target == "fanuc":
        truth.tensor = np.diag(np.diag(truth.tensor))
    check(
        truth,
        mass,
        com,
        truth.tensor if tensor is None else tensor,
        PRECISION[target],
        "box",
        STEPS.get(target, 0.5),
    )


def test_units_by_hand():
    """2 kg at (1, 2, 3) cm of a sensor 100 mm out and turned by 90 deg about z: (-2, 1,
    13) cm there."""
    estimate = Estimate(
        "test",
        InertialParameters.from_com(
            2.0, (0.01, 0.02, 0.03), np.diag((1e-3, 2e-3, 2.5e-3))
        ),
        1,
    )
    pose = pose_matrix((0, 0, 0.1, 0, 0, np.sqrt(0.5), np.sqrt(0.5)))
    last = {
        t: export(estimate, t, pose, name="cup").text.splitlines()[-1]
        for t in ("xarm", "abb", "kuka")
    }
    text = {t: export(estimate, t, pose).text for t in ("ur", "fanuc")}
    mass, com, _ = read_xarm(last["xarm"])
    # a few roundings
    np.testing.assert_allclose((mass, *com), (2, -0.02, 0.01, 0.13), rtol=1e-12)
    assert last["kuka"].startswith("{M 2.0, CM {X -20.0, Y 10.0, Z 130.0, A ")
    # sensor x lies along flange y
    assert last["kuka"].endswith("J {X 0.002, Y 0.001, Z 0.0025}}")
    assert last["abb"].startswith(
        "PERS loaddata load_cup := [2.0, [-20.0, 10.0, 130.0], [1.0, 0.0, 0.0, "
    )
    assert last["abb"].endswith(", 0.002, 0.001, 0.0025];")
    mass, com, tensor = read_ur(text["ur"])
    np.testing.assert_allclose((mass, *com), (2, -0.02, 0.01, 0.13), rtol=1e-12)
    np.testing.assert_allclose(np.diag(tensor), (2e-3, 1e-3, 2.5e-3), rtol=1e-9)
    lines = dict(
        line.split(": ")
        for line in text["fanuc"].splitlines()
        if line.startswith("PAYLOAD")
    )
    values = [float(v) for v in lines.values()]
    # 0.002 kg m² = 0.002 * 100 / 9.80665 kgf cm s²
    np.testing.assert_allclose(
        values, (2, -2, 1, 13, 0.02039432, 0.01019716, 0.02549290), atol=5e-7
    )  # a step of 1e-6


@pytest.mark.parametrize(
    "target",
    [t for t in CONTROLLERS if t != "franka-desk"],  # JSON has exponents
)
def test_no_exponents(target):
    """1 mg of inertia 1e-12 kg m², and a COM at 1e-7 m: parsers differ over 1e-07, so
    plain decimals only."""
    body = InertialParameters.from_com(
        1e-6, (1e-7, -1e-5, -0.0), np.diag((1e-12, 2e-12, 2.5e-12))
    )
    numbers = export(Estimate("test", body, 1), target).text.splitlines()
    assert not [
        line
        for line in numbers
        if not line.startswith(("#", "!", ";", "//")) and re.search(r"\de[-+]?\d", line)
    ]
    assert not re.search(r"-0\.0\b", "\n".join(numbers))


def test_euler_angles_at_the_singularity():
    rng = np.random.default_rng(4)
    for b in (np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, 0.3):
        for a, c in rng.uniform(-3, 3, (20, 2)):
            sa = np.sin(a)
            ca = np.cos(a)
            sb = np.sin(b)
            cb = np.cos(b)
            sc = np.sin(c)
            cc = np.cos(c)
            R = (
                np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
                @ np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
                @ np.array([[1, 0, 0], [0, cc, -sc], [0, sc, cc]])
            )
            A, B, C = zyx_angles(R)
            (sa, sb, sc), (ca, cb, cc) = np.sin((A, B, C)), np.cos((A, B, C))
            again = (
                np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
                @ np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
                @ np.array([[1, 0, 0], [0, cc, -sc], [0, sc, cc]])
            )
            # a few roundings of numbers up to 1
            np.testing.assert_allclose(again, R, atol=1e-14)


def test_point_mass():
    """Some have a mass and a COM only; at the COM nothing but rounding is left of J."""
    estimate = Estimate(
        "test", InertialParameters.from_points([[0.11, 0.2, -0.3]], [0.7]), 1
    )
    for target in CONTROLLERS:
        text = export(estimate, target, POSE).text
        if target != "abb":
            mass, com, tensor = READERS[target](text)
            assert mass == pytest.approx(0.7, rel=1e-7)
            np.testing.assert_allclose(
                com, POSE[:3, :3] @ (0.11, 0.2, -0.3) + POSE[:3, 3], atol=5.1e-7
            )
            assert tensor is None or not tensor.any()
    assert export(estimate, "abb", POSE).text.endswith(
        "[1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0];\n"
    )
