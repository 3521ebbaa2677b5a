"""Files that hefting simulate writes."""

import argparse
from pathlib import Path

from hefting.core.errors import InputError


def truth_of(a: argparse.Namespace) -> Path:
    """Where the truth goes."""
    output = Path(a.output)
    stem = output.with_suffix("").name
    return Path(a.truth) if a.truth else output.with_name(f"{stem}.truth.json")


def check_outputs(a: argparse.Namespace, truth: Path, *more: Path) -> None:
    """`InputError` for an output that cannot or must not be written."""
    from hefting.core.files import check_replaceable
    from hefting.logs import check_output
    from hefting.shapes.reading import MESH_SUFFIXES

    check_output(a.output)
    if a.mesh and Path(a.mesh).suffix.lower() not in MESH_SUFFIXES:
        raise InputError(
            f"'{Path(a.mesh).suffix}' is not a mesh format",
            a.mesh,
            f"use {', '.join(MESH_SUFFIXES)}",
        )
    outputs = [str(path) for path in (a.output, truth, a.mesh, *more) if path]
    inputs = [*a.object.split(","), a.arm, *([a.object_pose] if a.object_pose else [])]
    for i, path in enumerate(outputs):
        if not Path(path).absolute().parent.is_dir():
            raise InputError("the folder does not exist", where=path)
        if any(Path(path).resolve() == Path(name).resolve() for name in inputs):
            raise InputError(
                "is an input and would be overwritten",
                where=path,
                fix="choose another name",
            )
        if any(Path(path).resolve() == Path(name).resolve() for name in outputs[:i]):
            raise InputError(
                "two results would have this name",
                where=path,
                fix="choose another name",
            )
        if not Path(path).is_dir():  # the writer of a bag's folder refuses one
            check_replaceable(path, *inputs)
