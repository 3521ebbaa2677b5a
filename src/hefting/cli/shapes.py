"""The object's shape on the command line: a file, its convex hull, or a box."""

import argparse

from hefting.cli.options import POSE, add_number


def add_shape(parser: argparse._ActionsContainer) -> None:
    """The shape, and where it is."""
    parser.add_argument(
        "--shape",
        metavar="FILE",
        help="mesh, point cloud or labelled parts; or box:X0,X1,Y0,Y1,Z0,Z1 in the "
        "sensor frame [m]",
    )
    parser.add_argument(
        "--unit", metavar="m|cm|mm|in", help="length unit of its file; default m"
    )
    parser.add_argument(
        "--object-pose",
        metavar="POSE",
        help=f"the file's frame in the sensor frame: {POSE}",
    )
    parser.add_argument(
        "--box",
        metavar="X,Y,Z",
        help="instead of a file: the sides [m] of a box that holds the object, its "
        "centre at --object-pose, else at the sensor; --box 10cm,20cm,5cm works too",
    )
    parser.add_argument(
        "--hull",
        action="store_true",
        help="take the convex hull of the shape's file, as where its mesh has holes",
    )


def add_shape_details(group: argparse._ActionsContainer) -> None:
    """How well the shape is known, and of how many points it is made."""
    from hefting.estimators import methods_with

    pose, shape = (", ".join(methods_with(name)) for name in ("pose_std", "shape_std"))
    group.add_argument(
        "--pose-std",
        metavar="LENGTH,ANGLE",
        help=f"{pose}: how well --object-pose is known, as in 5mm,5deg; 0mm,0deg: "
        "exactly; default perhaps exactly, perhaps some 5 mm and 5° off",
    )
    group.add_argument(
        "--shape-std",
        metavar="SHARE",
        help=f"{shape}: how well the shape is known, as in 20%%; default exactly, "
        "20%% for a hull, less for a mesh with holes; a box only holds the object",
    )
    group.add_argument(
        "--points",
        type=int,
        metavar="N",
        help="about how many point masses; default 56",
    )
    add_number(group, "--points-per-cm3", "D", "their density instead")
