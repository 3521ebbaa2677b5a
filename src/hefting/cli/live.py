"""hefting live: mass, COM and inertia while the robot moves, from the streams it
sends."""

import argparse
import gc
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import render
from hefting.cli.export import print_exported
from hefting.cli.identify import add_hyperparameters
from hefting.cli.live_record import LiveRecord, interrupted_by_signals
from hefting.cli.options import (
    add_export,
    add_gravity,
    add_log_options,
    add_mass,
    add_number,
    add_output,
    add_sensor_accuracy,
    add_shape,
    add_shape_details,
    add_tool,
    add_verbose,
    add_wrench,
    check_output,
    fill_inertia_of,
    flange_of,
)
from hefting.cli.outputs import (
    STATUS_NOT_WRITTEN,
    open_page,
    print_object,
    wanted,
    write,
)
from hefting.cli.parser import say
from hefting.cli.report import STATUS_DO_NOT_USE, exit_status
from hefting.cli.report.live import display_of, no_answer
from hefting.cli.report.results import Results, print_results
from hefting.core.errors import InputError, MissingDependencyError
from hefting.request.settings import (
    gravity_of,
    hyperparameters_of,
    require_shape,
    robot_of,
    sensor_pose_of,
    shape_of,
)

if TYPE_CHECKING:
    from hefting.core.messages import Message
    from hefting.online import LiveEstimate, LiveIdentifier
    from hefting.online.samples import Samples
    from hefting.shapes import Shape
    from hefting.sources import Request
    from hefting.sources.live import Pump

EXAMPLES = (
    "hefting live ws://robot:8765 --shape mug.stl --object-pose 0,0,0.1,0,0,0,1",
    "hefting live zenoh://robot/0 --until mass=1%,com=2mm --export-to ur",
    "hefting live dds://0 --wrench-topic /ft_sensor --record log.mcap",
    "hefting live rtde://192.168.0.2 --json",
    "hefting live log.csv --speed 10",
    "my_driver | hefting live -",
)

FASTEST = 100.0
"""Largest speed of a played log with which estimates keep up."""

ROLES = ("wrench", "pose", "joint", "imu")
"""Roles whose topics can be named."""

PRINTED_AT_END = ("live-part-used", "live-nothing-held", "live-not-kept", "live-failed")
"""Codes of messages on the part that the final answer is from, and on the end of the
live ones."""

STEP = 0.2
"""[s] Longest wait for an estimate between two looks at the source."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting live``."""
    from hefting.estimators import default_method

    parser.add_argument(
        "source",
        metavar="SOURCE",
        help="ws://HOST:PORT (foxglove_bridge), zenoh://HOST, dds://DOMAIN, "
        "rtde://HOST, tcp://HOST:PORT or - (lines of JSON), or a log to be played; "
        "Ctrl-C ends it with the final answer",
    )
    add_shape(parser)
    add_tool(parser)
    parser.add_argument(
        "--method",
        metavar="NAME",
        help=f"see hefting methods; default {default_method(True)}",
    )
    add_mass(parser)
    parser.add_argument(
        "--until",
        metavar="ACCURACY",
        help="say when it is so sure (95 %%), as in mass=1%%,com=2mm,inertia=20%%",
    )
    parser.add_argument(
        "--record", metavar="FILE.mcap", help="write what comes in, as it comes"
    )
    parser.add_argument(
        "--view",
        action="store_true",
        help="show it in a browser, too: numbers, intervals, wrench, object in 3D",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="with --view: do not open one"
    )
    _add_results(parser)
    parser.add_argument(
        "--json",
        action="store_true",
        help="print one JSON object a line and nothing else",
    )
    add_verbose(parser)
    add_shape_details(parser.add_argument_group("more on the object's shape"))
    _add_reading(add_log_options(parser))
    add_hyperparameters(parser.add_argument_group("methods"))


def _add_results(parser: argparse.ArgumentParser) -> None:
    from hefting.export import SUFFIXES, TARGETS
    from hefting.logs.registry import join_words

    parser.add_argument(
        "--export-to",
        metavar="TARGET",
        help=f"print the final answer for {join_words(TARGETS, 'or')}",
    )
    add_output(parser, f"the final answer to {join_words(SUFFIXES, 'or')}")
    add_export(parser.add_argument_group("results"))


def _add_reading(group: argparse._ActionsContainer) -> None:
    add_wrench(group, "auto, none, estimate or a JSON file")
    add_gravity(group)
    add_sensor_accuracy(group)
    add_number(group, "--rate", "HZ", "estimates a second; default 10", default=10.0)
    add_number(
        group,
        "--speed",
        "FACTOR",
        "how fast a log is played, at most 100 times; default 1",
        default=1.0,
    )


def run(arguments: argparse.Namespace) -> int:
    """Show estimates until the source ends or Ctrl-C, then the final answer; returns
    the exit status."""
    try:
        return _run(arguments)
    except MissingDependencyError as error:
        raise InputError(str(error)) from error


