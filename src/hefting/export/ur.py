"""Universal Robots: a call of set_target_payload in URScript, and requests of the ROS
service ur_msgs/SetPayload as YAML for ``ros2 service call``."""

import numpy as np

from hefting.export.body import Body
from hefting.export.known import comment, in_double
from hefting.export.target import Target

SERVICE = "/io_and_status_controller/set_payload"
ZEROES = "setting the payload zeroes the force-torque measurement: hold the robot still"


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
            ZEROES,
        )
        + f"set_target_payload({mass}, [{com}]{inertia})\n"
    )


TARGET = Target(
    name="ur",
    description="Universal Robots: URScript set_target_payload",
    write=write,
    wants_flange=True,
)


def write_request(body: Body) -> str:
    """The request of ur_msgs/srv/SetPayload: kg, m, kg m² about the COM, from the tool
    flange in its axes.

    The service has three forms, of which a distribution has one: mass and
    center_of_gravity (to ur_msgs 2.4, the only form of ROS 1); the same with ixx to iyz
    (ur_msgs 2.5, pull request 43); geometry_msgs/Inertia (ur_msgs 3.0, pull request
    42). The YAML is the first; if the inertia is known, the others are in comments.
    Units: REP 103, and Universal_Robots_ROS2_Driver issue 428.
    """
    mass, x, y, z = in_double((body.mass, *body.center_of_mass))
    vector = f"{{x: {x}, y: {y}, z: {z}}}"
    text = comment(
        "#",
        body,
        "kg, m; ros2 service call with this file as one argument:",
        f'  ros2 service call {SERVICE} ur_msgs/srv/SetPayload "$(cat FILE)"',
        ZEROES,
    )
    text += f"mass: {mass}\ncenter_of_gravity: {vector}\n"
    return text if body.is_point else text + _with_inertia(body, mass, vector)


def _with_inertia(body: Body, mass: str, vector: str) -> str:
    entries = ", ".join(
        f"{name}: {in_double(value)[0]}" for name, value in body.tensor.items()
    )
    return (
        "# or with inertia, kg m^2 about the centre of mass, ur_msgs 2.5:\n"
        f"# {{mass: {mass}, center_of_gravity: {vector}, {entries}}}\n"
        "# or ur_msgs 3.0:\n"
        f"# {{payload: {{m: {mass}, com: {vector}, {entries}}}, transition_time: 0.0}}\n"
    )


ROS = Target(
    name="ur-ros",
    description="Universal Robots in ROS: ur_msgs/SetPayload as YAML",
    write=write_request,
    wants_flange=True,
)
