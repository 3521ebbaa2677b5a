"""Universal Robots: a call of set_target_payload in URScript, with its frame and units
in a comment."""

import numpy as np

from hefting.export.body import Body
from hefting.export.known import comment, in_double
from hefting.export.target import Target


def write(body: Body) -> str:
    """URScript set_target_payload: kg, m, kg m² as Ixx, Iyy, Izz, Ixy, Ixz, Iyz about
    the COM; without an inertia the controller assumes zero.

    https://www.universal-robots.com/manuals/EN/HTML/SW10_6/Content/prod-scriptmanual/G5/set_target_payload.htm
    """
    mass, com, tensor = (
        ", ".join(in_double(v))
        for v in (body.mass, body.center_of_mass, np.array(list(body.tensor.values())))
    )
    inertia = "" if body.is_point else f", [{tensor}]"
    return (
        comment(
            "#",
            body,
            "kg, m, kg m^2: inertia [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of mass",
            "setting the payload zeroes the force-torque measurement: hold the robot still",
        )
        + f"set_target_payload({mass}, [{com}]{inertia})\n"
    )


TARGET = Target(
    name="ur",
    description="Universal Robots: URScript set_target_payload",
    write=write,
    wants_flange=True,
)
