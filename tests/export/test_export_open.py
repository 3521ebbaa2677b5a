"""What is not known is not exported, unless it is asked to be filled in; and the two
targets that are not in flange axes."""

import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from test_export_bodies import CONTROLLERS, POSE, SIMULATORS, from_principal
from test_export_controllers import READERS, WITHOUT_COMMENTS, WITHOUT_INERTIA

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes, warning
from hefting.core.undetermined import Undetermined
from hefting.export import TARGETS, export
from hefting.export.known import POINT_RADIUS
from hefting.shapes import Shape

MASS, COM = 0.5, np.array((0.01, -0.02, 0.3))
DOUBT = warning("torque-units", "the torque is 1000 times what a lever explains")
# as static poses leave it: an inertia that no body has
OPEN = Estimate(
    "OLS",
    InertialParameters.from_com(MASS, COM, np.diag((-1e-3, 2e-3, -1e-9))),
    12,
    undetermined=Undetermined.of_parameters(
        [f"J{a}" for a in ("xx", "xy", "xz", "yy", "yz", "zz")], "what fits"
    ),
    warnings=(DOUBT,),
)
BOX = Shape.from_box(-0.05, 0.05, -0.1, 0.1, 0.0, 0.3)
BOX_INERTIA = np.diag((0.13, 0.1, 0.05)) * MASS / 12  # (b² + c²) m / 12 and so on
"""0.2² + 0.3², 0.1² + 0.3², 0.1² + 0.2² m²."""


def read(target, text):
    """Mass, COM and tensor by a reader of the format."""
    if target == "urdf":
        pin = pytest.importorskip("pinocchio")
        body = pin.buildModelFromXML(text).inertias[1]
        return body.mass, body.lever, body.inertia
    if target == "mjcf":
        mujoco = pytest.importorskip("mujoco")
        model = mujoco.MjModel.from_xml_string(text)
        tensor = from_principal(model.body_inertia[1], model.body_iquat[1])
        return model.body_mass[1], model.body_ipos[1], tensor
    if target == "usd":
        pytest.importorskip("pxr")
        from pxr import Usd, UsdPhysics  # pyright: ignore[reportMissingImports]

        stage = Usd.Stage.CreateInMemory()
        assert stage.GetRootLayer().ImportFromString(text)
        api = UsdPhysics.MassAPI(stage.GetDefaultPrim())
        q = api.GetPrincipalAxesAttr().Get()
        moments = list(api.GetDiagonalInertiaAttr().Get())
        tensor = from_principal(moments, (q.GetReal(), *q.GetImaginary()))
        com = list(api.GetCenterOfMassAttr().Get())
        return api.GetMassAttr().Get(), com, tensor
    from xml.etree import ElementTree

    inertial = ElementTree.fromstring(text).find("model/link/inertial")
    assert inertial is not None
    value = {e.tag: e.text or "" for e in inertial.iter()}
    com = [float(v) for v in value["pose"].split()[:3]]
    tensor = np.array(
        [[float(value["i" + "".join(sorted(a + b))]) for a in "xyz"] for b in "xyz"]
    )
    return float(value["mass"]), com, tensor


@pytest.mark.parametrize("target", CONTROLLERS)
def test_controllers_get_mass_and_com_alone(target):
    exported = export(OPEN, target, POSE)
    mass, com, tensor = READERS[target](exported.text)
    assert mass == MASS
    # half a step of six digits of up to 1 m
    np.testing.assert_allclose(com, POSE[:3, :3] @ COM + POSE[:3, 3], atol=6e-7)
    assert tensor is None or not np.any(tensor)
    said_codes = codes(exported.warnings)
    assert ("inertia-left-out" in said_codes) == (target not in WITHOUT_INERTIA)
    said = exported.text + " ".join(exported.warnings)
    assert "inertia: open" in said
    assert str(DOUBT) in said
    assert "estimate: usable with care" in said
    assert (str(DOUBT) in exported.text) == (target not in WITHOUT_COMMENTS)


@pytest.mark.parametrize("target", SIMULATORS)
def test_simulators_get_nothing_unless_it_is_asked_for(target):
    with pytest.raises(InputError, match="leaves the inertia open") as caught:
        export(OPEN, target, accept=True)
    assert "\n" not in str(caught.value)
    assert "`fill_inertia`=point" in str(caught.value)


