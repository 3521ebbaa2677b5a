"""USD: a rigid body with UsdPhysics mass properties, as usda text.

https://openusd.org/release/api/class_usd_physics_mass_a_p_i.html centerOfMass,
diagonalInertia and principalAxes are in the prim's axes and in the stage's units, here
metres and kilograms; the quaternion is w first. Readers keep single precision: the
attributes are floats.
"""

from hefting.export.body import Body, number, numbers
from hefting.export.known import wrapped
from hefting.export.target import Target


def write(body: Body) -> str:
    """A stage whose default prim is the body."""
    name = (
        body.identifier if not body.identifier[0].isdigit() else f"_{body.identifier}"
    )
    frame = f"prim frame: {body.frame}; SI units; inertia about the centre of mass"
    text = "\n".join(wrapped((frame, *body.notes)))
    doc = text.replace("\\", "/").replace('"', "'")
    return f"""#usda 1.0
(
    defaultPrim = "{name}"
    doc = \"\"\"{doc}\"\"\"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)

def Xform "{name}" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
)
{{
    float physics:mass = {number(body.mass)}
    point3f physics:centerOfMass = ({numbers(body.center_of_mass, ", ")})
    float3 physics:diagonalInertia = ({numbers(body.principal()[0], ", ")})
    quatf physics:principalAxes = ({numbers(body.quaternion(), ", ")})
}}
"""


TARGET = Target(
    name="usd",
    description="rigid body of a USD stage, usda text (Isaac Sim)",
    suffixes=(".usda",),
    other_suffixes=(".usd",),
    write=write,
    needs_inertia=True,
)
