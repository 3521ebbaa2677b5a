"""hefting identify: from a log to mass, centre of mass and inertia."""

from typing import Annotated, Any

import typer

from hefting.cli.options import DEFAULT_GRAVITY, Gravity, Json, Log, SensorPose, numbers, progress


def identify(
    log: Log,
    method: Annotated[str, typer.Option(help="PMD or OLS.")] = "PMD",
    shape: Annotated[
        str | None, typer.Option(metavar="FILE|box:X0,X1,Y0,Y1,Z0,Z1", help="Mesh, point cloud or labelled parts; or a box in the sensor frame [m].")
    ] = None,
    unit: Annotated[str | None, typer.Option(metavar="m|cm|mm|in", help="Length unit of the shape's file.")] = None,
    object_pose: Annotated[
        str | None, typer.Option(metavar="POSE", help="The shape's frame in the sensor frame: x,y,z,qx,qy,qz,qw [m], or a JSON file.")
    ] = None,
    points: Annotated[int | None, typer.Option(help="About how many point masses (default 56).")] = None,
    points_per_cm3: Annotated[float | None, typer.Option("--points-per-cm3", help="Their density instead.")] = None,
    gravity: Gravity = DEFAULT_GRAVITY,
    wrench: Annotated[str, typer.Option(metavar="auto|on-object|on-sensor", help="Whom the recorded wrench acts on.")] = "auto",
    bias: Annotated[
        str, typer.Option(metavar="auto|none|estimate|tare:START,END|FILE", help="Constant wrench bias.")
    ] = "auto",
    motion: Annotated[
        str, typer.Option(metavar="auto|columns|smooth|filter", help="Where velocities and accelerations come from.")
    ] = "auto",
    start: Annotated[float, typer.Option(metavar="S", help="Leave out what is before [s].")] = 0.0,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Use this much [s].")] = None,
    c1: Annotated[float | None, typer.Option(help="PMD: dynamism at which the full model takes over (default 300; 1 with smoothed poses).")] = None,
    regularization: Annotated[float | None, typer.Option(help="PMD: lambda (default 0.1).")] = None,
    truth: Annotated[str | None, typer.Option(metavar="FILE", help="True parameters or another estimate (JSON), to compare with.")] = None,
    output: Annotated[
        list[str] | None, typer.Option(metavar="FILE", help="Write .json, .urdf, .xml (MJCF), .sdf, .usda or .csv; repeatable.")
    ] = None,
    sensor_pose_in_flange: SensorPose = None,
    json: Json = False,
) -> None:
    """Identify the object in a recording."""
    from pathlib import Path

    from hefting.calibration import load_bias, tare
    from hefting.errors import InputError
    from hefting.export import SUFFIXES, export
    from hefting.files import write_atomically
    from hefting.identification import identify as run
    from hefting.logs import read_log
    from hefting.shapes import load_shape, parse_pose
    from hefting.truth import load_truth

    for path in output or ():
        if Path(path).suffix not in SUFFIXES:
            raise InputError(f"'{Path(path).suffix}' is not an output format", where=path, fix=f"use {', '.join(SUFFIXES)}")
        if not Path(path).absolute().parent.is_dir():
            raise InputError("the folder does not exist", where=path)
    g = numbers(gravity, 3, "--gravity")
    pose = parse_pose(object_pose) if object_pose else None
    flange = parse_pose(sensor_pose_in_flange) if sensor_pose_in_flange else None
    known = load_truth(truth) if truth else None
    settings: dict[str, Any] = {"c1": c1, "regularization": regularization}
    settings = {name: value for name, value in settings.items() if value is not None}
    if settings and method != "PMD":
        raise InputError(f"{method} has no {' or '.join(settings)}", where="--method")

    with progress("identifying ..."):
        recording = read_log(log)
        masses = load_shape(shape, unit, pose, points, points_per_cm3) if shape else None
        wrench_bias: Any = bias
        if bias.startswith("tare:"):
            wrench_bias = tare(recording, *numbers(bias[5:], 2, "--bias tare:START,END"))
        elif bias not in ("auto", "none", "estimate"):
            wrench_bias = load_bias(bias)
        found = run(
            recording, masses, method=method, gravity=g, wrench=wrench, bias=wrench_bias, motion=motion,  # type: ignore[arg-type]
            start=start, duration=duration, **settings,
        )
    estimate = found.estimate
    errors = known.errors(estimate.parameters, masses) if known else None
    texts = [(path, export(estimate, SUFFIXES[Path(path).suffix], flange)) for path in output or ()]
    for path, exported in texts:
        write_atomically(path, exported.text)
    if json:
        import json as encoder

        from hefting.estimate import json_ready

        result = estimate.to_dict()
        if errors is not None:
            result["errors"] = json_ready(errors.to_dict())
        typer.echo(encoder.dumps(result))
        return
    from hefting.report import estimate_report, print_report

    print_report(estimate_report(estimate, known.parameters if known else None, errors))
    for path, exported in texts:
        typer.echo(f"wrote {path} ({exported.frame} axes)")
        for line in exported.warnings:
            typer.echo(f"warning: {line}")
