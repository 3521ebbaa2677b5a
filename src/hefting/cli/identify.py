"""hefting identify: find mass, COM and inertia of the object in one or several
recordings."""

import argparse
import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import option_of, render
from hefting.cli.options import (
    add_export,
    add_gravity,
    add_mass,
    add_motion,
    add_output,
    add_part,
    add_recording,
    add_sensor_accuracy,
    add_shape,
    add_shape_details,
    add_tool,
    add_wrench,
    check_output,
    fill_inertia_of,
    flange_of,
    read_recording,
)
from hefting.cli.outputs import (
    STATUS_NOT_WRITTEN,
    add_report,
    check_report,
    draw_pictures,
    identified,
    is_picture,
    no_output_format,
    wanted,
    write,
    write_report,
)
from hefting.cli.progress import progress
from hefting.cli.report.results import Results, print_json, print_results
from hefting.cli.torques import add_empty, add_torques, require_torques
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.request.settings import (
    hyperparameters_of,
    reading_of,
    require_shape,
    shape_of,
)

if TYPE_CHECKING:
    from hefting.core.accuracy import Errors
    from hefting.core.estimate import Estimate
    from hefting.core.recording import Recording
    from hefting.identification.compare import Comparison
    from hefting.identification.identify import Identification
    from hefting.identification.truth import Truth
    from hefting.shapes import Shape


