"""hefting simulate --torques: an empty and a loaded run of an arm that measures the
torques of its joints, and what is needed to identify from them."""

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli.progress import progress
from hefting.cli.simulated_files import write_beside
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.core.plain_text import typed

if TYPE_CHECKING:
    from hefting.simulation.objects import HeldObject
    from hefting.simulation.torque_scenario import TorquesSimulated

LASTS = 30.0
"""[s] Either run, where nothing else is said."""
TAKEN = {
    *("output", "torques", "object", "density", "unit", "object_pose", "arm"),
    *("duration", "rate", "seed", "truth", "mesh", "run", "help"),
}
"""Arguments that mean something with torques."""
RENAMED = {"ur5": "ur5e"}
"""Arms of which another has masses."""


def beside(output: Path) -> tuple[Path, Path]:
    """The empty run and the URDF that go with a log."""
    stem = output.with_suffix("").name
    empty = output.with_name(f"{stem}.empty{output.suffix}")
    return empty, output.with_name(f"{stem}.urdf")


def check_options(a: argparse.Namespace, actions: Iterable[argparse.Action]) -> None:
    """`InputError` for an option that means nothing with torques."""
    for action in actions:
        if action.dest not in TAKEN and getattr(a, action.dest) != action.default:
            option = action.option_strings[-1]
            raise InputError("is for a wrench", option, "leave it out with --torques")


def simulate_torques(a: argparse.Namespace, held: "HeldObject", truth: Path) -> None:
    """Simulate, write, and print what was made and how to read it."""
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
    _tell(made, held, duration)
    paths = [path for path in (output, empty, urdf, truth, a.mesh) if path]
    print("wrote:", *(f"  {path}" for path in paths), sep="\n")
    words = ["hefting", "identify", str(output), "--torques", "--urdf", str(urdf)]
    words += ["--sensor-frame", "flange", "--empty", str(empty)]
    print(f"read it back: {typed([*words, '--truth', str(truth)])}")


def _tell(made: "TorquesSimulated", held: "HeldObject", duration: float) -> None:
    about, mass = made.facts["simulation"], held.parameters.mass
    print(
        f"{held.name}, {mass:.4g} kg, on the arm {about['arm']}; torques from "
        f"{about['engine']}"
    )
    print(f"two runs of {duration:g} s, empty and loaded, seed {about['seed']}")
