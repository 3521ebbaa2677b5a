"""hefting export: write an estimate for a simulator or a robot controller."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.options import (
    ESTIMATE,
    add_export,
    add_object_frame,
    add_shape,
    check_output,
    fill_inertia_of,
    read_estimate,
)
from hefting.cli.parser import say, wrote
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.request.settings import in_object_frame, pose_of, require_shape, shape_of

if TYPE_CHECKING:
    from hefting.export import Exported

EXAMPLES = (
    "hefting export mug.json --to urdf --output mug.urdf",
    "hefting export mug.json --to urdf --into robot.urdf --link tool0",
    "hefting export mug.json --to mjcf --object-frame --into scene.xml --link mug",
    "hefting export mug.json --to ur --sensor-pose-in-flange 0,0,0.03,0,0,0,1",
    "hefting identify log.csv --json | hefting export - --to mjcf",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting export``."""
    from hefting.export import INSERTABLE, TARGETS
    from hefting.logs.registry import join_words

    parser.add_argument("estimate", metavar="ESTIMATE.json", help=ESTIMATE)
    targets = join_words(TARGETS, "or")
    parser.add_argument(
        "--to",
        metavar="TARGET",
        help=f"{targets}; default by the ending of --into or --output",
    )
    formats = join_words(INSERTABLE.values(), "or")
    parser.add_argument(
        "--into", metavar="FILE", help=f"put it into a link of this {formats} file"
    )
    parser.add_argument("--link", metavar="NAME", help="that link, or body")
    add_export(parser)
    add_object_frame(parser, "write in")
    add_shape(parser.add_argument_group("the object's shape, for --fill-inertia shape"))
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write there instead of printing"
    )


def run(arguments: argparse.Namespace) -> None:
    """Print or write the estimate in the target's form."""
    from hefting.export import REGISTRY, SUFFIXES, export

    a = arguments
    if a.to is None:
        suffix = Path(a.into or a.output or "").suffix.lower()
        a.to = SUFFIXES.get(suffix) or next(
            (t.name for t in REGISTRY.values() if suffix in t.other_suffixes), None
        )
    if a.to is None:
        raise InputError("missing", "--to", "see hefting export --help")
    pose = a.object_pose
    if a.object_frame:  # the shape is in it, too
        a.object_pose = None
    require_shape(a)
    if a.output:
        check_output(a.output, a)
        _check_suffix(a.output, a.to, a.into)
    flange = pose_of(a.sensor_pose_in_flange)
    shape = shape_of(a)
    fill = fill_inertia_of(a.fill_inertia, shape)
    if shape is not None and a.fill_inertia != "shape":
        what = "a shape is for --fill-inertia shape"
        raise InputError(what, fix="give that as well")
    estimate = read_estimate(a.estimate)
    exported = export(
        in_object_frame(estimate, pose) if a.object_frame else estimate,
        a.to,
        flange,
        a.into,
        a.link,
        accept=a.accept,
        fill_inertia=fill,
        say=render,
    )
    print_exported(exported, a.output)


def print_exported(exported: "Exported", path: str | None = None) -> None:
    """Print an exported text, or write it to a path, after its warnings."""
    for line in exported.warnings:
        say(f"warning: {render(line)}")
    if path:
        write_atomically(path, exported.text)
        wrote(f"{path} ({exported.frame} axes)")
    else:
        print(exported.text, end="" if exported.text.endswith("\n") else "\n")


def _check_suffix(path: str, target: str, into: str | None) -> None:
    """`InputError` for the suffix of another target; with ``--into``, that file's suffix
    is always allowed."""
    from hefting.export import REGISTRY

    suffix = Path(path).suffix.lower()
    if suffix in (".usdc", ".usdz"):
        raise InputError("is the name of a binary file", path, "use .usda")
    others = [
        each.name
        for each in REGISTRY.values()
        if suffix in (*each.suffixes, *each.other_suffixes)
    ]
    if not others or target in others or target not in REGISTRY:
        return
    if into is None or suffix != Path(into).suffix.lower():
        what = f"is the name of a file of {' or '.join(others)}, not of {target}"
        own = " or ".join(REGISTRY[target].suffixes)
        fix = f"choose a name that ends in {own}" if own else "choose another, as x.txt"
        raise InputError(what, path, fix)
