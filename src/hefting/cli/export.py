"""hefting export: an estimate in the form a simulator or a controller takes."""

from typing import Annotated

import typer

from hefting.cli.options import SensorPose


def export(
    estimate: Annotated[str, typer.Argument(metavar="ESTIMATE.json", help="Written by hefting identify --output.")],
    to: Annotated[str, typer.Option(metavar="TARGET", help="urdf, mjcf, sdf, usd, ur, xarm, franka, kuka, abb, fanuc, csv or json.")],
    into: Annotated[str | None, typer.Option(metavar="FILE", help="Put it into a link of this URDF, MJCF or SDF file.")] = None,
    link: Annotated[str | None, typer.Option(metavar="NAME", help="That link, or body.")] = None,
    sensor_pose_in_flange: SensorPose = None,
    output: Annotated[str | None, typer.Option(metavar="FILE", help="Write there instead of printing.")] = None,
) -> None:
    """Write an estimate for a simulator or a robot controller."""
    from hefting.estimate import Estimate
    from hefting.export import export as run
    from hefting.files import write_atomically
    from hefting.shapes import parse_pose

    flange = parse_pose(sensor_pose_in_flange) if sensor_pose_in_flange else None
    exported = run(Estimate.load(estimate), to, flange, into, link)
    for line in exported.warnings:
        typer.echo(f"hefting: warning: {line}", err=True)
    if output:
        write_atomically(output, exported.text)
        typer.echo(f"wrote {output} ({exported.frame} axes)")
    else:
        typer.echo(exported.text, nl=not exported.text.endswith("\n"))
