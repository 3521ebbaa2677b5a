"""KUKA: load data in KRL, with its frame and units in a comment."""

import numpy as np

from hefting.core.quantity import rounded
from hefting.core.spatial import Array
from hefting.export.body import Body
from hefting.export.known import comment, in_single, named
from hefting.export.target import Target


def write(body: Body) -> str:
    """KRL load data: kg; mm; A, B, C [deg] turn the flange about Z, then the new Y,
    then the newest X into the principal axes, whose moments about the COM are J [kg
    m²].

    Load data in the KUKA assembly instructions, e.g. MA KR IONTEC V4, section
    "Payloads".
    """
    moments, axes = body.principal()
    com = named(in_single(1e3 * body.center_of_mass), "XYZ")
    degrees = rounded(np.degrees(zyx_angles(axes)), body.angle_places)
    angles = named(in_single(degrees), "ABC")
    return (
        comment(
            ";",
            body,
            "kg, mm, deg, kg m^2: principal moments J about the centre of mass; A B C turn about Z, Y', X''",
            "assign to $LOAD, or to LOAD_DATA[n] of tool n",
        )
        + f"{{M {in_single(body.mass)[0]}, CM {{{com}, {angles}}}, J {{{named(in_single(moments), 'XYZ')}}}}}\n"
    )


def zyx_angles(rotation: Array) -> Array:
    """Angles (3,) [rad] A, B, C with rotation (3, 3) = Rz(A) Ry(B) Rx(C); B in [-π/2,
    π/2].

    C is found after turning back by A, which stays exact at B = ±π/2, where A is
    arbitrary.
    """
    R = rotation
    a = np.arctan2(R[1, 0], R[0, 0])
    b = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    s, c = np.sin(a), np.cos(a)
    return np.array(
        (a, b, np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1]))
    )


TARGET = Target(
    name="kuka", description="KUKA: KRL load data", write=write, wants_flange=True
)