def _run(a: argparse.Namespace) -> int:
    from hefting.online import LiveIdentifier
    from hefting.sources import source_of
    from hefting.sources.live import Pump, with_skipped

    require_shape(a)
    _check_outputs(a)
    flange = flange_of(a)
    source = source_of(a.source, _request(a))
    shape = shape_of(a)
    fill = fill_inertia_of(a.fill_inertia, shape)
    display = display_of(a.json, render)
    record = LiveRecord(a.record, display.say)
    with _view(a, shape) as view, LiveIdentifier(shape, **_settings(a)) as identifier:

        def deliver(samples: "Samples") -> None:
            record.add(samples)
            identifier.add(samples)

        def tell(message: "Message") -> None:
            identifier.say(message)
            if a.verbose or message.severity != "note" or "source" in message.code:
                display.say(render(message))

        gc.freeze()  # to collect the imported objects takes some 25 ms
        try:
            with Pump(source, deliver, tell) as pump:
                _follow(pump, identifier, display, view)
        finally:
            display.end()
            record.close()
        if pump.error is not None:
            raise pump.error
        found = identifier.close(record.whole)
        if found is not None:
            found = with_skipped(found, pump.source)
            view(found)
    record.report()
    if found is None or found.estimate is None:
        say(no_answer(found, render))
        return STATUS_DO_NOT_USE
    return _finish(a, found, fill, flange) or (
        STATUS_NOT_WRITTEN if record.failed else 0
    )


@contextmanager
def _view(
    a: argparse.Namespace, shape: "Shape | None"
) -> "Generator[Callable[[LiveEstimate], None], None, None]":
    """A function that shows an estimate in browsers; without ``--view`` it does
    nothing."""
    if not a.view:
        yield lambda found: None
        return
    from hefting.viewer.live import LiveView
    from hefting.viewer.server import address_of, serving

    with serving() as server:
        view = LiveView(server, shape, render)
        address = address_of(server)
        say(f"in a browser: {address}")
        if not a.no_browser:
            open_page(address)
        try:
            yield view.show
            view.settle()
        finally:
            view.close()


def _follow(
    pump: "Pump",
    identifier: "LiveIdentifier",
    display: Any,
    view: "Callable[[LiveEstimate], None]",
) -> None:
    """Show estimates until the source ends, or Ctrl-C or a signal, as of ``timeout`` or
    a closed terminal, comes."""
    from hefting.sources.live import with_skipped

    with suppress(KeyboardInterrupt), interrupted_by_signals():
        while not pump.wait(0.0):
            found = identifier.wait(STEP)
            if found is not None:
                found = with_skipped(found, pump.source)
                display.show(found, pump)
                view(found)


def _finish(
    a: argparse.Namespace, found: "LiveEstimate", fill: Any, flange: Any
) -> int:
    from hefting.export import export

    estimate = found.estimate
    assert estimate is not None
    written, failure = [], None
    try:
        written = write(wanted(a, estimate), estimate, flange, a.accept, fill)
    except InputError as error:  # raised once the answer is shown: the stream is over
        failure = error
    method = estimate.method
    if a.json:
        print_object(found)
    else:
        for message in found.messages:
            if message.code in PRINTED_AT_END:
                say(render(message))
        results = Results({method: estimate}, method, None, None, {}, written)
        print_results(results, render, a.verbose)
    if failure is not None:
        raise failure
    if a.export_to:
        exported = export(
            estimate,
            a.export_to,
            flange,
            accept=a.accept,
            fill_inertia=fill,
            say=render,
        )
        print_exported(exported)
    is_left_out = len(written) < len(a.output)
    return exit_status(estimate.verdict) or (STATUS_NOT_WRITTEN if is_left_out else 0)


def _check_outputs(a: argparse.Namespace) -> None:
    from hefting.export import SUFFIXES, TARGETS

    if a.record:
        check_output(a.record, a)
    for path in a.output:
        if Path(path).suffix not in SUFFIXES:
            what = f"'{Path(path).suffix}' is not an output format"
            raise InputError(what, path, f"use {', '.join(SUFFIXES)}")
        check_output(path, a)
    if a.export_to and a.export_to not in TARGETS:
        what = f"unknown target '{a.export_to}'"
        raise InputError(what, "--export-to", f"use {', '.join(TARGETS)}")
    if a.export_to and a.json:
        what = "prints text, and --json prints JSON only"
        raise InputError(what, "--export-to", "use --output, or leave out one of them")


def _request(a: argparse.Namespace) -> "Request":
    from hefting.request.settings import recording_of
    from hefting.sources import Request

    if not 0 < a.speed <= FASTEST:
        what = f"{a.speed:g} is not above 0 and at most {FASTEST:g}"
        raise InputError(what, "--speed", "use hefting identify for a whole log")
    for option, is_given in (("--map", a.map), ("--speed", a.speed != 1.0)):
        if is_given and _is_live(a.source):
            raise InputError("is for logs only", option, "leave it out")
    named = ((role, getattr(a, f"{role}_topic")) for role in ROLES)
    topics = {role: name for role, name in named if name}
    if a.urdf:
        topics.setdefault("pose", "none")
    return Request(
        topics=topics,
        world_frame=a.world_frame,
        sensor_frame=None if a.urdf else a.sensor_frame,
        speed=a.speed,
        read=lambda path: recording_of(a, path),
    )


def _is_live(source: str) -> bool:
    return "://" in source or source == "-"


def _settings(a: argparse.Namespace) -> dict[str, Any]:
    settings = hyperparameters_of(a)
    settings |= {"gravity": gravity_of(a), "sign": a.wrench}
    settings |= {"rate": a.rate, "bias": a.bias, "tool": a.tool}
    if a.method is not None:
        settings["method"] = a.method
    if _is_live(a.source):  # reading a log uses them already
        settings["robot"] = robot_of(a) if a.urdf else None
        settings["sensor_pose_in_log"] = sensor_pose_of(a)
    return settings
