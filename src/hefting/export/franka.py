"""Franka: a call of libfranka's setLoad and the same request of ROS 2; and the file of an
end effector for Desk, ``endeffector-config.json``, whose notes on the estimate are a
warning of the export, as JSON has no comments."""

import json

import numpy as np

from hefting.core.messages import Message, warning
from hefting.export.body import Body
from hefting.export.known import GOOD, comment, in_double
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


def write_file(body: Body) -> str:
    """Mass [kg], centre of mass [m] in flange axes, inertia about it [kg m²] as nine
    numbers column by column, and the unknown pose of the end effector in the flange as
    sixteen, the identity.

    Keys as in the file of github.com/frankaemika/external_gripper_example, and as
    "End effector commissioning" of Franka's RIDE documentation describes them. It also
    requires an id, a name and a colour in an archive; Desk's upload accepts the file
    without them. The inertia about the centre of mass is libfranka's convention
    (`RobotState::I_ee`).
    """
    config = {
        "mass": body.mass,
        "centerOfMass": body.center_of_mass.tolist(),
        "transformation": np.eye(4).ravel(order="F").tolist(),
        "inertia": body.inertia.ravel(order="F").tolist(),
    }
    return json.dumps(config, indent=1) + "\n"


def warnings(body: Body) -> list[Message]:
    """Warnings about information that the file cannot hold."""
    what = "the file says that the tool's centre is at the flange (transformation): set it in Desk"
    messages = [warning("transformation-unknown", what)]
    if body.notes == GOOD:
        return messages
    what = f"the file has no place for comments: {'; '.join(body.notes)}"
    return [*messages, warning("no-comments", what)]


DESK = Target(
    name="franka-desk",
    description="Franka Desk: JSON of an end effector",
    other_suffixes=(".json",),
    write=write_file,
    wants_flange=True,
    warnings=warnings,
)