# single precision in USD: 6e-8 a number, and six digits
@pytest.mark.parametrize("target", SIMULATORS)
def test_filled_in_from_the_shape(target):
    exported = export(OPEN, target, fill_inertia=BOX)
    assert codes(exported.warnings) == {"inertia-filled"}
    assert re.sub(r"\s+", " ", exported.text).count(
        "inertia: open, the recording does not determine it; filled in as that of the "
        "given shape with the mass evenly spread"
    )
    mass, com, tensor = read(target, exported.text)
    assert mass == pytest.approx(MASS, rel=1e-7)
    np.testing.assert_allclose(com, COM, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(tensor, BOX_INERTIA, atol=1e-5 * BOX_INERTIA.max())


@pytest.mark.parametrize("target", SIMULATORS)
def test_filled_in_as_a_point(target):
    exported = export(OPEN, target, POSE, fill_inertia="point")
    mass, com, tensor = read(target, exported.text)
    assert mass == pytest.approx(MASS, rel=1e-7)
    np.testing.assert_allclose(com, POSE[:3, :3] @ COM + POSE[:3, 3], atol=6e-7)
    small = MASS * POINT_RADIUS**2
    np.testing.assert_allclose(tensor, small * np.eye(3), atol=1e-5 * small)


def test_nothing_is_filled_in_where_it_is_known():
    body = InertialParameters.from_com(MASS, COM, BOX_INERTIA)
    known = Estimate("test", body, 1)
    for fill in (None, "point", BOX):
        assert (
            export(known, "urdf", fill_inertia=fill).text == export(known, "urdf").text
        )


def test_one_open_entry_is_enough():
    body = InertialParameters.from_com(MASS, COM, BOX_INERTIA)
    one = Undetermined.of_parameters(["Jxy"], "what fits")
    estimate = Estimate("test", body, 1, undetermined=one)
    with pytest.raises(InputError, match="leaves the inertia open"):
        export(estimate, "urdf")
    assert export(estimate, "ur").text.endswith(
        "set_target_payload(0.5, [0.01, -0.02, 0.3])\n"
    )


@pytest.mark.parametrize(
    ("names", "said"), [(["mcz"], "COM z"), (["m"], "the mass and the COM")]
)
def test_an_open_com_is_refused_but_written_where_it_is_accepted(names, said):
    open_ = replace(OPEN, undetermined=Undetermined.of_parameters(names, "what fits"))
    for target in set(TARGETS) - {"json", "csv"}:
        with pytest.raises(InputError, match=f"leaves {said} open"):
            export(open_, target, fill_inertia="point")
    text = export(open_, "ur", accept=True).text
    assert f"{said}: open, filled in from what fits" in text
    assert export(open_, "json").text


def test_a_shape_is_a_shape_or_a_point():
    with pytest.raises(InputError, match="cannot fill in 'box'"):
        export(OPEN, "urdf", fill_inertia="box")  # type: ignore[arg-type]


@pytest.mark.parametrize("target", ["urdf", "mjcf", "sdf"])
def test_a_file_that_it_is_put_into_says_so_inside_the_inertial(target, tmp_path):
    content = {
        "urdf": '<robot name="r"><link name="world"/><link name="a"/><joint name="j" '
        'type="floating"><parent link="world"/><child link="a"/></joint></robot>',
        "mjcf": '<mujoco><worldbody><body name="a"><freejoint/></body></worldbody>'
        "</mujoco>",
        "sdf": '<sdf version="1.7"><model name="m"><link name="a"></link></model></sdf>',
    }[target]
    (tmp_path / "file").write_text(content)
    where = {"into": tmp_path / "file", "link": "a", "fill_inertia": "point"}
    text = export(OPEN, target, **where).text  # type: ignore[arg-type]
    inside = text[text.index("<inertial") : text.index("</inertial>")]
    assert "estimate: usable with care" in inside
    assert "filled in as that of a point" in " ".join(inside.split())
    assert read(target, text)[0] == MASS
    (tmp_path / "file").write_text(text)
    assert export(OPEN, target, **where).text == text  # type: ignore[arg-type]


def test_csv_names_what_is_open():
    header, row = export(OPEN, "csv").text.splitlines()
    assert header.endswith(",open")
    assert row.endswith(",Ixx Ixy Ixz Iyy Iyz Izz")


# the targets that do not want flange axes


@pytest.mark.parametrize("pose", [None, POSE])
def test_xarm_ft_is_in_sensor_axes(pose):
    exported = export(OPEN, "xarm-ft", pose)
    call = re.search(r"^arm\.set_ft_sensor_load_offset\((.*)\)$", exported.text, re.M)
    assert call is not None
    numbers = yaml.safe_load(call[1])
    assert numbers == [MASS, 10.0, -20.0, 300.0, *[0.0] * 6]  # mm
    assert exported.frame == "sensor"
    unused = set() if pose is None else {"sensor-pose-unused"}
    assert codes(exported.warnings) == unused


@pytest.mark.parametrize("pose", [None, POSE])
def test_ros2_control(pose):
    exported = export(OPEN, "ros2-control", pose)
    nodes = yaml.safe_load(exported.text)
    parameters = {name: node["ros__parameters"] for name, node in nodes.items()}
    chain = parameters["force_torque_sensor_broadcaster"]["sensor_filter_chain"]
    assert chain["filter1"]["type"] == "control_filters/GravityCompensationWrench"
    load, frame = chain["filter1"]["params"], "ft_sensor" if pose is None else "tool0"
    com = COM if pose is None else POSE[:3, :3] @ COM + POSE[:3, 3]
    compensation = parameters["admittance_controller"]["gravity_compensation"]
    tool = parameters["cartesian_force_controller"]["tool"]
    assert load["tool"]["mass"] == tool["mass"] == MASS
    assert load["sensor_frame"] == compensation["frame"]["id"] == frame
    for found in (
        load["tool"]["CoG"],
        compensation["CoG"]["pos"],
        [tool[f"com_{a}"] for a in "xyz"],
    ):
        np.testing.assert_allclose(found, com, atol=6e-7)  # half a step of six digits
    assert load["tool"]["gravity_field"] == [0.0, 0.0, -9.80665]
    # six digits of 4.9 N
    assert compensation["CoG"]["force"] == pytest.approx(MASS * 9.80665, abs=6e-6)
    assert not exported.warnings
