"""Every export read back: by Pinocchio, MuJoCo, OpenUSD where installed, and
independent parsers.

The expected values never pass through the code under test: they are the mass, COM and
tensor the body was made from, moved to the flange by plain matrix products.
"""

import ast
import csv
import io
import re
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np
import pytest
from test_export_bodies import (
    CASES,
    CONTROLLERS,
    DOUBLE,
    IN_ANY_AXES,
    IN_SENSOR_AXES,
    KINDS,
    POSE,
    PRINCIPAL_STEPS,
    SIMULATORS,
    SINGLE,
    check,
    from_principal,
    make,
    physically_impossible,
    symmetric,
)

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.estimators import OLS
from hefting.export import SUFFIXES, TARGETS, export


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_urdf_in_pinocchio(kind, seed):
    pin = pytest.importorskip("pinocchio")
    estimate, truth = make(kind, seed)
    model = pin.buildModelFromXML(export(estimate, "urdf", POSE).text)
    body = model.inertias[1]
    check(truth, body.mass, body.lever, body.inertia, DOUBLE, kind)


@pytest.mark.parametrize("target", ["urdf", "mjcf"])
@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_urdf_and_mjcf_in_mujoco(kind, seed, target):
    mujoco = pytest.importorskip("mujoco")
    estimate, truth = make(kind, seed)
    model = mujoco.MjModel.from_xml_string(
        export(estimate, target, POSE, name='a <b> & "c"\'').text
    )
    index = model.body('a <b> & "c"\'').id
    assert model.nv == 6  # free to move
    tensor = from_principal(model.body_inertia[index], model.body_iquat[index])
    check(truth, model.body_mass[index], model.body_ipos[index], tensor, DOUBLE, kind)


def test_mujoco_refuses_what_the_thickness_avoids():
    """Without it, rounding alone breaks the triangle inequality of some flat bodies:
    the repair is needed."""
    mujoco = pytest.importorskip("mujoco")
    refused = 0
    for seed in range(30):
        _, truth = make("flat", seed)
        t = truth.tensor
        full = " ".join(
            repr(float(v))
            for v in (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])
        )
        inertial = f'<inertial pos="0 0 0" mass="1" fullinertia="{full}"/>'
        xml = f"<mujoco><worldbody><body><freejoint/>{inertial}</body></worldbody></mujoco>"
        try:
            mujoco.MjModel.from_xml_string(xml)
        except ValueError:
            refused += 1
        mujoco.MjModel.from_xml_string(export(make("flat", seed)[0], "mjcf", POSE).text)
    assert refused > 0
    exported = export(make("flat", 0)[0], "mjcf")
    assert any("flat or rod-like" in warning for warning in exported.warnings)
    assert not export(make("box", 0)[0], "mjcf").warnings


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_sdf(kind, seed):
    estimate, truth = make(kind, seed)
    elements = ElementTree.fromstring(export(estimate, "sdf", POSE).text).findall(
        "model/link/inertial//"
    )
    value = {e.tag: e.text or "" for e in elements}
    pose = [float(v) for v in value["pose"].split()]
    assert pose[3:] == [0, 0, 0]
    assert len(elements) == 9
    tensor = symmetric(
        *(float(value[f"i{a}"]) for a in ("xx", "yy", "zz", "xy", "xz", "yz"))
    )
    check(truth, float(value["mass"]), pose[:3], tensor, DOUBLE, kind)


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_usd(kind, seed):
    estimate, truth = make(kind, seed)
    text = export(estimate, "usd", POSE).text
    assert text.startswith("#usda 1.0\n")
    assert "metersPerUnit = 1\n" in text
    assert "kilogramsPerUnit = 1\n" in text
    value = {
        m[1]: ast.literal_eval(m[2]) for m in re.finditer(r"physics:(\w+) = (.+)", text)
    }
    tensor = from_principal(value["diagonalInertia"], value["principalAxes"])
    mass, com = value["mass"], value["centerOfMass"]
    check(truth, mass, com, tensor, DOUBLE, kind, PRINCIPAL_STEPS)


