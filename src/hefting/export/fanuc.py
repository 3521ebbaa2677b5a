"""Fanuc: lines of a payload schedule, with their frame and units in a comment."""

import numpy as np

from hefting.core.messages import Message, warning
from hefting.core.quantity import rounded
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.export.body import Body
from hefting.export.known import comment, in_single
from hefting.export.target import Target

KGF_CM_S2 = -STANDARD_GRAVITY[2] * 0.01
"""One kgf cm s² [kg m²], the unit of Fanuc's moments: 1 kg m² is 10.197 of them."""


def write(body: Body) -> str:
    """Lines of the MOTION/PAYLOAD SET screen: kg; **cm** from the faceplate; moments
    about axes through the COM, parallel to the faceplate's, in **kgf cm s²**. Products of
    inertia have no place.
    """
    com = in_single(1e2 * body.center_of_mass)
    # the unit is about 0.1 kg m²: one decimal place less has the same resolution
    places = body.inertia_places - 1
    moments = in_single(rounded(np.diag(body.inertia) / KGF_CM_S2, places))
    rows = [
        ("PAYLOAD           [kg]", in_single(body.mass)[0]),
        *(
            (f"PAYLOAD CENTER {axis}  [cm]", value)
            for axis, value in zip("XYZ", com, strict=True)
        ),
        *(
            (f"PAYLOAD INERTIA {axis} [kgfcms^2]", value)
            for axis, value in zip("XYZ", moments, strict=True)
        ),
    ]
    return comment(
        "!",
        body,
        "kg, cm, kgf cm s^2 (1 kg m^2 = 10.197): moments about the centre of mass along the faceplate's axes",
        "type into a schedule of MENU > SYSTEM > Motion; X, Y, Z are the faceplate's, whatever the UTOOL",
    ) + "".join(f"{label:<32}: {value}\n" for label, value in rows)


def warnings(body: Body) -> list[Message]:
    """A warning if a product of inertia is above a hundredth of the largest moment."""
    moments = np.diag(body.inertia)
    products = body.inertia - np.diag(moments)
    share = float(np.abs(products).max() / (moments.max() or 1.0))
    if share <= 0.01:
        return []
    what = f"Fanuc takes no products of inertia: up to {100 * share:.0f} % of the largest moment is left out"
    return [warning("products-left-out", what)]


TARGET = Target(
    name="fanuc",
    description="Fanuc: payload schedule",
    write=write,
    wants_flange=True,
    warnings=warnings,
)
