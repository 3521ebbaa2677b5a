"""A shape in a notebook: what is known, where it is, and a picture."""

from hefting.notebook.html import (
    beside,
    block,
    list_html,
    paragraph,
    picture_html,
    table_html,
)
from hefting.scene import place_of, scene_of
from hefting.shapes import Shape

KNOWN = {
    "object": "the object's own shape",
    "bounds": "the object is somewhere inside",
    "reach": "the object is somewhere about the sensor, of any size",
}
ALT = "the shape in three views, in sensor axes"


def shape_html(shape: Shape) -> str:
    """A shape as a block."""
    sides = " × ".join(f"{1e3 * side:.1f}" for side in shape.extents)
    rows = [
        ("known", KNOWN.get(shape.known, shape.known)),
        ("points", f"{shape.n:,}"),
        ("triangles", "none" if shape.faces is None else f"{len(shape.faces):,}"),
        ("bounding box [mm]", sides),
    ]
    if shape.shape_std:
        rows.append(("may differ by (std)", f"{shape.shape_std:.0%} of its size"))
    scene = scene_of(shape=shape, known={"uniform shape": shape.homogeneous})
    picture = picture_html(scene.with_centers_only(), ALT)
    words = "".join(paragraph(line) for line in place_of(shape))
    warnings = list_html(f"warning: {text}" for text in shape.warnings)
    left = table_html(("Shape", "in sensor axes"), rows) + words
    return block(warnings, beside(left, picture))
