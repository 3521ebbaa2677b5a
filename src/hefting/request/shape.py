"""The object's shape: a file, its convex hull, or a box."""

import re
from typing import TYPE_CHECKING, Any

from hefting.core.errors import InputError
from hefting.core.quantity import quantities

if TYPE_CHECKING:
    from hefting.core.spatial import Array
    from hefting.shapes import Shape


def shape_of(a: Any) -> "Shape | None":
    """The shape that was given, if one was. `InputError` as `hefting.load_shape`."""
    if a.hull and (a.shape is None or a.shape.lower().startswith("box:")):
        raise InputError("whose convex hull?", "--hull", "give --shape FILE")
    from hefting.shapes import load_shape, parse_pose

    pose = parse_pose(a.object_pose) if a.object_pose else None
    if a.box is None and a.shape is None:
        return None
    if a.box is not None:
        return _box(a, pose)
    return load_shape(a.shape, a.unit, pose, a.points, a.points_per_cm3, a.hull)


def require_shape(a: Any) -> None:
    """`InputError` where something is said of a shape that was not given."""
    if a.shape is not None or a.box is not None:
        return
    said = ("unit", "object_pose", "pose_std", "shape_std", "points", "points_per_cm3")
    for name in said:
        if getattr(a, name) is not None:
            option = "--" + name.replace("_", "-")
            fix = "give --shape FILE or --box X,Y,Z, or leave it out"
            raise InputError("of which shape?", option, fix)


def _box(a: Any, pose: "Array | None") -> "Shape":
    """The box whose sides were given, about the origin of a pose."""
    from hefting.shapes import Shape

    for option, given in (("--shape", a.shape), ("--unit", a.unit)):
        if given is not None:
            what, fix = "is given beside --box", "leave one of them out"
            raise InputError(what, option, fix)
    in_metres = re.sub(r"(?<=[\d.])\s*(?=,|$)", "m", a.box)
    try:
        sides = quantities(in_metres, ("length",) * 3, "--box", "")
    except InputError:
        sides = (0.0,)
    if not min(sides) > 0.0:
        what, fix = f"'{a.box}' is not three lengths", "as in 0.1,0.2,0.3 in metres"
        raise InputError(what, "--box", fix)
    low_to_high = [sign * side / 2 for side in sides for sign in (-1, 1)]
    return Shape.from_box(
        *low_to_high, points=a.points, points_per_cm3=a.points_per_cm3, pose=pose
    )
