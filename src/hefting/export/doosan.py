"""Doosan: calls of its C++ library that register the load as a tool, with their frame
and units in a comment."""

import numpy as np

from hefting.export.body import Body
from hefting.export.known import comment, in_single
from hefting.export.target import Target


def write(body: Body) -> str:
    """DRFLEx add_tool: kg, COM in **mm** from the flange, inertia Ixx, Iyy, Izz, Ixy,
    Ixz, Iyz.

    Doosan Robotics API manual, add_tool and set_workpiece_weight. It states neither unit
    nor reference point of the inertia (and for CONFIG_TOOL metres instead of
    millimetres), and its example passes zeros: zeros are written, and the tensor is in a
    comment. ROS 2 takes the same (dsr_msgs2/srv/ConfigCreateTool).
    """
    mass = in_single(body.mass)[0]
    com = ", ".join(in_single(1e3 * body.center_of_mass))
    zeros = ", ".join(["0.0"] * 6)
    name = f"{body.identifier}"[:32]
    return (
        comment("//", body, "kg, mm from the flange", *_inertia(body))
        + f"float cog[3] = {{{com}}};\n"
        + f"float inertia[6] = {{{zeros}}};\n"
        + f'drfl.add_tool("{name}", {mass}, cog, inertia);\n'
        + f'drfl.set_tool("{name}");\n'
        + "// or as the ROS 2 request dsr_msgs2/srv/ConfigCreateTool:\n"
        + f'// {{name: "{name}", weight: {mass}, cog: [{com}], inertia: [{zeros}]}}\n'
    )


def _inertia(body: Body) -> tuple[str, ...]:
    if body.is_point:
        return ()
    tensor = ", ".join(in_single(np.array(list(body.tensor.values()))))
    return (
        "the manual gives no unit of the inertia: zeros, as in its example; about the centre of mass",
        f"  in kg m^2 [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] it is [{tensor}]",
    )


TARGET = Target(
    name="doosan",
    description="Doosan: DRFL add_tool, ROS 2 ConfigCreateTool",
    write=write,
    wants_flange=True,
)
