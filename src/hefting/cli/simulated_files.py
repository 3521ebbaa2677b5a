"""Files that hefting simulate writes, of a wrench or of joint torques, and the command
that reads them back."""

import argparse
import json
import shlex
from collections.abc import Iterable
from os.path import realpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli.options import check_place
from hefting.cli.parser import wrote
from hefting.cli.progress import progress
from hefting.core.errors import InputError, printable
from hefting.core.files import check_replaceable, write_atomically

if TYPE_CHECKING:
    from hefting.simulation.objects import HeldObject
    from hefting.simulation.scenario import Scenario, Simulated
    from hefting.simulation.torque_scenario import TorquesSimulated


def truth_of(a: argparse.Namespace) -> Path:
    """Path of the file with the truth.

    `InputError` for an output without a name, as ``.`` or ``/``: a folder that exists.
    """
    if not Path(a.output).name:
        raise InputError("exists already", a.output, "choose another name")
    return Path(a.truth or Path(a.output).with_suffix(".truth.json"))


def check_outputs(a: argparse.Namespace, truth: Path, *more: Path) -> None:
    """`InputError` for an output that cannot or must not be written."""
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
        check_place(path)
        if realpath(path) in map(realpath, outputs[:i]):
            what = "two results would have this name"
            raise InputError(what, path, "choose another name")
        if not Path(path).is_dir():  # the writer of a bag's folder refuses one
            check_replaceable(path, *inputs)
    if truth.suffix.lower() not in ("", ".json"):  # elsewhere --truth is an input
        what = f"'{truth.suffix}' is not JSON, as which --truth is written"
        raise InputError(what, truth, "give it a name that ends in .json")


def write_beside(
    a: argparse.Namespace, held: "HeldObject", facts: dict[str, Any], truth: Path
) -> None:
    """Write the truth (`facts`), and with ``--mesh`` the object's mesh."""
    write_atomically(truth, json.dumps(facts, indent=1) + "\n")
    if a.mesh:
        kind = Path(a.mesh).suffix[1:].lower()
        write_atomically(a.mesh, held.surface.export(file_type=kind))  # type: ignore[arg-type]


def read_back(
    a: argparse.Namespace, scenario: "Scenario", made: "Simulated", truth: Path
) -> str:
    """The command that reads the log back, or why it cannot be read."""
    if made.recording.has("orientation") or (
        made.recording.has("joint_positions") and Path(a.arm).suffix
    ):
        return f"read it back: {_command(a, scenario, truth)}"
    fix = "leave out --pose-rate 0, or give --arm FILE.urdf and --joint-rate"
    return f"hefting identify cannot read it back, as it has no poses: {fix}"


def _command(a: argparse.Namespace, scenario: "Scenario", truth: Path) -> str:
    """The ``hefting identify`` command that reads the log back."""
    from scipy.spatial.transform import Rotation

    words = ["hefting", "identify", a.output]
    shape = a.mesh or (a.object if a.density and "," not in a.object else None)
    if shape:
        pose = scenario.held.pose
        seven = (*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat())
        unit = ["--unit", a.unit] if a.unit and not a.mesh else []
        words += ["--shape", shape, *unit]
        words += ["--object-pose", ",".join(f"{number + 0.0:.9g}" for number in seven)]
    if a.tilt:
        words += ["--gravity", ",".join(f"{number:.9g}" for number in scenario.gravity)]  # type: ignore[union-attr]
    if a.pose_rate == 0.0 and Path(a.arm).suffix:
        words += ["--urdf", a.arm, "--sensor-frame", a.sensor_frame]
    return shlex.join([*words, "--truth", str(truth)])


LASTS = 30.0
"""[s] Default duration of each run."""
TAKEN = {
    *("output", "torques", "object", "density", "unit", "object_pose", "arm"),
    *("duration", "rate", "seed", "truth", "mesh", "run", "help"),
}
"""Arguments that are used with torques."""
RENAMED = {"ur5": "ur5e"}
"""Arms whose model has no masses, and the model that is used instead."""


def beside(output: Path) -> tuple[Path, Path]:
    """Paths of the empty run and the URDF for a log."""
    mark = ".empty" if output.suffix else "-empty"  # a folder's name has no suffix
    empty = output.with_name(f"{output.stem}{mark}{output.suffix}")
    return empty, output.with_suffix(".urdf")


def check_options(a: argparse.Namespace, actions: Iterable[argparse.Action]) -> None:
    """`InputError` for an option that is not used with torques."""
    for action in actions:
        if action.dest not in TAKEN and getattr(a, action.dest) != action.default:
            option = action.option_strings[-1]
            raise InputError("is for a wrench", option, "leave it out with --torques")


def simulate_torques(a: argparse.Namespace, held: "HeldObject", truth: Path) -> None:
    """Simulate, write, and print a description and the command that reads it."""
    from hefting.logs import write_log
    from hefting.simulation.torque_scenario import TorqueScenario

    output = Path(a.output)
    empty, urdf = beside(output)
    duration = LASTS if a.duration is None else a.duration
    arm: str = RENAMED.get(a.arm.lower()) or a.arm.lower()
    scenario = TorqueScenario(held, arm, duration, a.rate, seed=a.seed)
    with progress("simulating", stages={"simulating": 1.0}):
        made = scenario.run()
        for recording, path in ((made.loaded, output), (made.empty, empty)):
            lost = write_log(recording, path)
            if lost:
                what = "the format cannot hold joint torques"
                raise InputError(what, path, "write .csv, .parquet or a bag")
        write_atomically(urdf, made.urdf)
        write_beside(a, held, made.facts, truth)
    _describe(made, held, duration)
    wrote(*(path for path in (output, empty, urdf, truth, a.mesh) if path))
    words = ["hefting", "identify", str(output), "--torques", "--urdf", str(urdf)]
    words += ["--sensor-frame", "flange", "--empty", str(empty)]
    print(printable(f"read it back: {shlex.join([*words, '--truth', str(truth)])}"))


def _describe(made: "TorquesSimulated", held: "HeldObject", duration: float) -> None:
    about, mass = made.facts["simulation"], held.parameters.mass
    on = f"on the arm {about['arm']}; torques from {about['engine']}"
    print(printable(f"{held.name}, {mass:.4g} kg, {on}"))
    print(f"two runs of {duration:g} s, empty and loaded, seed {about['seed']}")
