"""Franka Desk: the JSON file of an end effector, ``endeffector-config.json``.

JSON has no comments: notes on the estimate are a warning of the export.
"""

import json

import numpy as np

from hefting.core.messages import Message, warning
from hefting.export.body import Body
from hefting.export.known import GOOD
from hefting.export.target import Target


def write(body: Body) -> str:
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


TARGET = Target(
    name="franka-desk",
    description="Franka Desk: JSON of an end effector",
    other_suffixes=(".json",),
    write=write,
    wants_flange=True,
    warnings=warnings,
)
