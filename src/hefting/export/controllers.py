"""Robot controllers: a line or block to paste, with its frame and units in a comment.

All take the COM from the flange's origin in flange axes. Where a controller keeps single precision (ABB,
KUKA, Fanuc), the shortest decimal of that precision is written; nowhere an exponent, which not every parser
knows.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.export.body import Body

KGF_CM_S2 = 9.80665 * 0.01
"""One kgf cm s² [kg m²], the unit of Fanuc's moments: 1 kg m² is 10.197 of them."""


def _double(values: Array | float) -> list[str]:
    return [np.format_float_positional(v + 0.0, unique=True, trim="0") for v in np.atleast_1d(values)]


def _single(values: Array | float) -> list[str]:
    array = np.atleast_1d(values).astype(np.float32)
    return [np.format_float_positional(v + np.float32(0), unique=True, trim="0") for v in array]


def _comment(mark: str, body: Body, *lines: str) -> str:
    where = f"{body.frame} axes, from the {body.frame} origin"
    if body.frame != "flange":
        where += " - NOT flange axes: the pose of the sensor in the flange was not given"
    what = "what the sensor carries; the mass of the sensor itself and of an adapter is not in it"
    return "".join(f"{mark} {line}\n" for line in (where, what, *lines))


def write_ur(body: Body) -> str:
    """URScript set_target_payload: kg, m, kg m² as Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the COM.

    https://www.universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm
    """
    mass, com, tensor = (
        ", ".join(_double(v)) for v in (body.mass, body.center_of_mass, np.array(list(body.tensor.values())))
    )
    return (
        _comment(
            "#",
            body,
            "kg, m, kg m^2: inertia [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of mass",
            "setting the payload zeroes the force-torque measurement: hold the robot still",
        )
        + f"set_target_payload({mass}, [{com}], [{tensor}])\n"
    )


def write_xarm(body: Body) -> str:
    """xArm Python SDK set_tcp_load: kg and **mm**; it takes no inertia.

    https://github.com/xArm-Developer/xArm-Python-SDK/blob/master/doc/api/xarm_api.md
    """
    mass, com = ", ".join(_double(body.mass)), ", ".join(_double(1e3 * body.center_of_mass))
    return _comment("#", body, "kg, mm; the controller takes no inertia") + f"arm.set_tcp_load({mass}, [{com}])\n"


def write_franka(body: Body) -> str:
    """libfranka Robot::setLoad: kg, m from the flange, kg m² about the COM as nine numbers column by column.

    https://frankarobotics.github.io/libfranka/ (Robot::setLoad), franka_msgs/srv/SetLoad
    """
    mass = _double(body.mass)[0]
    com, tensor = (", ".join(_double(v)) for v in (body.center_of_mass, body.inertia.ravel(order="F")))
    return (
        _comment("//", body, "kg, m, kg m^2: inertia about the centre of mass, column by column")
        + f"robot.setLoad({mass}, {{{{{com}}}}}, {{{{{tensor}}}}});\n"
        + "// or as the ROS 2 request franka_msgs/srv/SetLoad:\n"
        + f"// {{mass: {mass}, center_of_mass: [{com}], load_inertia: [{tensor}]}}\n"
    )


def write_kuka(body: Body) -> str:
    """KRL load data: kg; mm; A, B, C [deg] turn the flange about Z, then the new Y, then the newest X into
    the principal axes, whose moments about the COM are J [kg m²].

    Load data in the KUKA assembly instructions, e.g. MA KR IONTEC V4, section "Payloads".
    """
    moments, axes = body.principal()
    com = _named(_single(1e3 * body.center_of_mass), "XYZ")
    angles = _named(_single(np.degrees(zyx_angles(axes))), "ABC")
    return (
        _comment(
            ";",
            body,
            "kg, mm, deg, kg m^2: principal moments J about the centre of mass; A B C turn about Z, Y', X''",
            "assign to $LOAD, or to LOAD_DATA[n] of tool n",
        )
        + f"{{M {_single(body.mass)[0]}, CM {{{com}, {angles}}}, J {{{_named(_single(moments), 'XYZ')}}}}}\n"
    )


def write_abb(body: Body) -> str:
    """RAPID loaddata: kg; **mm**; quaternion w, x, y, z of the principal axes; their moments [kg m²].

    Technical reference manual RAPID, data type loaddata. Moments about the COM; three zeros: a point mass.
    """
    moments, _ = body.principal()
    com, aom = (", ".join(_single(v)) for v in (1e3 * body.center_of_mass, body.quaternion()))
    name = f"load_{body.identifier}"[:32]  # RAPID: a letter first, at most 32 characters, no reserved word
    return (
        _comment(
            "!",
            body,
            "[kg, [mm], [quaternion w x y z of the principal axes], kg m^2, kg m^2, kg m^2]",
            "principal moments about the centre of mass; all three zero mean a point mass",
            "as payload (GripLoad) valid with tool0, whose frame is the flange's; as tload, with any tool",
        )
        + f"PERS loaddata {name} := "
        + f"[{_single(body.mass)[0]}, [{com}], [{aom}], {', '.join(_single(moments))}];\n"
    )


def write_fanuc(body: Body) -> str:
    """Lines of the MOTION/PAYLOAD SET screen: kg; **cm** from the faceplate; moments about axes through the
    COM, parallel to the faceplate's, in **kgf cm s²**. There is no place for products of inertia.
    """
    com, moments = _single(1e2 * body.center_of_mass), _single(np.diag(body.inertia) / KGF_CM_S2)
    rows = [
        ("PAYLOAD           [kg]", _single(body.mass)[0]),
        *((f"PAYLOAD CENTER {axis}  [cm]", value) for axis, value in zip("XYZ", com, strict=True)),
        *((f"PAYLOAD INERTIA {axis} [kgfcms^2]", value) for axis, value in zip("XYZ", moments, strict=True)),
    ]
    return _comment(
        "!",
        body,
        "kg, cm, kgf cm s^2 (1 kg m^2 = 10.197): moments about the centre of mass along the faceplate's axes",
        "type into a schedule of MENU > SYSTEM > Motion; X, Y, Z are the faceplate's, whatever the UTOOL",
    ) + "".join(f"{label:<32}: {value}\n" for label, value in rows)


def dropped_products(body: Body) -> float:
    """Largest product of inertia over the largest moment: what `write_fanuc` leaves out."""
    moments = np.diag(body.inertia)
    return float(np.abs(body.inertia - np.diag(moments)).max() / (moments.max() or 1.0))


def zyx_angles(rotation: Array) -> Array:
    """Angles (3,) [rad] A, B, C with rotation (3, 3) = Rz(A) Ry(B) Rx(C); B in [-π/2, π/2].

    C is found after turning back by A, which stays exact at B = ±π/2, where A is arbitrary.
    """
    R = rotation
    a = np.arctan2(R[1, 0], R[0, 0])
    b = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    s, c = np.sin(a), np.cos(a)
    return np.array((a, b, np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])))


def _named(values: list[str], names: str) -> str:
    return ", ".join(f"{name} {value}" for name, value in zip(names, values, strict=True))
