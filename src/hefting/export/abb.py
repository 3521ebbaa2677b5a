"""ABB: loaddata in RAPID, with its frame and units in a comment."""

from hefting.core.messages import Message, warning
from hefting.export.body import Body
from hefting.export.known import comment, in_single
from hefting.export.target import Target


def write(body: Body) -> str:
    """RAPID loaddata: kg; **mm**; quaternion w, x, y, z of the principal axes; their
    moments [kg m²].

    Technical reference manual RAPID, data type loaddata. Moments about the COM; three
    zeros: a point mass.
    """
    moments, _ = body.principal()
    com, aom = (
        ", ".join(in_single(v)) for v in (1e3 * body.center_of_mass, body.quaternion())
    )
    # RAPID: a letter first, at most 32 characters, no reserved word
    name = f"load_{body.identifier}"[:32]
    return (
        comment(
            "!",
            body,
            "[kg, [mm], [quaternion w x y z of the principal axes], kg m^2, kg m^2, kg m^2]",
            "principal moments about the centre of mass; all three zero mean a point mass",
            "as payload (GripLoad) valid with tool0, whose frame is the flange's; as tload, with any tool",
        )
        + f"PERS loaddata {name} := "
        + f"[{in_single(body.mass)[0]}, [{com}], [{aom}], {', '.join(in_single(moments))}];\n"
    )


def warnings(body: Body) -> list[Message]:
    """A warning if the body is a point mass."""
    if not body.is_point:
        return []
    return [warning("point-mass", "the three moments are zero: a point mass")]


TARGET = Target(
    name="abb",
    description="ABB: RAPID loaddata",
    write=write,
    wants_flange=True,
    warnings=warnings,
)
