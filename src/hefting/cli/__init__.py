"""Command line: parse, call one library function, print or save.

Plain `argparse`, the file and parser of one command only, and imports of the library
inside the commands make ``hefting --help`` and the start of every command quick.
"""

import argparse
import codecs
import contextlib
import io
import os
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from textwrap import wrap

from hefting.cli.parser import WIDTH, Parser, did_you_mean, say
from hefting.core.errors import HeftingError, InputError, spell_out
from hefting.core.threads import use_one_thread

STATUS_STOPPED = 130
"""Exit status of a command that Ctrl-C ended, as in shells."""

SPELL_OUT = "hefting.spell-out"
"""Name of the error handler for signs that an encoding does not have."""

COMMANDS = {
    "demo": "simulate a robot arm wielding a hammer, identify it, write pictures.",
    "inspect": "say what a log holds, its conventions, and what can be found from it.",
    "identify": "find mass, COM and inertia of the object in one or several recordings.",
    "compare": "check whether estimates can be of the same object, by their intervals.",
    "live": "mass, COM and inertia while the robot moves, from the streams it sends.",
    "batch": "identify the objects in many recordings, into one table.",
    "map": "guess a column map from the names and numbers of a log, to be checked.",
    "methods": "list the methods, what each needs and what it guarantees.",
    "completion": "print what a shell needs to complete commands and options.",
    "calibrate": "measure an empty gripper, its bias and noise, for --tool and --bias.",
    "convert": "read a log of any known format, and write it in another.",
    "export": "write an estimate for a simulator or a robot controller.",
    "check": "find links of a URDF with inertials that no body can have, and repair them.",
    "plan": "find the motion to make next, for what is still unknown, within limits.",
    "predict": "predict the wrench that an identified object needs along a motion, and its uncertainty.",
    "reproduce": "run the paper's experiments on simulated data, beside the published figures.",
    "show": "draw a shape as it is posed on the sensor, to check the pose by eye.",
    "view": "see object, wrench and arm along a recording, in a browser.",
    "simulate": "write the log of a simulated robot that wields an object, and the truth beside it.",
}
"""Every command and its help. Its module has `add_arguments(parser)` and
`run(arguments)`."""


def option_of(name: str) -> str:
    """Option of an argument of the library that has the same name."""
    return f"--{name.replace('_', '-')}"


OPTIONS = {
    "pose": "--object-pose",
    "column_map": "--map",
    "poses": "--poses",
    "sign": "--wrench",
    "noise": "--sensor-noise",
} | {
    name: option_of(name)
    for name in (
        *("shape", "unit", "object_pose", "points", "points_per_cm3"),
        *("pose_std", "shape_std", "hull", "mass", "tool", "until", "method"),
        *("gravity", "sensor_accuracy", "wrench", "bias", "motion", "start"),
        *("duration", "truth", "map", "urdf", "sensor_frame", "accept"),
        *("sensor_pose_in_flange", "sensor_pose_in_log", "sensor_turned"),
        *("output", "report", "into", "link", "fill_inertia", "torques"),
        *("empty", "arm", "torque_gains", "tip", "estimate", "speed", "acceleration"),
        *("jerk", "keep", "srdf", "rate", "sensor_range", "sensor_noise"),
        *("stop_and_go", "seed", "resume", "jobs"),
    )
}
"""Option of each argument of the library that a message may name, besides those of
methods and log formats."""


