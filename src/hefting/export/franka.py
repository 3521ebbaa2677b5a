"""Franka: a call of libfranka's setLoad and the same request of ROS 2, with their frame
and units in a comment."""

from hefting.export.body import Body
from hefting.export.known import comment, in_double
from hefting.export.target import Target


def write(body: Body) -> str:
    """libfranka Robot::setLoad: kg, m from the flange, kg m² about the COM as nine
    numbers column by column.

    https://frankarobotics.github.io/libfranka/ (Robot::setLoad),
    franka_msgs/srv/SetLoad
    """
    mass = in_double(body.mass)[0]
    com, tensor = (
        ", ".join(in_double(v))
        for v in (body.center_of_mass, body.inertia.ravel(order="F"))
    )
    return (
        comment(
            "//",
            body,
            "kg, m, kg m^2: inertia about the centre of mass, column by column",
        )
        + f"robot.setLoad({mass}, {{{{{com}}}}}, {{{{{tensor}}}}});\n"
        + "// or as the ROS 2 request franka_msgs/srv/SetLoad:\n"
        + f"// {{mass: {mass}, center_of_mass: [{com}], load_inertia: [{tensor}]}}\n"
    )


TARGET = Target(
    name="franka",
    description="Franka: libfranka setLoad, ROS 2 SetLoad",
    write=write,
    wants_flange=True,
)
