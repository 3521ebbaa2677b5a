"""Kinova Gen3: the payload in the Kortex API, with its frame and units in a comment."""

from hefting.export.body import Body
from hefting.export.known import comment, in_single
from hefting.export.target import Target


def write(body: Body) -> str:
    """Kortex Python API, ControlConfig.SetPayloadInformation: kg and m, in single
    precision; it takes no inertia.

    ControlConfig.proto of https://github.com/Kinovarobotics/ros_kortex: the payload's
    centre is relative to the *tool* frame, that of SetToolConfiguration to the
    interface module, which is the flange. The two are one frame where no tool is
    configured.
    """
    mass, x, y, z = in_single((body.mass, *body.center_of_mass))
    return (
        comment(
            "#",
            body,
            "kg, m; the controller takes no inertia",
            "the centre counts from the tool frame, which is the flange's only where no tool is configured;",
            "  with one, give the sensor's pose in the tool frame as that in the flange",
        )
        + "from kortex_api.autogen.messages import ControlConfig_pb2\n\n"
        + "payload = ControlConfig_pb2.PayloadInformation()\n"
        + f"payload.payload_mass = {mass}\n"
        + f"payload.payload_mass_center.x = {x}\n"
        + f"payload.payload_mass_center.y = {y}\n"
        + f"payload.payload_mass_center.z = {z}\n"
        + "control_config.SetPayloadInformation(payload)  # a ControlConfigClient\n"
    )


TARGET = Target(
    name="kinova",
    description="Kinova: Kortex payload (mass and COM only)",
    write=write,
    wants_flange=True,
    takes_inertia=False,
)