EXAMPLES = (
    "hefting identify log.csv",
    "hefting identify log.csv --shape mug.stl --object-pose 0,0,0.1,0,0,0,1",
    "hefting identify log.csv --box 0.1,0.2,0.3 --output mug.json --output mug.urdf",
    "hefting identify log.bag --tool gripper.json --start 2 --duration 10",
    "hefting identify log.csv --map map.toml --method all --truth truth.json",
    "hefting identify monday.csv tuesday.csv",
    "hefting identify held.mcap --torques --urdf arm.urdf --sensor-frame tool",
    "zcat log.csv.gz | hefting identify - --json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting identify``."""
    _add_common(parser)
    add_shape_details(parser.add_argument_group("more on the object's shape"))
    log = add_recording(
        parser, what="recording, or several of one object in one grasp", count="+"
    )
    add_reading(log)
    _add_methods(parser.add_argument_group("methods"))
    torques = parser.add_argument_group("joint torques in place of a wrench")
    add_torques(torques)
    add_empty(torques)
    add_export(parser.add_argument_group("results"))


def _add_common(parser: argparse.ArgumentParser) -> None:
    """Options that most users need."""
    from hefting.estimators import default_method

    add_shape(parser)
    add_tool(parser)
    parser.add_argument(
        "--method",
        metavar="NAME[,NAME...]|all",
        help=f"see hefting methods; default {default_method(True)}. "
        "Of several, one is recommended",
    )
    add_mass(parser)
    parser.add_argument(
        "--truth",
        metavar="FILE",
        help="true parameters or another estimate, to compare with (JSON)",
    )
    add_output(parser, _formats)
    add_report(parser)


def add_reading(log: argparse._ActionsContainer) -> None:
    """Options on the part of the recording and its conventions."""
    add_part(log)
    add_wrench(log, "auto, none, estimate, tare:START,END, six numbers or a JSON file")
    add_motion(log)
    add_gravity(log)
    add_sensor_accuracy(log)


def _add_methods(group: argparse._ActionsContainer) -> None:
    from hefting.estimators import methods_with

    group.add_argument(
        "--until",
        metavar="ACCURACY",
        help=f"{', '.join(methods_with('until'))}: use only as much as makes it this "
        "sure (95 %%), as in mass=1%%,com=2mm,inertia=20%%",
    )
    add_hyperparameters(group)


def add_hyperparameters(group: argparse._ActionsContainer) -> None:
    """Options for the numbers that methods take."""
    from hefting.estimators import options

    for name, option in options().items():
        text = option.help.replace("%", "%%")
        group.add_argument(
            option_of(name), type=float, metavar=option.metavar, help=text
        )


def _formats() -> str:
    """Suffixes of files that can be written, with the format's name unless its suffix
    contains it."""
    from hefting.export import SUFFIXES
    from hefting.logs.registry import join_words
    from hefting.plots.style import FORMATS

    names = [
        suffix if name in suffix else f"{suffix} ({name.upper()})"
        for suffix, name in SUFFIXES.items()
    ]
    return join_words([*names, f"a picture ({', '.join(FORMATS)})"], "or")


def run(arguments: argparse.Namespace) -> int:
    """Identify, write the outputs, and print the result; returns the exit status."""
    from hefting.identification.truth import load_truth

    a = arguments
    require_shape(a)
    _check_outputs(a)
    require_torques(a)
    if a.torques:
        return _run_torques(a)
    reading = reading_of(a)
    flange = flange_of(a)
    known = load_truth(a.truth) if a.truth else None

    with progress("identifying", a.json):
        from hefting.identification import identify

        recording = _recordings(a)
        shape = shape_of(a)
        fill = fill_inertia_of(a.fill_inertia, shape)
        asked = hyperparameters_of(a)
        found = identify(recording, shape, method=a.method, **reading, **asked)
    comparison, estimates, best = _estimates(a, found)
    truth = known.parameters if known else None
    outputs = wanted(a, estimates[best])
    pictures = draw_pictures(outputs, found.ingested, estimates[best], shape, truth)
    with progress("drawing", a.json):
        page = identified(a.report, found, estimates[best], shape, truth, flange)
    errors = _errors(known, estimates, shape)
    texts = [path for path in outputs if path not in pictures]
    written = write(texts, estimates[best], flange, a.accept, fill)
    for path, content in pictures.items():
        write_atomically(path, content)
    pages = write_report(a.report, page)
    results = Results(
        estimates, best, comparison, truth, errors, written, (*pictures, *pages)
    )
    return _print_results(a, results, outputs)


def _run_torques(a: argparse.Namespace) -> int:
    """`run` with joint torques: without pictures, which show a wrench."""
    from hefting.cli.torques import identified as by_torques
    from hefting.identification.truth import load_truth

    pictures = [path for path in a.output if is_picture(path)]
    if pictures:
        raise InputError("a picture shows a wrench", pictures[0], "leave it out")
    flange = flange_of(a)
    known = load_truth(a.truth) if a.truth else None
    with progress("identifying", a.json):
        shape = shape_of(a)
        fill = fill_inertia_of(a.fill_inertia, shape)
        estimate = by_torques(a, shape)
    best = estimate.method
    estimates = _note_shape(a, {best: estimate})
    outputs = wanted(a, estimates[best])
    truth = known.parameters if known else None
    errors = _errors(known, estimates, shape)
    written = write(outputs, estimates[best], flange, a.accept, fill)
    results = Results(estimates, best, None, truth, errors, written, ())
    return _print_results(a, results, outputs)


def _errors(
    known: "Truth | None", estimates: "dict[str, Estimate]", shape: "Shape | None"
) -> "dict[str, Errors]":
    """Errors of the estimates, where the truth and the object's size are known."""
    if known is None or (known.extents is None and shape is None):
        return {}
    return {k: known.errors(e.parameters, shape) for k, e in estimates.items()}


def _print_results(
    a: argparse.Namespace, results: Results, outputs: "list[str]"
) -> int:
    """Print the results; returns the exit status. `outputs` are the files of
    ``--output`` that could be written."""
    from hefting.cli.report import exit_status

    if a.json:
        print_json(results, render)
    else:
        print_results(results, render, a.verbose)
    is_left_out = len(outputs) < len(a.output)
    status = exit_status(results.estimates[results.best].verdict)
    return status or (STATUS_NOT_WRITTEN if is_left_out else 0)


def _recordings(a: argparse.Namespace) -> "list[Recording]":
    """The logs, read with the same options."""
    if a.poses and len(a.log) > 1:
        raise InputError("are those of one log", "--poses", "convert each log first")
    given: set[str] = set()
    for log in a.log:
        if os.path.realpath(log) in given:
            raise InputError("is given twice", log, "give each recording once")
        given.add(os.path.realpath(log))
    each = [argparse.Namespace(**(vars(a) | {"log": log})) for log in a.log]
    return [read_recording(one) for one in each]


def _note_shape(
    a: argparse.Namespace, estimates: "dict[str, Estimate]"
) -> "dict[str, Estimate]":
    """The estimates, with the file of the shape in their provenance."""
    made = {}
    if a.shape or a.box:
        spec = a.shape or f"--box {a.box}"
        made = {"shape": spec, "unit": a.unit, "object_pose": a.object_pose}
    if a.hull:
        made["hull"] = True
    return {k: replace(e, provenance=e.provenance | made) for k, e in estimates.items()}


def _estimates(
    a: argparse.Namespace, found: "Comparison | Identification"
) -> "tuple[Comparison | None, dict[str, Estimate], str]":
    """The comparison, if any, the estimates by method, and the recommended method."""
    from hefting.identification.compare import Comparison

    if isinstance(found, Comparison):
        return found, _note_shape(a, found.results), found.recommended
    name = found.estimate.method
    return None, _note_shape(a, {name: found.estimate}), name


def _check_outputs(a: argparse.Namespace) -> None:
    """`InputError` for an output that cannot or must not be written."""
    check_report(a)
    if not a.output:
        return
    from hefting.export import SUFFIXES
    from hefting.plots.style import FORMATS, picture_suffix

    for path in a.output:
        if is_picture(path):
            picture_suffix(path)
        elif Path(path).suffix not in SUFFIXES:
            raise no_output_format(path, (*SUFFIXES, *FORMATS))
        check_output(path, a)
