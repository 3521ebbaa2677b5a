"""hefting identify: find mass, COM and inertia of the object in a recording."""

import argparse

from hefting.cli.options import POSE, add_json, add_log, add_sensor_pose, numbers, progress
from hefting.errors import InputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting identify``."""
    add_log(parser)
    parser.add_argument("--method", default="PMD", help="PMD (default) or OLS")
    shape = parser.add_argument_group("the object's shape")
    shape.add_argument(
        "--shape",
        metavar="FILE|box:X0,X1,Y0,Y1,Z0,Z1",
        help="mesh, point cloud or labelled parts; or a box in the sensor frame [m]",
    )
    shape.add_argument("--unit", metavar="m|cm|mm|in", help="length unit of its file; default m")
    shape.add_argument("--object-pose", metavar="POSE", help=f"the file's frame in the sensor frame: {POSE}")
    shape.add_argument("--points", type=int, metavar="N", help="about how many point masses; default 56")
    shape.add_argument("--points-per-cm3", type=float, metavar="D", help="their density instead")
    log = parser.add_argument_group("reading the log")
    log.add_argument(
        "--wrench", metavar="auto|on-object|on-sensor", default="auto", help="whom the recorded wrench acts on"
    )
    log.add_argument(
        "--bias", metavar="auto|none|estimate|tare:START,END|FILE", default="auto", help="constant wrench bias"
    )
    log.add_argument(
        "--motion",
        metavar="auto|columns|smooth|filter",
        default="auto",
        help="velocities and accelerations: of the log, or from its poses",
    )
    log.add_argument("--start", type=float, metavar="S", default=0.0, help="leave out what is before [s]")
    log.add_argument("--duration", type=float, metavar="S", help="use this much [s]")
    pmd = parser.add_argument_group("PMD")
    pmd.add_argument(
        "--c1", type=float, help="dynamism at which the full model takes over; default 300, 1 with smoothed poses"
    )
    pmd.add_argument("--regularization", type=float, metavar="LAMBDA", help="pull to equal masses; default 0.1")
    results = parser.add_argument_group("results")
    results.add_argument("--truth", metavar="FILE", help="true parameters or another estimate, to compare with (JSON)")
    results.add_argument(
        "--output",
        metavar="FILE",
        action="append",
        default=[],
        help="write .json, .urdf, .xml (MJCF), .sdf, .usda or .csv; repeatable",
    )
    add_sensor_pose(results)
    add_json(results)


def run(arguments: argparse.Namespace) -> None:
    """Identify, save what was asked for, and print the result."""
    from dataclasses import replace
    from pathlib import Path

    from hefting.export import SUFFIXES, export
    from hefting.files import write_atomically
    from hefting.identification import identify
    from hefting.logs import read_log
    from hefting.shapes import load_shape, parse_pose
    from hefting.truth import load_truth

    a = arguments
    for path in a.output:
        if Path(path).suffix not in SUFFIXES:
            raise InputError(f"'{Path(path).suffix}' is not an output format", path, f"use {', '.join(SUFFIXES)}")
        if not Path(path).absolute().parent.is_dir():
            raise InputError("the folder does not exist", where=path)
        inputs = (a.log, a.shape, a.truth, a.bias, a.object_pose)
        if any(Path(path).resolve() == Path(name).resolve() for name in inputs if name):
            raise InputError("is an input and would be overwritten", where=path, fix="choose another name")
    gravity = numbers(a.gravity, 3, "--gravity")
    pose = parse_pose(a.object_pose) if a.object_pose else None
    flange = parse_pose(a.sensor_pose_in_flange) if a.sensor_pose_in_flange else None
    known = load_truth(a.truth) if a.truth else None
    settings = {name: getattr(a, name) for name in ("c1", "regularization") if getattr(a, name) is not None}

    with progress("identifying ..."):
        recording = read_log(a.log)
        shape = load_shape(a.shape, a.unit, pose, a.points, a.points_per_cm3) if a.shape is not None else None
        found = identify(
            recording,
            shape,
            method=a.method,
            gravity=gravity,
            wrench=a.wrench,
            bias=_bias(a.bias, recording),
            motion=a.motion,
            start=a.start,
            duration=a.duration,
            **settings,
        )
    made = {"shape": a.shape, "unit": a.unit, "object_pose": a.object_pose} if a.shape else {}
    estimate = replace(found.estimate, provenance=found.estimate.provenance | made)
    errors = known.errors(estimate.parameters, shape) if known else None
    texts = [(path, export(estimate, SUFFIXES[Path(path).suffix], flange)) for path in a.output]
    for path, exported in texts:
        write_atomically(path, exported.text)
    if a.json:
        import json

        from hefting.estimate import json_ready

        result = estimate.to_dict()
        if errors is not None:
            result["errors"] = json_ready(errors.to_dict())
        result["warnings"] += [f"{path}: {line}" for path, exported in texts for line in exported.warnings]
        print(json.dumps(result))
        return
    from hefting.report import estimate_report, print_report

    print_report(estimate_report(estimate, known.parameters if known else None, errors))
    for path, exported in texts:
        print(f"wrote {path} ({exported.frame} axes)")
        for line in exported.warnings:
            print(f"warning: {line}")


def _bias(text: str, recording):
    """A bias model's name, or six numbers from a tare window or a file."""
    from hefting.calibration import load_bias, tare

    if text in ("auto", "none", "estimate"):
        return text
    if text.startswith("tare:"):
        return tare(recording, *numbers(text[5:], 2, "--bias tare:START,END"))
    return load_bias(text)
