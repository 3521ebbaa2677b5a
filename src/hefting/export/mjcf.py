"""MJCF: the inertial element of a body.
https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial

`pos` is the COM; `fullinertia` is Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the COM in the
body's axes.
"""

import re

from hefting.core.messages import Message, warning
from hefting.export.body import Body, number, numbers, quoted
from hefting.export.known import xml_comment
from hefting.export.target import Place, Target

PLACE = Place(
    "MJCF",
    roots=("mujoco", "mujocoinclude"),
    element="body",
    parents=None,
    massive="geom",
    movers=("frame", "replicate"),
)


def inertial(body: Body) -> str:
    """The inertial element [m, kg, kg m²]."""
    pos, full = numbers(body.center_of_mass), numbers(body.tensor.values())
    return f'<inertial pos="{pos}" mass="{number(body.mass)}" fullinertia="{full}"/>'


def write(body: Body) -> str:
    """A whole model: the body, free in the world."""
    name = quoted(body.name)
    frame = f"body frame: {body.frame}; SI units; inertia about the centre of mass"
    return f"""{xml_comment((frame, *body.notes))}
<mujoco model={name}>
  <worldbody>
    <body name={name}>
      <freejoint/>
      {inertial(body)}
    </body>
  </worldbody>
</mujoco>
"""


def file_warnings(model: str, _: str) -> list[Message]:
    """A warning for each setting of the model, an MJCF or a URDF, by which MuJoCo changes
    or ignores written inertials."""
    warnings = []
    if re.search(r"""\binertiafromgeom\s*=\s*["']true["']""", model):
        what = "the model says inertiafromgeom=true, which makes MuJoCo ignore every inertial"
        warnings.append(warning("inertials-ignored", what))
    if re.search(r"""\bsettotalmass\s*=\s*["']\s*[0.]*[1-9]""", model):
        what = (
            "the model says settotalmass, by which MuJoCo scales every mass and inertia"
        )
        warnings.append(warning("masses-scaled", what))
    if re.search(r"""\bbound(mass|inertia)\s*=\s*["']\s*[0.]*[1-9]""", model):
        what = "the model says boundmass or boundinertia, to which MuJoCo raises what is less"
        warnings.append(warning("inertials-raised", what))
    return warnings


TARGET = Target(
    name="mjcf",
    description="body of a MuJoCo model",
    suffixes=(".xml",),
    other_suffixes=(".mjcf",),
    write=write,
    needs_inertia=True,
    place=PLACE,
    inertial=inertial,
    file_warnings=file_warnings,
)
