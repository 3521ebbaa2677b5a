"""UFACTORY xArm: set_tcp_load of the Python SDK, with frame and units in a comment."""

from hefting.export.body import Body
from hefting.export.known import comment, in_double
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
