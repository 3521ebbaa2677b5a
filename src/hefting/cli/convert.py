"""hefting convert: read a log of any known format, and write it in another."""

import argparse
from typing import TYPE_CHECKING

from hefting.cli import option_of, render
from hefting.cli.options import (
    add_part,
    add_recording,
    add_shape,
    check_output,
    part_of,
    read_estimate,
    read_recording,
)
from hefting.cli.parser import WIDTH, wrapped, wrote
from hefting.cli.progress import progress
from hefting.core.errors import InputError, printable
from hefting.request.settings import require_shape, shape_of

if TYPE_CHECKING:
    from hefting.core.recording import Recording

EXAMPLES = (
    "hefting convert held.mcap log.csv",
    "hefting convert log.csv log.parquet --map map.toml",
    "hefting convert joints.csv log.csv --urdf robot.urdf --sensor-frame tool0",
    "hefting convert log.csv short.csv --start 2 --duration 10",
    "hefting convert log.csv mug.mcap --with mug.json --shape mug.stl",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting convert``."""
    add_recording(parser)
    parser.add_argument("output", metavar="OUTPUT", help=_output_help())
    add_part(parser, "write")
    parser.add_argument(
        "--with",
        dest="estimate",
        metavar="ESTIMATE.json",
        help="write what was found as well, for Foxglove (.mcap)",
    )
    add_shape(parser.add_argument_group("the object's shape, drawn with --with"))


def run(arguments: argparse.Namespace) -> int:
    """Convert, and print what was read and chosen; returns the exit status."""
    a = arguments
    if a.estimate is not None:
        return _run_with_estimate(a)
    _refuse_shape(a)
    _run_plain(a)
    return 0


def _refuse_shape(a: argparse.Namespace) -> None:
    """`InputError` for an option of a shape, which only an estimate is drawn with."""
    for option in ("shape", "box", "object_pose", "unit", "hull"):
        if getattr(a, option):
            fix = "give --with ESTIMATE.json"
            raise InputError("is for --with", option_of(option), fix)


def _run_plain(a: argparse.Namespace) -> None:
    from hefting.logs import check_output as check_format
    from hefting.logs import write_log
    from hefting.logs.registry import find_writer

    check_format(a.output)
    check_output(a.output, a)
    with progress("converting", stages={"reading the log": 1.0}):
        recording = part_of(a, read_recording(a))
        lost = write_log(recording, a.output)
    _print([*_description(recording), *_not_written(lost)])
    written = find_writer(a.output)
    if recording.joint_names and written and written.is_table:
        names = ", ".join(recording.joint_names)
        _print([f"warning: the names of the joints are not kept: q1.. are {names}"])
    wrote(a.output)


def _run_with_estimate(a: argparse.Namespace) -> int:
    """Write the recording and an estimate for a dashboard; returns the exit status, 3 for
    an estimate that is not to be used."""
    from hefting.cli.report import exit_status
    from hefting.dashboards import dashboard_for, replay_of, write_dashboard

    require_shape(a)
    dashboard_for(a.output).check()
    check_output(a.output, a)
    if a.log == a.estimate == "-":
        raise InputError("is the log already", "--with -", "name a file for one")
    estimate, shape = read_estimate(a.estimate), shape_of(a)
    with progress("converting"):
        recording = part_of(a, read_recording(a))
        replay = replay_of(recording, estimate, shape)
        lost = write_dashboard(replay, a.output, render)
    _print([*_description(recording), *_not_written(lost)])
    print(printable(f"verdict of {a.estimate}: {estimate.verdict}"))
    _print([f"warning: {line}" for line in replay.warnings])
    wrote(a.output)
    return exit_status(estimate.verdict)


def _not_written(streams: tuple[str, ...]) -> list[str]:
    """A warning of streams that the output does not hold, if any."""
    names = ", ".join(name.replace("_", " ") for name in streams)
    what = f"warning: not written, as the format cannot hold it: {names}"
    return [what] if names else []


def _print(lines: list[str]) -> None:
    """Print lines wrapped to `WIDTH`, with options in place of the library's
    arguments."""
    for line in lines:
        print(wrapped(printable(render(line)), WIDTH))


def _output_help() -> str:
    """The suffixes of canonical tables, then of each other format that is written."""
    from hefting.logs.registry import formats, join_words, table_formats

    tables = [suffix for each in table_formats() for suffix in each.written]
    parts = [f"canonical {join_words(tables, 'or')}"]
    for each in formats():
        if each.written and not each.is_table:
            files = [suffix or "or no suffix for a folder" for suffix in each.written]
            parts.append(f"a {each.name}: {', '.join(files)}")
    return "; ".join(parts)


def _description(recording: "Recording") -> list[str]:
    """Lines on the streams with samples and rates, then notes and warnings."""
    rates = recording.rates()
    lasts = "static poses" if recording.static else f"{recording.duration:.6g} s"
    lines = [f"{recording.source}: {lasts}"]
    for name, stream in recording.streams.items():
        rate = "static" if recording.static else f"{rates[name]:.4g} Hz"
        label = name.replace("_", " ")
        lines.append(f"  {label:<22}{len(stream):>9} samples{rate:>12}")
    lines += [f"note: {line}" for line in recording.notes]
    return lines + [f"warning: {line}" for line in recording.warnings]