@pytest.mark.parametrize("name", ["object", "2 drill-bits", "é"])
@pytest.mark.parametrize("kind", KINDS)
def test_usd_in_openusd(kind, name):
    pxr = pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom, UsdPhysics  # pyright: ignore[reportMissingImports]

    estimate, truth = make(kind, 0)
    stage = Usd.Stage.CreateInMemory()
    assert stage.GetRootLayer().ImportFromString(
        export(estimate, "usd", POSE, name=name).text
    ), pxr
    prim = stage.GetDefaultPrim()
    assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    api = UsdPhysics.MassAPI(prim)
    q = api.GetPrincipalAxesAttr().Get()
    moments = list(api.GetDiagonalInertiaAttr().Get())
    a, b, c = sorted(moments)
    assert a > 0
    assert a + b >= c
    tensor = from_principal(moments, (q.GetReal(), *q.GetImaginary()))
    check(
        truth,
        api.GetMassAttr().Get(),
        list(api.GetCenterOfMassAttr().Get()),
        tensor,
        SINGLE,
        kind,
        PRINCIPAL_STEPS,
    )


def test_json_reads_back(tmp_path):
    covariance = np.diag(np.arange(1.0, 11.0)) * 1e-6
    for parameters in (make("box", 0)[0].parameters, *physically_impossible().values()):
        estimate = Estimate(
            "OLS", parameters, 10, 1.5, covariance if parameters.mass else None
        )
        (tmp_path / "e.json").write_text(export(estimate, "json").text)
        again = Estimate.load(tmp_path / "e.json")
        assert np.array_equal(again.parameters.vector, parameters.vector)
        assert again.method == "OLS"
    exported = export(make("box", 0)[0], "json", POSE)
    assert exported.frame == "sensor"
    assert len(exported.warnings) == 1


@pytest.mark.parametrize("begin", "=+-@")
def test_no_text_of_a_csv_is_a_formula(begin):
    """A spreadsheet would compute it; numbers stay."""
    text = f"{begin}HYPERLINK(1)"
    estimate = replace(make("box", 0)[0], method=text)
    (row,) = csv.DictReader(io.StringIO(export(estimate, "csv", name=text).text))
    assert (row["name"], row["method"]) == (f"'{text}", f"'{text}")
    assert float(row["cx"]) == estimate.center_of_mass[0]


def test_csv_reads_back():
    parameters = make("box", 0)[0].parameters
    estimate = Estimate(
        "OLS", parameters, 10, 1.5, np.diag(np.arange(1.0, 11.0)) * 1e-6
    )
    (row,) = csv.DictReader(io.StringIO(export(estimate, "csv", name="a, b").text))
    J, std = parameters.inertia_at_com, estimate.std
    assert std is not None
    assert row["name"] == "a, b"
    assert row["frame"] == "sensor"
    assert row["physically_consistent"] == "True"
    assert float(row["cz"]) == parameters.center_of_mass[2]
    assert float(row["Ixz"]) == J[0, 2]
    assert float(row["Jyz"]) == parameters.vector[8]
    assert float(row["std_mass"]) == std["mass"]
    assert float(row["std_Iyy"]) == std["inertia_at_com"][1, 1]
    (row,) = csv.DictReader(io.StringIO(export(make("box", 0)[0], "csv").text))
    assert row["std_mass"] == ""


def test_arguments():
    estimate = make("box", 0)[0]
    assert (
        set(SUFFIXES.values())
        <= set(TARGETS)
        == {*SIMULATORS, *CONTROLLERS, *IN_SENSOR_AXES, *IN_ANY_AXES, "json", "csv"}
    )
    for simulator, known in {"MuJoCo": "urdf or mjcf", "drake": "sdf"}.items():
        with pytest.raises(InputError, match=rf"\(did you mean {known}\?\)"):
            export(estimate, simulator)
    with pytest.raises(InputError, match="did you mean 'urdf'"):
        export(estimate, "urfd")
    with pytest.raises(InputError, match="proper rotation"):
        export(estimate, "ur", np.diag((1.0, 1, -1, 1)))
    for name in ("", "a\nb", "world", None, 5):
        with pytest.raises(InputError, match="cannot name"):
            export(estimate, "urdf", name=name)
    for target in ("usd", "ur", "json"):
        with pytest.raises(InputError, match="only urdf, mjcf, sdf can"):
            export(estimate, target, into="robot.urdf", link="x")
    with pytest.raises(InputError, match="`into`=FILE"):
        export(estimate, "urdf", link="x")


@dataclass
class Found:
    """As what `hefting.identify` returns."""

    estimate: object


def test_what_holds_an_estimate_is_exported_and_nothing_else():
    estimate = make("box", 0)[0]
    for target in ("ur", "json"):
        assert export(Found(estimate), target) == export(estimate, target)
    for other in (Found(3), OLS(), {}):
        with pytest.raises(InputError, match="is no estimate; give what"):
            export(other, "ur")
