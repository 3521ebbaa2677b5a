"""hefting convert: read a log of any known format, and write it in another."""

import argparse
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.options import add_recording, check_output, read_recording

if TYPE_CHECKING:
    from hefting.core.recording import Recording
from hefting.cli.progress import progress

EXAMPLES = (
    "hefting convert held.mcap log.csv",
    "hefting convert log.csv log.parquet --map map.toml",
    "hefting convert joints.csv log.csv --urdf robot.urdf --sensor-frame tool0",
    "hefting convert log.csv short.csv --start 2 --duration 10",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting convert``."""
    add_recording(parser)
    parser.add_argument("output", metavar="OUTPUT", help=_output_help())
    parser.add_argument(
        "--start",
        type=float,
        metavar="S",
        default=0.0,
        help="leave out what is before [s]",
    )
    parser.add_argument(
        "--duration", type=float, metavar="S", help="write this much [s]"
    )


def run(arguments: argparse.Namespace) -> None:
    """Convert, and say what was read and chosen."""
    from hefting.logs import check_output as check_format
    from hefting.logs import write_log
    from hefting.logs.registry import find_writer

    a = arguments
    check_format(a.output)
    check_output(a.output, a.log, a.map, a.urdf)
    with progress("converting", stages={"reading the log": 1.0}):
        recording = read_recording(a)
        if a.start or a.duration is not None:
            recording = recording.slice(a.start, a.duration)
        lost = write_log(recording, a.output)
    print(render("\n".join(_told(recording))))
    if lost:
        print(
            f"warning: not written, as the format cannot hold it: {', '.join(name.replace('_', ' ') for name in lost)}"
        )
    written = find_writer(a.output)
    if recording.joint_names and written and written.is_table:
        print(
            f"warning: the names of the joints are not kept: q1.. are {', '.join(recording.joint_names)}"
        )
    print(f"wrote {a.output}")


def _output_help() -> str:
    """The suffixes that are written: of canonical tables, then of each other format."""
    from hefting.logs.registry import formats, join_words, table_formats

    parts = [
        "canonical "
        + join_words(
            [suffix for each in table_formats() for suffix in each.written], "or"
        )
    ]
    for each in formats():
        if each.written and not each.is_table:
            files = [suffix or "or a folder for no suffix" for suffix in each.written]
            parts.append(f"a {each.name}: {', '.join(files)}")
    return "; ".join(parts)


def _told(recording: "Recording") -> list[str]:
    """What was read: streams with samples and rates, then notes and warnings."""
    rates = recording.rates()
    lasts = "static poses" if recording.static else f"{recording.duration:.6g} s"
    lines = [f"{recording.source}: {lasts}"]
    for name, stream in recording.streams.items():
        rate = "static" if recording.static else f"{rates[name]:.4g} Hz"
        lines.append(
            f"  {name.replace('_', ' '):<22}{len(stream):>9} samples{rate:>12}"
        )
    return (
        lines
        + [f"note: {line}" for line in recording.notes]
        + [f"warning: {line}" for line in recording.warnings]
    )