def build_parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of ``hefting``, with the arguments of the command in `words`.

    `InputError` for an unknown command, and for unknown options of the command.
    """
    from hefting import __version__

    about = "Tells what a robot is holding: mass, centre of mass and inertia tensor."
    more = "hefting COMMAND --help shows more of each, with examples."
    parser = Parser(
        prog="hefting", usage="hefting COMMAND ...", description=about, epilog=more
    )
    parser.add_argument(
        "--version", action="version", version=__version__, help="print the version"
    )
    commands = parser.add_subparsers(
        title="commands",
        prog="hefting",
        metavar="COMMAND",
        required=True,
        parser_class=Parser,
    )
    place = next((i for i, w in enumerate(words) if not w.startswith("-")), len(words))
    parser.check_options(words[:place], " before the command")
    chosen = "".join(words[place : place + 1])
    if chosen and chosen not in COMMANDS:
        guess = did_you_mean(chosen, COMMANDS)
        parser.error(f"there is no command '{chosen[:40]}'{guess}")
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=sentence(text))
        if name == chosen:
            add_command(command, name)
            command.check_options(words[place + 1 :])
    return parser


def build_whole_parser() -> argparse.ArgumentParser:
    """The parser of ``hefting`` with the arguments of every command."""
    parser = build_parser(())
    for name, command in commands_of(parser).items():
        add_command(command, name)
    return parser


def commands_of(
    parser: argparse.ArgumentParser,
) -> "dict[str, argparse.ArgumentParser]":
    """The parsers of the commands, by name."""
    (action,) = (
        a for a in parser._actions if a.dest == argparse.SUPPRESS and a.choices
    )
    return dict(action.choices)  # type: ignore[arg-type]


def add_command(parser: argparse.ArgumentParser, name: str) -> None:
    """Give the parser of a command its arguments, its examples and its function."""
    module = import_module(f"hefting.cli.{name}")
    module.add_arguments(parser)
    parser.set_defaults(run=module.run)
    examples = getattr(module, "EXAMPLES", ())
    if examples:
        parser.epilog = "\n".join(["examples:", *(f"  {line}" for line in examples)])


def sentence(text: str) -> str:
    """A text as a sentence, wrapped."""
    return "\n".join(wrap(text[:1].upper() + text[1:], WIDTH - 1))


def main() -> None:
    """Entry point of ``hefting``. Exit status: 0 done, 2 bad usage or input, 3 done but
    the answer is not to be used, 130 stopped, 1 anything else."""
    if sys.stdout is None:  # it was closed before the start
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 (as long as the process)
    spell_out_signs()
    use_one_thread()
    try:
        try:
            words = _joined(sys.argv[1:])
            arguments = build_parser(words).parse_args(words)
            status = arguments.run(arguments)
        finally:
            sys.stdout.flush()
        if status:
            sys.exit(status)
    except HeftingError as error:
        _fail(render(str(error)), 2 if isinstance(error, InputError) else 1)
    except KeyboardInterrupt as stop:
        _fail(str(stop) or "stopped", STATUS_STOPPED)
    except MemoryError:
        _fail("there is not enough memory; use a shorter recording, a simpler shape", 1)
    except BrokenPipeError:  # the reader of a pipe has ended
        sys.stderr.close()
        sys.exit(1)
    except OSError as error:  # of standard output: files are read and written elsewhere
        _drop_output()
        _fail(f"standard output cannot be written ({error.strerror or error})", 1)


def render(text: str) -> str:
    """A message of the library with options in place of its arguments.

    The library names an argument in backquotes, with a value where it proposes one:
    ```unit`='mm'`` becomes ``--unit mm``. Other words in backquotes stay as they are.
    JSON text may be given whole.
    """
    return re.sub(r"`(\w+)`(?:=(?:'([\w.,:-]*)'|([\w.,:-]*\w)))?", _option, text)


def _option(match: re.Match[str]) -> str:
    from hefting.logs.registry import all_options

    name, quoted, plain = match.groups()
    option, value = OPTIONS.get(name), quoted or plain
    if option is None:
        # options of methods matter only if a command has imported them
        estimators = sys.modules.get("hefting.estimators")
        of_methods = () if estimators is None else estimators.options()
        if name not in of_methods and name not in all_options():
            return match[0]
        option = option_of(name)
    return f"{option} {value}" if value else option


def _joined(words: list[str]) -> list[str]:
    """``--option -1,2`` as ``--option=-1,2``, so that argparse takes it for a value."""
    joined: list[str] = []
    for word in words:
        if (
            joined
            and re.match(r"-\.?\d", word)
            and re.fullmatch(r"--[a-z][a-z0-9-]*", joined[-1])
        ):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def spell_out_signs() -> None:
    """Print signs in ASCII that the encoding of an output does not have."""
    codecs.register_error(SPELL_OUT, spell_out)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=SPELL_OUT)


def _drop_output() -> None:
    """Discard the rest of standard output, which Python would print at its end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str, status: int) -> None:
    say(message)
    sys.exit(status)
