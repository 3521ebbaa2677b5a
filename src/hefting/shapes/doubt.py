"""Doubt: how far a shape may be from the object it stands for."""

from hefting.core.errors import InputError

KNOWN = ("object", "bounds", "reach")
"""What may be known of an object: its shape, a box around it, or nothing."""
REACH = 0.5
"""[m] Distance from the sensor, along each axis, within which a held object is taken to
be."""
ROUGH = 0.2
"""`Shape.shape_std` of a box or a hull that is only known to hold the object."""
SMALL_CAPS = 0.02
"""Share of a surface in the caps of its holes up to which they do not matter."""
DOUBT_OF_CAPS = 0.5
"""`Shape.shape_std` of a mesh with holes over the share of the caps, up to `ROUGH`:
nobody knows how the object bulges where the mesh has a hole. With meshes of which a
fifth to a half is missing on one side, 95 % intervals hold 95 to 96 %; without it 92.5
at 150 samples."""


def doubt_of_caps(share: float) -> float:
    """`Shape.shape_std` of a mesh whose caps have this share of its surface."""
    return min(DOUBT_OF_CAPS * share, ROUGH) if share > SMALL_CAPS else 0.0


def check_doubt(known: str, shape_std: float) -> None:
    """`InputError` for what cannot be known of a shape, or a deviation that is no
    share."""
    if known not in KNOWN:
        raise InputError(
            f"what is known of a shape is one of {', '.join(KNOWN)}, not {known}"
        )
    if not 0.0 <= shape_std <= 1.0:
        raise InputError(f"a shape's deviation is a share from 0 to 1, not {shape_std}")
