"""MJCF: the inertial element of a body. https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial

`pos` is the COM; `fullinertia` is Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the COM in the body's axes.
"""

import re
from xml.sax.saxutils import quoteattr

from hefting.export.body import Body, number, numbers
from hefting.export.splice import Place

PLACE = Place("MJCF", roots=("mujoco", "mujocoinclude"), element="body", parents=None)


def inertial(body: Body) -> str:
    """The inertial element [m, kg, kg m²]."""
    pos, full = numbers(body.center_of_mass), numbers(body.tensor.values())
    return f'<inertial pos="{pos}" mass="{number(body.mass)}" fullinertia="{full}"/>'


def write(body: Body) -> str:
    """A whole model: the body, free in the world."""
    name = quoteattr(body.name)
    return f"""<!-- body frame: {body.frame}; SI units; inertia about the centre of mass -->
<mujoco model={name}>
  <worldbody>
    <body name={name}>
      <freejoint/>
      {inertial(body)}
    </body>
  </worldbody>
</mujoco>
"""


def ignores_inertial(model: str) -> bool:
    """Whether the model's text makes MuJoCo compute inertia from geoms alone."""
    return re.search(r"""\binertiafromgeom\s*=\s*["']true["']""", model) is not None
