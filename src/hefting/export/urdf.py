"""URDF: the inertial element of a link. http://wiki.ros.org/urdf/XML/link

The inertial's origin is the COM and the tensor is about the COM, in the axes of that
origin, here the link's.
"""

from hefting.core.files import parse_xml
from hefting.core.messages import Message, warning
from hefting.export import mjcf
from hefting.export.body import Body, number, numbers, quoted
from hefting.export.known import xml_comment
from hefting.export.target import Place, Target

PLACE = Place("URDF", roots=("robot",), element="link", parents=("robot",))


def inertial(body: Body) -> str:
    """The inertial element [kg, m, kg m²]."""
    tensor = " ".join(
        f'{name}="{number(value)}"' for name, value in body.tensor.items()
    )
    return (
        f'<inertial>\n  <origin xyz="{numbers(body.center_of_mass)}" rpy="0 0 0"/>\n'
        f'  <mass value="{number(body.mass)}"/>\n  <inertia {tensor}/>\n</inertial>'
    )


def write(body: Body) -> str:
    """A complete robot: the body as a link that floats in the world, not as the root
    link, whose inertia simulators attach to the world or drop (MuJoCo, KDL)."""
    name = quoted(body.name)
    frame = f"link frame: {body.frame}; SI units; inertia about the centre of mass"
    content = inertial(body).replace("\n", "\n    ")
    return f"""<?xml version="1.0"?>
{xml_comment((frame, *body.notes))}
<robot name={name}>
  <link name="world"/>
  <link name={name}>
    {content}
  </link>
  <joint name={quoted(body.name + "_in_world")} type="floating">
    <parent link="world"/>
    <child link={name}/>
  </joint>
</robot>
"""


def file_warnings(robot: str, link: str) -> list[Message]:
    """Warnings where MuJoCo changes, ignores or drops the inertial of a link."""
    children: set[str] = set()

    def start(tag: str, attributes: dict[str, str], _: int, inside: list[str]):
        if tag == "child" and inside == ["robot", "joint"]:
            children.add(attributes.get("link", ""))

    parse_xml(robot.encode(), "", start)
    warnings = mjcf.file_warnings(robot, link)
    if link not in children:
        what = (
            f"'{link}' is the root link, whose inertial MuJoCo and KDL drop: "
            "if it is to move, put an empty link above it"
        )
        warnings.append(warning("root-inertial-dropped", what))
    return warnings


TARGET = Target(
    name="urdf",
    description="link of a URDF robot (ROS, Pinocchio, MuJoCo)",
    suffixes=(".urdf",),
    write=write,
    needs_inertia=True,
    place=PLACE,
    inertial=inertial,
    file_warnings=file_warnings,
)
