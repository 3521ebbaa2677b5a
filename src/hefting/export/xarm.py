"""UFACTORY xArm: calls of the Python SDK that set the load of the arm, and that of its
six-axis force-torque sensor."""

from hefting.export.body import Body
from hefting.export.known import comment, in_double, remarks
from hefting.export.target import Target


def write(body: Body) -> str:
    """xArm Python SDK set_tcp_load: kg and **mm**; it takes no inertia.

    https://github.com/xArm-Developer/xArm-Python-SDK/blob/master/doc/api/xarm_api.md
    """
    mass = ", ".join(in_double(body.mass))
    com = ", ".join(in_double(1e3 * body.center_of_mass))
    return (
        comment("#", body, "kg, mm; the controller takes no inertia")
        + f"arm.set_tcp_load({mass}, [{com}])\n"
    )


TARGET = Target(
    name="xarm",
    description="UFACTORY xArm: Python set_tcp_load (mass and COM only)",
    write=write,
    wants_flange=True,
    takes_inertia=False,
)


def write_sensor_load(body: Body) -> str:
    """xArm Python SDK set_ft_sensor_load_offset: [kg, COM x, y, z in **mm**, and the
    sensor's own offsets fx, fy, fz, tx, ty, tz]; it takes no inertia.

    In sensor axes from the sensor's own origin: for the load at the flange the SDK adds
    the sensor's mass and 32 mm to z. Called ft_sensor_cali_load before SDK 1.17; mm
    since SDK 1.11 (https://github.com/xArm-Developer/xArm-Python-SDK, doc/api and
    xarm/x3/ft_sensor.py). The sign of its offsets is not documented: zeros are written,
    and the sensor is to be zeroed without a load. `association_setting_tcp_load` stays
    off: it adds metres to millimetres in SDK 1.17.
    """
    numbers = ", ".join(
        (*in_double(body.mass), *in_double(1e3 * body.center_of_mass), *["0.0"] * 6)
    )
    return (
        remarks(
            "#",
            body,
            "kg, mm; the last six are the sensor's own offsets, which this overwrites:",
            "  run arm.set_ft_sensor_zero() without a load, or put in those of",
            "  arm.iden_ft_sensor_load_offset()",
            "the arm itself wants the load in flange axes besides: hefting export --to xarm",
        )
        + f"arm.set_ft_sensor_load_offset([{numbers}])\n"
    )


SENSOR = Target(
    name="xarm-ft",
    description="UFACTORY xArm: load of its force-torque sensor (mass and COM only)",
    write=write_sensor_load,
    in_sensor_axes=True,
    takes_inertia=False,
)
