"""SDFormat: the inertial element of a link. http://sdformat.org/spec?elem=link

The inertial's pose is the COM, and the tensor is about the COM in the axes of that
pose, here the link's; products of inertia are those of the tensor, -∫ x y dm.
"""

from hefting.export.body import Body, number, numbers, quoted
from hefting.export.known import xml_comment
from hefting.export.target import Place, Target

PLACE = Place("SDF", roots=("sdf",), element="link", parents=("model",), scope="model")


def inertial(body: Body) -> str:
    """The inertial element [m, kg, kg m²]."""
    order = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    tensor = "\n".join(
        f"    <{name}>{number(body.tensor[name])}</{name}>" for name in order
    )
    return (
        f"<inertial>\n  <pose>{numbers(body.center_of_mass)} 0 0 0</pose>\n"
        f"  <mass>{number(body.mass)}</mass>\n  <inertia>\n{tensor}\n  </inertia>\n</inertial>"
    )


def write(body: Body) -> str:
    """A whole model of one link."""
    name = quoted(body.name)
    frame = f"link frame: {body.frame}; SI units; inertia about the centre of mass"
    content = inertial(body).replace("\n", "\n      ")
    return f"""<?xml version="1.0"?>
{xml_comment((frame, *body.notes))}
<sdf version="1.7">
  <model name={name}>
    <link name={name}>
      {content}
    </link>
  </model>
</sdf>
"""


TARGET = Target(
    name="sdf",
    description="link of an SDFormat model (Gazebo, Drake)",
    suffixes=(".sdf",),
    write=write,
    needs_inertia=True,
    place=PLACE,
    inertial=inertial,
)
